"""Spending the time that a mission leaves on a cheaper trajectory.

Driving a cell in d seconds costs J / d, so along the cells of a plan the sum of J_i / d_i is to be least over
all times that the map, the robot, the deadline and the mission allow. Without the mission that is a convex
problem (:mod:`mitlplan.trajectory.timetable`); where nothing binds, the durations are in proportion to
sqrt(J_i). The times that satisfy a mission are a union of convex sets, each of them cut out by differences of
crossings, so the rest is branch and bound. The best times so far are shown to the judge. If it agrees, they
are the best of all, for nothing cheaper is left. If not, one is told what it is about these times that the
mission forbids, as a few differences: at least one of them must change, and each gives a branch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from heapq import heappop, heappush
from itertools import count, pairwise
from typing import TypeAlias

from mitlplan.errors import TrajectoryError
from mitlplan.plan import Plan
from mitlplan.trajectory.timetable import TICK, Apart, Span, Window, cheapest_times

Reasons: TypeAlias = Callable[[Plan], Sequence[Apart] | None]

MOST_QUESTIONS = 1000
"""So many times the judge is asked at most."""

_MOST_RETREATS = 10


@dataclass(frozen=True, slots=True)
class Retimed:
    """A plan with other times.

    Parameters
    ----------
    plan
        The same cells; nothing is known of the slack of its steps.
    cost
        The sum of cost / duration over the spans.
    bound
        No times that the mission allows cost less, but for rounding; equal to `cost` if these are the best.
    """

    plan: Plan
    cost: float
    bound: float


def retime(
    plan: Plan,
    spans: Sequence[Span],
    accepts: Callable[[Plan], bool],
    *,
    reasons: Reasons = lambda _: None,
    deadline: Fraction | None = None,
) -> Retimed:
    """The same cells at the times that cost least, among those that `accepts` agrees to.

    Parameters
    ----------
    plan
        One that is accepted. If it goes round for ever it keeps its period, and the time at which the loop
        begins.
    spans
        For each step that is left by a move, in order.
    accepts
        The judge: whether a plan still satisfies the mission.
    reasons
        For a plan that is refused differences that it keeps, such that every plan of the same cells that
        keeps them is refused. Crossing k is the entry of step k, and behind the last one the end of the plan.
        ``None``: not known; then the times go half of the way back to where they were, and again.
    deadline
        When the plan must have ended, in seconds; ``None``: at its makespan.

    Raises
    ------
    TrajectoryError
        If the deadline is before the makespan, or too early for the spans.

    Examples
    --------
    >>> from mitlplan.plan import Step
    >>> steps = (Step("a", Fraction(0), Fraction(1)), Step("b", Fraction(1), Fraction(2)),
    ...          Step("c", Fraction(2), Fraction(2)))
    >>> found = retime(
    ...     Plan(steps, makespan=Fraction(2)), [Span(1.0, Fraction(1)), Span(4.0, Fraction(1))],
    ...     lambda _: True, deadline=Fraction(6))
    >>> print(found.plan, found.cost)
    0 a -> 2 b -> 6 c 1.5
    """
    latest = plan.makespan if deadline is None else deadline
    if latest < plan.makespan:
        raise TrajectoryError(f"the deadline {latest} is before the makespan {plan.makespan}")
    before = _crossings(plan)
    # The time from the last crossing to the end of the plan costs nothing.
    every = [*spans, *(Span(0.0, TICK, end - begin) for begin, end in pairwise(before[len(spans) :]))]
    windows = _windows(plan, before, latest)
    branches = _Branches(every, windows)
    if not branches.add(()):
        raise TrajectoryError(f"the robot cannot drive so fast that the plan ends by {latest}")
    for asked in range(1, MOST_QUESTIONS + 1):
        bound, times, held = branches.best()
        found = _moved(plan, times)
        if accepts(found):
            return Retimed(found, bound, bound)
        why = None if asked == MOST_QUESTIONS else reasons(found)
        if why is None:
            return _retreat(plan, before, times, every, accepts, bound)
        for place, reason in enumerate(why):
            branches.add((*held, *why[:place], reason.broken))
        if not branches.waiting:
            break
    cost = _cost(every, before)
    return Retimed(plan, cost, cost)


class _Branches:
    """What is left to try, the cheapest first: differences to be kept, and the best times that keep them."""

    def __init__(self, spans: Sequence[Span], windows: Sequence[Window]) -> None:
        self.spans = spans
        self.windows = windows
        self.waiting: list[tuple[float, int, list[Fraction], tuple[Apart, ...]]] = []
        self.number = count()

    def add(self, held: tuple[Apart, ...]) -> bool:
        times = cheapest_times(self.spans, self.windows, held)
        if times is None:
            return False
        heappush(self.waiting, (_cost(self.spans, times), next(self.number), times, held))
        return True

    def best(self) -> tuple[float, list[Fraction], tuple[Apart, ...]]:
        cost, _, times, held = heappop(self.waiting)
        return cost, times, held


def _retreat(
    plan: Plan,
    before: Sequence[Fraction],
    wanted: Sequence[Fraction],
    spans: Sequence[Span],
    accepts: Callable[[Plan], bool],
    bound: float,
) -> Retimed:
    """Half of the way back, and again. The sum is convex: each stop on the way costs no more than `plan`."""
    for retreat in range(1, _MOST_RETREATS):
        share = Fraction(1, 2**retreat)
        times = [now + share * (then - now) for now, then in zip(before, wanted, strict=True)]
        found = _moved(plan, times)
        if accepts(found):
            return Retimed(found, _cost(spans, times), bound)
    return Retimed(plan, _cost(spans, before), bound)


def _cost(spans: Sequence[Span], times: Sequence[Fraction]) -> float:
    lasting = zip(spans, pairwise(times), strict=True)
    return sum(span.cost / float(end - begin) for span, (begin, end) in lasting if span.cost > 0)


def _crossings(plan: Plan) -> list[Fraction]:
    """When each step is entered, and when the plan ends if that is later."""
    entered = [step.enter for step in plan.steps]
    leave = plan.steps[-1].leave
    return entered if leave is None or leave == entered[-1] else [*entered, leave]


def _goes_round(plan: Plan) -> bool:
    return plan.loop is not None and plan.loop.period is not None


def _windows(plan: Plan, times: Sequence[Fraction], latest: Fraction) -> list[Window]:
    """Anywhere up to the deadline; but a loop begins and ends when it did, which keeps its period."""
    fixed = {0}
    if _goes_round(plan):
        assert plan.loop is not None
        fixed |= {plan.loop.start, len(times) - 1}
    return [(time, time) if place in fixed else (Fraction(0), latest) for place, time in enumerate(times)]


def _moved(plan: Plan, times: Sequence[Fraction]) -> Plan:
    """The plan with its crossings at `times`; nothing is known of its slack."""
    leaves: Iterator[Fraction | None] = iter(times[1:])
    last = plan.steps[-1].leave
    steps = tuple(
        replace(step, enter=enter, leave=next(leaves, None if last is None else enter), slack=Fraction(0))
        for step, enter in zip(plan.steps, times, strict=False)
    )
    end = steps[-1].enter if steps[-1].leave is None else steps[-1].leave
    return replace(plan, steps=steps, makespan=end, bound=None)
