"""Why no plan at such times satisfies a mission: the differences of crossings that already forbid it.

The negation of the formula is followed through the plan. Every part of it becomes a set of spans of time in
which it holds. A span knows its reasons: differences of crossings that the plan keeps; as long as they are
kept the part holds throughout the span, wherever its ends have moved to. An end is a crossing, later or
earlier by a constant, and just before or just behind that instant. Spans need not be maximal, so that few
reasons are needed; where the whole of a stretch matters (for a release) spans that meet are joined, and their
meeting becomes a reason. What the negation then needs at time 0 is the answer.

The end of a plan that ends is followed by anything: there every literal counts as true. A loop is written out
for a while, and beyond that nothing counts as true. So an answer is certain, but there is not always one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import groupby, product
from math import ceil
from typing import Literal as Choice
from typing import TypeAlias

from mitlplan.logic.core import (
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Disjunction,
    Literal,
    Truth,
    negate,
)
from mitlplan.logic.interval import Interval
from mitlplan.plan import Plan
from mitlplan.trajectory.timetable import Apart

_MOST_SPANS = 2000
_MOST_STEPS = 2000


def reasons(
    core: Core, plan: Plan, *, horizon: Choice["infinite", "finite"] = "infinite"
) -> tuple[Apart, ...] | None:
    """Differences of crossings that `plan` keeps: no plan of the same cells that keeps them is a good one.

    Parameters
    ----------
    core
        The mission's formula, in normal form.
    plan
        One that the judge refuses, though the robot can go so.
    horizon
        As in the mission.

    Returns
    -------
    tuple of Apart or None
        Crossing k is the entry of step k; behind the last one comes the end of the plan. ``None``: no reason
        is known.

    Examples
    --------
    >>> from mitlplan.logic.normalize import normalize
    >>> from mitlplan.logic.parse import parse
    >>> from mitlplan.plan import Step
    >>> steps = (Step("a", Fraction(0), Fraction(5)), Step("b", Fraction(5), Fraction(5), ("B",)))
    >>> reasons(normalize(parse("F[0,4] B")), Plan(steps, makespan=Fraction(5)))
    (Apart(earlier=0, later=1, least=Fraction(4, 1), strict=True),)
    """
    followed = _Followed.of(core, plan, horizon)
    if followed is None:
        return None
    try:
        found = [_now(span) for span in followed.holding(negate(core)) if _holds_now(span)]
    except _TooManyError:
        return None
    needed = [_without_implied(each) for each in found]
    return min(needed, key=len) if needed else None


class _TooManyError(Exception):
    """More spans than are worth it."""


@dataclass(frozen=True, slots=True)
class _End:
    """Just before (`side` 0) or just behind (1) the instant `time`, which is `offset` after a crossing."""

    crossing: int
    offset: Fraction
    side: int
    time: Fraction

    @property
    def value(self) -> tuple[Fraction, int]:
        return self.time, self.side

    def moved(self, by: Fraction, side: int) -> _End:
        return _End(self.crossing, self.offset + by, side, self.time + by)


_ZERO = _End(0, Fraction(0), 0, Fraction(0))
_BEHIND_ZERO = _End(0, Fraction(0), 1, Fraction(0))


@dataclass(frozen=True, slots=True)
class _Span:
    """From `low` to `high` (``None``: for ever) something holds, as long as the reasons are kept."""

    low: _End
    high: _End | None
    why: frozenset[Apart] = frozenset()


def _before(one: _End, other: _End) -> Apart:
    """That an end is before another one, which it is."""
    return Apart(one.crossing, other.crossing, one.offset - other.offset, strict=one.side >= other.side)


def _at_most(one: _End, other: _End) -> Apart:
    """That an end is no later than another one, which it is."""
    return Apart(one.crossing, other.crossing, one.offset - other.offset, strict=one.side > other.side)


def _holds_now(span: _Span) -> bool:
    return span.low.value <= _ZERO.value and (span.high is None or _BEHIND_ZERO.value <= span.high.value)


def _now(span: _Span) -> frozenset[Apart]:
    """What is needed for a span to hold at time 0."""
    high = () if span.high is None else (_at_most(_BEHIND_ZERO, span.high),)
    return span.why | {_at_most(span.low, _ZERO), *high}


def _without_implied(why: Iterable[Apart]) -> tuple[Apart, ...]:
    """Those that follow neither from the order of the crossings nor from another one."""
    left = sorted((one for one in why if not _in_order(one)), key=repr)
    return tuple(one for one in left if not any(other != one and _implied(one, other) for other in left))


def _in_order(one: Apart) -> bool:
    """Whether that is so because crossings come one after the other."""
    return one.earlier == one.later or (one.earlier < one.later and one.least <= 0)


def _implied(one: Apart, other: Apart) -> bool:
    """Whether that is so because of another one, which lies within it in the order of the crossings."""
    if one.earlier > other.earlier or other.later > one.later or one.least > other.least:
        return False
    farther = (one.earlier, one.later) != (other.earlier, other.later)
    return farther or one.least < other.least or other.strict or not one.strict


@dataclass(frozen=True, slots=True)
class _Followed:
    """A plan, as the formula sees it."""

    stretches: tuple[tuple[frozenset[str], _End, _End | None], ...]
    """Labels, with the ends of the time in which they hold."""
    end: _End | None
    """Just behind the end of a plan that ends; then anything follows."""
    finite: bool
    memory: dict[Core, list[_Span]] = field(default_factory=dict)

    @classmethod
    def of(cls, core: Core, plan: Plan, horizon: Choice["infinite", "finite"]) -> _Followed | None:
        steps = plan.steps
        entered = [_End(place, Fraction(0), 0, step.enter) for place, step in enumerate(steps)]
        labels = [frozenset(step.holds) for step in steps]
        last = steps[-1].leave
        if last is None:
            return cls(tuple(_stretches(labels, [*entered, None])), None, finite=False)
        place = len(steps) - (last == steps[-1].enter)
        if plan.loop is None or plan.loop.period is None:
            end = _End(place, Fraction(0), 1, last)
            return cls(tuple(_stretches(labels, [*entered, end])), end, finite=horizon == "finite")
        start, period = plan.loop.start, plan.loop.period
        rounds = 2 + ceil(sum(_reach(core), Fraction(0)) / period)
        if rounds * len(steps) > _MOST_STEPS:
            return None
        for again in range(1, rounds + 1):
            entered += [end.moved(again * period, 0) for end in entered[start : len(steps)]]
            labels += labels[start : len(steps)]
        stop = _End(place, rounds * period, 0, last + rounds * period)
        return cls(tuple(_stretches(labels, [*entered, stop])), None, finite=False)

    def holding(self, core: Core) -> list[_Span]:
        """The spans in which a formula holds."""
        if core not in self.memory:
            spans = self._holding(core)
            if len(spans) > _MOST_SPANS:
                raise _TooManyError
            self.memory[core] = spans
        return self.memory[core]

    def _holding(self, core: Core) -> list[_Span]:
        match core:
            case Truth(value):
                return [_Span(_ZERO, None)] if value else []
            case Literal(name, positive):
                return list(self._seen(name, positive=positive))
            case Disjunction(operands):
                return [span for operand in operands for span in self.holding(operand)]
            case Conjunction(operands):
                common = [_Span(_ZERO, None)]
                for operand in operands:
                    common = _common(common, self.holding(operand))
                return common
            case CoreUntil(left, right, interval):
                return self._until(self.holding(left), self.holding(right), interval)
            case CoreRelease(left, right, interval):
                return list(_release(self.holding(left), self.holding(right), interval))

    def _seen(self, name: str, *, positive: bool) -> Iterator[_Span]:
        """When a literal holds; what follows the end of a plan that ends may be anything."""
        known = [(low, high, (name in label) == positive) for label, low, high in self.stretches]
        if self.end is not None:
            known.append((self.end, None, True))
        for holds, group in groupby(known, key=lambda one: one[2]):
            if holds:
                stretch = list(group)
                yield _Span(stretch[0][0], stretch[-1][1])

    def _until(self, left: list[_Span], right: list[_Span], interval: Interval) -> list[_Span]:
        after: list[_Span] = []
        if self.finite and interval.upper is None and self.end is not None:
            # What is promised for ever need hold only until the end; behind the end all is open.
            right = _common(right, [_Span(_ZERO, self.end)])
            after = [_Span(self.end, None)]
        return [*_until(left, right, interval), *after]


_Bounded: TypeAlias = "tuple[frozenset[str], _End, _End | None]"


def _stretches(labels: Sequence[frozenset[str]], ends: Sequence[_End | None]) -> Iterator[_Bounded]:
    for label, low, high in zip(labels, ends[:-1], ends[1:], strict=True):
        assert low is not None
        yield label, low, high


def _reach(core: Core) -> Iterator[Fraction]:
    """The greatest finite bound of every operator."""
    match core:
        case Conjunction(operands) | Disjunction(operands):
            for operand in operands:
                yield from _reach(operand)
        case CoreUntil(left, right, interval) | CoreRelease(left, right, interval):
            yield interval.lower if interval.upper is None else interval.upper
            yield from _reach(left)
            yield from _reach(right)


# ------------------------------------------------------------------------------------------- sets of spans


def _span(low: _End, high: _End | None, why: Iterable[Apart]) -> Iterator[_Span]:
    """The span, unless it is empty; that it is not is a reason too."""
    if high is None:
        yield _Span(low, None, frozenset(why))
    elif low.value < high.value:
        yield _Span(low, high, frozenset((*why, _before(low, high))))


def _common(one: Sequence[_Span], other: Sequence[_Span]) -> list[_Span]:
    """What two sets have in common."""
    if len(one) * len(other) > _MOST_SPANS:
        raise _TooManyError
    return [span for pair in product(one, other) for span in _overlap(*pair)]


def _overlap(one: _Span, other: _Span) -> Iterator[_Span]:
    why = one.why | other.why
    early, late = sorted((one.low, other.low), key=lambda end: end.value)
    if early != _ZERO:  # what is before time 0 is never asked for
        why |= {_at_most(early, late)}
    highs = sorted((end for end in (one.high, other.high) if end is not None), key=lambda end: end.value)
    if len(highs) == 2:
        why |= {_at_most(*highs)}
    yield from _span(late, highs[0] if highs else None, why)


def _joined(spans: Iterable[_Span]) -> Iterator[_Span]:
    """Spans that meet made one, by as few of them as will do."""
    ordered = sorted(spans, key=lambda span: span.low.value)
    while ordered:
        joined, *ordered = ordered
        while joined.high is not None:
            reach = joined.high.value
            meeting = [span for span in ordered if span.low.value <= reach]
            farther = [span for span in meeting if span.high is None or span.high.value > reach]
            ordered = [span for span in ordered if span.low.value > reach or span in farther]
            if not farther:
                break
            following = max(farther, key=lambda span: (span.high is None, span.high and span.high.value))
            why = joined.why | following.why | {_at_most(following.low, joined.high)}
            joined = _Span(joined.low, following.high, why)
        else:
            ordered = []
        yield joined


def _seen_from(span: _Span, interval: Interval) -> _Span:
    """The times from which some time of `span` is seen, `interval` later."""
    low, high = _ZERO, None
    if interval.upper is not None:
        low = span.low.moved(-interval.upper, 1 if interval.upper_open else span.low.side)
    if span.high is not None:
        high = span.high.moved(-interval.lower, 0 if interval.lower_open else span.high.side)
    return _Span(low, high, span.why)


def _until(left: list[_Span], right: list[_Span], interval: Interval) -> Iterator[_Span]:
    if Fraction(0) in interval:
        yield from right
    for stretch in _joined(left):
        # The left side must hold before the right side comes, so the instant of its end still counts.
        behind = None if stretch.high is None else stretch.high.moved(Fraction(0), 1)
        for span in right:
            for come in _overlap(_Span(stretch.low, behind, stretch.why), span):
                yield from _overlap(stretch, _seen_from(come, interval))


def _release(left: list[_Span], right: list[_Span], interval: Interval) -> Iterator[_Span]:
    held = list(_joined(right))
    for span in held:
        yield from _throughout(span, interval)
    starts_now = Fraction(0) in interval
    for span in left:
        if starts_now:
            for both in held:
                yield from _overlap(span, both)
        else:
            # Nothing is asked before the interval begins, and by then the left side has come.
            since = span.low.moved(-interval.lower, 0 if interval.lower_open else 1)
            low = min(since, span.low, key=lambda end: end.value)
            yield _Span(low, span.high, span.why)
        # From earlier on the right side must hold up to and with the instant at which the left side comes.
        come = span.low.moved(Fraction(0), 1)
        for both in held:
            if both.high is None or come.value <= both.high.value:
                side = 0 if interval.lower_open else both.low.side
                reach = () if both.high is None else (_at_most(come, both.high),)
                low = both.low.moved(-interval.lower, side)
                yield from _span(low, span.low, (*span.why, *both.why, *reach))


def _throughout(span: _Span, interval: Interval) -> Iterator[_Span]:
    """The times from which all of `interval` later lies in `span`."""
    low = span.low.moved(-interval.lower, 0 if interval.lower_open else span.low.side)
    if span.high is None:
        yield _Span(low, None, span.why)
    elif interval.upper is not None:
        high = span.high.moved(-interval.upper, 1 if interval.upper_open else span.high.side)
        yield from _span(low, high, span.why)
