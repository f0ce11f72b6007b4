"""Spending the slack of a plan on a cheaper trajectory.

Driving a cell in d seconds costs J / d. Within the windows of the crossings, from the planned instant to its
slack later, and the times that the moves may take, the least sum is found
(:mod:`mitlplan.trajectory.timetable`); where nothing binds, the durations are in proportion to sqrt(J).

A slack is that of one way point alone, so the windows promise nothing together: the plan is judged again,
and as long as it is refused its crossings go back half of the way to where they were. The sum is convex, so
each plan on the way costs no more than the first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from mitlplan.errors import TrajectoryError
from mitlplan.plan import Plan
from mitlplan.trajectory.timetable import Span, Window, cheapest_times

_MOST_RETREATS = 10


def retime(
    plan: Plan, spans: Sequence[Span], accepts: Callable[[Plan], bool], deadline: Fraction | None = None
) -> Plan:
    """The same cells at the times that cost least, where `accepts` agrees.

    Parameters
    ----------
    plan
        With the slack of its steps.
    spans
        For each step that is left by a move, in order.
    accepts
        The judge: whether a plan still satisfies the mission.
    deadline
        When the last crossing must have been made, in seconds; ``None``: at the makespan of `plan`.

    Raises
    ------
    TrajectoryError
        If the deadline is before the makespan, or a step of the plan is shorter than its span allows.

    Examples
    --------
    >>> from mitlplan.plan import Step
    >>> steps = (Step("a", Fraction(0), Fraction(1)), Step("b", Fraction(1), Fraction(2), slack=None),
    ...          Step("c", Fraction(2), Fraction(2), slack=None))
    >>> slower = retime(
    ...     Plan(steps, makespan=Fraction(2)), [Span(1.0, Fraction(1)), Span(4.0, Fraction(1))],
    ...     lambda _: True, deadline=Fraction(6))
    >>> print(slower)
    0 a -> 2 b -> 6 c
    """
    latest = plan.makespan if deadline is None else deadline
    if latest < plan.makespan:
        raise TrajectoryError(f"the deadline {latest} is before the makespan {plan.makespan}")
    times = _crossings(plan)
    wanted = cheapest_times(spans, _windows(plan, times, latest))
    for retreat in range(_MOST_RETREATS):
        share = Fraction(1, 2**retreat)
        found = _moved(plan, [now + share * (then - now) for now, then in zip(times, wanted, strict=True)])
        if accepts(found):
            return found
    return plan


def _crossings(plan: Plan) -> list[Fraction]:
    """When each step is entered, and for a plan that goes round when the loop is closed."""
    entered = [step.enter for step in plan.steps]
    return [*entered, plan.makespan] if _goes_round(plan) else entered


def _goes_round(plan: Plan) -> bool:
    return plan.loop is not None and plan.loop.period is not None


def _windows(plan: Plan, times: Sequence[Fraction], latest: Fraction) -> list[Window]:
    windows = []
    for number, step in enumerate(plan.steps):
        slack = latest - step.enter if step.slack is None else min(step.slack, latest - step.enter)
        # The period of a loop must stay what it is, so its first crossing stays where it is.
        fixed = number == 0 or (_goes_round(plan) and plan.loop is not None and number == plan.loop.start)
        windows.append((step.enter, step.enter + (0 if fixed else max(slack, Fraction(0)))))
    windows += [(time, time) for time in times[len(windows) :]]
    return windows


def _moved(plan: Plan, times: Sequence[Fraction]) -> Plan:
    """The plan with its crossings at `times`; nothing is known of its slack."""
    leaves: list[Fraction | None] = list(times[1:])
    if not _goes_round(plan):
        last = plan.steps[-1]
        leaves.append(None if last.leave is None else max(last.leave, times[-1]))
    steps = tuple(
        replace(step, enter=enter, leave=leave, slack=Fraction(0))
        for step, enter, leave in zip(plan.steps, times, leaves, strict=False)
    )
    last_leave = steps[-1].leave
    return replace(plan, steps=steps, makespan=steps[-1].enter if last_leave is None else last_leave)
