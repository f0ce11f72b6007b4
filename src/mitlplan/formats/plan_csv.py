"""Plans as CSV, a line for each stay, for spreadsheets and scripts.

``next`` is the number of the stay that follows: it jumps back at the end of a loop, is the stay itself where
the robot parks, and is empty where the plan ends. An answer that is no plan is the header alone.
"""

from __future__ import annotations

import csv
import io

from mitlplan.plan import Outcome, Plan

COLUMNS = ("step", "cell", "enter", "leave", "holds", "slack", "next")


def plan_to_csv(outcome: Outcome) -> str:
    """The stays of `outcome`; times in seconds, exact, and several propositions with spaces between.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from mitlplan.plan import Step
    >>> steps = (Step("r0c0", Fraction(0), Fraction(7, 2), ("A", "B"), Fraction(1)),)
    >>> print(plan_to_csv(Plan(steps, makespan=Fraction(7, 2))), end="")
    step,cell,enter,leave,holds,slack,next
    0,r0c0,0,7/2,A B,1,
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    if isinstance(outcome, Plan):
        for number, step in enumerate(outcome.steps):
            leave = "" if step.leave is None else step.leave
            slack = "" if step.slack is None else step.slack
            following = _next(outcome, number)
            writer.writerow((number, step.cell, step.enter, leave, " ".join(step.holds), slack, following))
    return text.getvalue()


def _next(plan: Plan, number: int) -> int | str:
    if number + 1 < len(plan.steps):
        return number + 1
    return "" if plan.loop is None else plan.loop.start
