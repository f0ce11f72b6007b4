"""Answers for people at a terminal: a table of way points, a line that sums up, and what the search cost.

A long plan is mostly moves on which nothing changes; the table then keeps the way points at which a
proposition comes or goes, the first, the last and the start of the loop, and counts the cells between them.
JSON and CSV have them all.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from fractions import Fraction

from rich.console import Console
from rich.table import Table

from mitlplan.plan import Infeasible, LimitReached, Outcome, Plan, Statistics

_ALL_SHOWN = 40
"""Plans of up to so many way points are shown whole."""


def plan_to_text(outcome: Outcome, *, colours: bool = False, width: int = 100) -> str:
    """What to show of `outcome`.

    Parameters
    ----------
    outcome
        The planner's answer.
    colours
        Whether to use a terminal's colours.
    width
        Of the terminal, in characters.

    Examples
    --------
    >>> print(plan_to_text(Infeasible("B is out of reach before 2.", conflict=("a", "b"))), end="")
    No plan: B is out of reach before 2.
    Together impossible on this map: a, b
    """
    text = io.StringIO()
    console = Console(
        file=text,
        force_terminal=colours,
        color_system="standard" if colours else None,
        width=width,
        highlight=False,
        markup=False,
        emoji=False,
        legacy_windows=False,
    )
    match outcome:
        case Plan():
            _show_plan(console, outcome)
        case Infeasible():
            console.print(f"No plan: {outcome.reason}", style="bold red", soft_wrap=True)
            if outcome.conflict:
                names = ", ".join(outcome.conflict)
                console.print(f"Together impossible on this map: {names}", soft_wrap=True)
        case LimitReached():
            console.print(f"Stopped: {outcome.reason}", style="bold yellow", soft_wrap=True)
            if outcome.bound is not None:
                console.print(f"No plan is faster than {outcome.bound}.", soft_wrap=True)
    _show_statistics(console, outcome.statistics)
    return text.getvalue()


def _show_plan(console: Console, plan: Plan) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold", collapse_padding=True)
    table.add_column("time", justify="right", no_wrap=True)
    table.add_column("cell", no_wrap=True)
    table.add_column("stay", justify="right", no_wrap=True)
    table.add_column("holds", style="green")
    table.add_column("slack", justify="right", no_wrap=True)
    before = -1
    for number in _shown(plan):
        if number > before + 1:
            skipped = number - before - 1
            table.add_row("", f"... {skipped} {'cell' if skipped == 1 else 'cells'}", "", "", "", style="dim")
        table.add_row(*_row(plan, number))
        before = number
    console.print(table)
    console.print(_ending(plan), soft_wrap=True)
    console.print(_summary(plan), style="bold", soft_wrap=True)
    if plan.fault is not None:
        console.print(f"violated, says the judge: {plan.fault}", style="bold red", soft_wrap=True)


def _row(plan: Plan, number: int) -> tuple[str, str, str, str, str]:
    step = plan.steps[number]
    stay = "for ever" if step.leave is None else str(step.leave - step.enter)
    slack = "any" if step.slack is None else str(step.slack)
    return str(step.enter), step.cell, stay, ", ".join(step.holds), slack


def _shown(plan: Plan) -> Iterator[int]:
    last = len(plan.steps) - 1
    for number, step in enumerate(plan.steps):
        if (
            last < _ALL_SHOWN
            or number in (0, last)
            or (plan.loop is not None and number == plan.loop.start)
            or step.holds != plan.steps[number - 1].holds
        ):
            yield number


def _ending(plan: Plan) -> str:
    match plan.loop:
        case None:
            return f"done at {plan.steps[-1].leave}"
        case loop if loop.period is None:
            return f"parks in {plan.steps[-1].cell}"
        case loop:
            first, last = plan.steps[loop.start], plan.steps[-1]
            return (
                f"loop: at {last.leave} on to {first.cell}, and so on from {first.enter}, "
                f"a round every {loop.period}"
            )


def _summary(plan: Plan) -> str:
    checked = "checked" if plan.checked else "not checked"
    moves = len(plan.steps) - 1
    size = f"{moves} {'move' if moves == 1 else 'moves'}"
    if not plan.attained and plan.bound not in (None, plan.makespan):
        return (
            f"makespan within {plan.epsilon} of {plan.makespan} "
            f"(none is below {plan.bound}, {size}, {checked})"
        )
    if not plan.attained:
        return (
            f"infimum {plan.makespan}, which no plan attains; this one is within {plan.epsilon} "
            f"({size}, {checked})"
        )
    if plan.bound == plan.makespan:
        proved = "fastest"
    else:
        proved = f"none is below {plan.bound}" if plan.bound else "not proved to be the fastest"
    return f"makespan {plan.makespan} ({_decimal(plan.makespan)}{proved}, {size}, {checked})"


def _decimal(time: Fraction) -> str:
    return "" if time.denominator == 1 else f"about {float(time):.6g}, "


def _show_statistics(console: Console, statistics: Statistics) -> None:
    if statistics == Statistics():
        return
    seconds = sum(statistics.seconds.values())
    by = "" if statistics.engine == Statistics().engine else f", {statistics.engine}"
    console.print(
        f"{statistics.construction}{by}: {statistics.locations} locations, {statistics.edges} edges, "
        f"{statistics.zones} zones, {seconds:.2f} s",
        style="dim",
        soft_wrap=True,
    )
