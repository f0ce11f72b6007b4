"""The slack of a way point by trying all timetables in half seconds: slow, readable, and the judge decides.

The way points before it stay as planned, it is reached later, those behind it move along the same path as
they like, up to `LONGEST` after the one before. A loop may move for one round and goes on as planned from
then on.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.plan import Plan
from mitlplan_fuzz.missions import SmallMission

STEP = Fraction(1, 2)
LONGEST = 5
FARTHEST = Fraction(6)
"""Longer delays are not tried, in seconds."""


MOST_KNOWN = 12
"""How long the last stay of a finite plan may be, in seconds."""


def slack_by_trying(small: SmallMission, plan: Plan, place: int) -> Fraction:
    """The last delay up to which all are possible, in half seconds and at most `FARTHEST`."""
    delay = Fraction(0)
    while delay < FARTHEST and possible(small, plan, place, delay + STEP):
        delay += STEP
    return delay


def possible(small: SmallMission, plan: Plan, place: int, delay: Fraction) -> bool:
    steps = plan.steps
    before = [step.enter for step in steps[:place]]
    late = steps[place].enter + delay
    if not _may_stay(small, steps[place - 1].cell, steps[place].cell, late - before[-1]):
        return False
    return any(
        satisfies(small.formula, signal, until=small.until, horizon=small.horizon)
        for times in _timetables(small, plan, [*before, late])
        for signal in _signals(small, plan, times)
    )


def _timetables(small: SmallMission, plan: Plan, times: list[Fraction]) -> Iterator[list[Fraction]]:
    """All ways to go on; a loop's timetable ends with the beginning of the next round."""
    cells = [step.cell for step in plan.steps]
    if plan.loop is not None and plan.loop.period is not None:
        cells.append(cells[plan.loop.start])
    if len(times) == len(cells):
        yield times
        return
    for halves in range(1, 2 * LONGEST + 1):
        stay = halves * STEP
        if _may_stay(small, cells[len(times) - 1], cells[len(times)], stay):
            yield from _timetables(small, plan, [*times, times[-1] + stay])


def _may_stay(small: SmallMission, cell: str, after: str, stay: Fraction) -> bool:
    return any(
        least <= stay and (small.waiting or stay <= most)
        for origin, target, least, most in small.moves
        if (origin, target) == (cell, after)
    )


def _signals(small: SmallMission, plan: Plan, times: list[Fraction]) -> Iterator[Signal]:
    """What the robot shows: for ever, or up to each end that the map allows."""
    labels = {name: frozenset(holds) for name, holds in small.cells}
    shown = [labels[step.cell] for step in plan.steps]
    segments = [Segment(time, label) for time, label in zip(times, shown, strict=False)]
    last = segments[-1].start
    match plan.loop:
        case None:
            longest = max(
                (most for cell, _, _, most in small.moves if cell == plan.steps[-1].cell), default=0
            )
            ends = [last + halves * STEP for halves in range(2 * MOST_KNOWN)]
            allowed = [end for end in ends if end == last or small.waiting or end - last < longest]
            # Over an infinite horizon whoever knows more knows what he knew.
            for end in allowed if small.horizon == "finite" else allowed[-1:]:
                yield Signal(tuple(segments), end)
        case loop if loop.period is None:
            yield Signal(tuple(segments), last + 1, last)
        case loop:
            assert loop.period is not None
            shift = times[-1] - plan.makespan
            again = [
                Segment(step.enter + loop.period + shift, labels[step.cell])
                for step in plan.steps[loop.start :]
            ]
            yield Signal((*segments, *again), again[0].start + loop.period, again[0].start)
