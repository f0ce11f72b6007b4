"""Sets of times, exact, on an axis that repeats: the arithmetic of the judge.

Why cells: if every end that matters is a multiple of one tick, time falls into cells, in turn a point and an
open interval: cell ``2n`` is the instant n, cell ``2n + 1`` the open interval (n, n + 1). A set is a row of
integers ``low, high, low, high, ...``: from cell `low` on, up to but without cell `high`. Open and closed
ends need no cases any more: ``[1, 2)`` is ``2, 4``; ``{1}`` is ``2, 3``; ``(1, 2]`` is ``3, 5``.

Why one axis for all: every operator looks forward only, so the truth of a formula repeats wherever the signal
does, from the same instant and with the same period. A set is stored up to the end of the first repetition.

What it costs: sorting and one sweep, in the number of intervals. Bounds do not count: a bound longer than
the period is folded into it. Only a bounded operator that reaches from a long prefix into a loop that really
alternates writes its pattern out along the prefix.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from operator import lt
from typing import TypeAlias

from mitlplan.logic.interval import Interval

Cuts: TypeAlias = "tuple[int, ...]"


@dataclass(frozen=True, slots=True)
class Axis:
    """Time from 0 on, in ticks; from `repeat_from` on it repeats with the period ``end - repeat_from``.

    Parameters
    ----------
    tick
        The length of a tick, in seconds.
    repeat_from, end
        In ticks: where the part that repeats begins, and where its first occurrence ends.

    Raises
    ------
    ValueError
        If the tick or the period is not positive, or the repetition begins before time 0.

    Examples
    --------
    >>> axis = Axis(Fraction(1, 2), 0, 4)
    >>> axis.count(Fraction(3, 2))
    3
    """

    tick: Fraction
    repeat_from: int
    end: int

    def __post_init__(self) -> None:
        if self.tick <= 0 or not 0 <= self.repeat_from < self.end:
            raise ValueError("an axis has a positive tick and a part of positive length that repeats")

    def count(self, time: Fraction) -> int:
        """How many ticks `time` (in seconds) is.

        Raises
        ------
        ValueError
            If it is not a whole number of ticks.
        """
        ticks = time / self.tick
        if ticks.denominator != 1:
            raise ValueError(f"{time} is not a multiple of the tick {self.tick}")
        return ticks.numerator


@dataclass(frozen=True, slots=True)
class IntervalSet:
    """A set of times on an axis; the operators ``|``, ``&``, ``~`` and ``in`` are those of sets.

    Parameters
    ----------
    axis
        The axis. Only sets on equal axes are put together.
    cuts
        The cells of the set up to the axis' end: ``low, high, low, high, ...``, strictly increasing.

    Raises
    ------
    ValueError
        If the cuts are not in order or leave the axis, or if two sets with different axes meet.

    Examples
    --------
    >>> axis = Axis(Fraction(1), 0, 4)
    >>> visits = IntervalSet.of(axis, [Interval(Fraction(1), Fraction(2), upper_open=True)])
    >>> print(visits)
    [1,2), and again every 4 from 0 on
    >>> Fraction(5) in visits, Fraction(6) in visits
    (True, False)
    >>> print(visits.eventually(Interval(Fraction(0), Fraction(1))))
    [0,2), and again every 4 from 0 on
    """

    axis: Axis
    cuts: Cuts

    def __post_init__(self) -> None:
        cuts = self.cuts
        in_order = all(map(lt, cuts, cuts[1:]))
        if len(cuts) % 2 or not in_order or (cuts and (cuts[0] < 0 or cuts[-1] > 2 * self.axis.end)):
            raise ValueError("the cuts of a set of times come in pairs, in order, on its axis")

    @classmethod
    def nothing(cls, axis: Axis) -> IntervalSet:
        """The empty set."""
        return cls(axis, ())

    @classmethod
    def everything(cls, axis: Axis) -> IntervalSet:
        """All times from 0 on."""
        return cls(axis, (0, 2 * axis.end))

    @classmethod
    def of(cls, axis: Axis, intervals: Iterable[Interval]) -> IntervalSet:
        """The union of `intervals` (in seconds), each within the axis; what lies in the loop repeats.

        An interval without an upper end holds from its lower end to the axis' end.
        """
        spans = []
        for interval in intervals:
            low = 2 * axis.count(interval.lower) + interval.lower_open
            if interval.upper is None:
                spans.append((low, 2 * axis.end))
            else:
                spans.append((low, 2 * axis.count(interval.upper) + (not interval.upper_open)))
        return cls(axis, _joined(spans))

    def __contains__(self, time: Fraction) -> bool:
        ticks = time / self.axis.tick
        cell = 2 * (ticks.numerator // ticks.denominator) + (ticks.denominator != 1)
        last, start = 2 * self.axis.end, 2 * self.axis.repeat_from
        if cell >= last:
            cell = start + (cell - start) % (last - start)
        return cell >= 0 and bisect_right(self.cuts, cell) % 2 == 1

    def __bool__(self) -> bool:
        return bool(self.cuts)

    def __or__(self, other: IntervalSet) -> IntervalSet:
        return union(self.axis, (self, other))

    def __and__(self, other: IntervalSet) -> IntervalSet:
        return intersection(self.axis, (self, other))

    def __invert__(self) -> IntervalSet:
        cuts, last = self.cuts, 2 * self.axis.end
        cuts = cuts[1:] if cuts and cuts[0] == 0 else (0, *cuts)
        cuts = cuts[:-1] if cuts and cuts[-1] == last else (*cuts, last)
        return IntervalSet(self.axis, cuts)

    def __str__(self) -> str:
        start, last = 2 * self.axis.repeat_from, 2 * self.axis.end
        if not self.cuts:
            return "never"
        listed = " ".join(_shown(interval) for interval in self.intervals())
        if self.cuts[-1] <= start or (self.cuts[-1] == last and self.cuts[-2] <= start):
            return listed
        period = (self.axis.end - self.axis.repeat_from) * self.axis.tick
        return f"{listed}, and again every {period} from {self.axis.repeat_from * self.axis.tick} on"

    def intervals(self) -> Iterator[Interval]:
        """The maximal intervals in order of time, in seconds, up to the axis' end.

        One that covers the whole loop has no upper end; any other that reaches the end stops there.
        """
        tick, start, last = self.axis.tick, 2 * self.axis.repeat_from, 2 * self.axis.end
        for low, high in _pairs(self.cuts):
            endless = high == last and low <= start
            upper = None if endless else (high // 2) * tick
            yield Interval((low // 2) * tick, upper, bool(low % 2), high % 2 == 0)

    def eventually(self, interval: Interval) -> IntervalSet:
        """The times from which some time in `interval` later (in seconds) belongs to the set."""
        window = _Window.of(self.axis, interval)
        start, last = 2 * self.axis.repeat_from, 2 * self.axis.end
        prefix = _clipped(self.cuts, 0, start)
        loop = _clipped(self.cuts, start, last)
        spans = [window.back(low, high) for low, high in _pairs(prefix)]
        if loop:
            spans += _seen_in_loop(window, loop, start, last)
        return IntervalSet(self.axis, _joined(_within(spans, 0, last)))

    def until(self, right: IntervalSet, interval: Interval) -> IntervalSet:
        """The times t from which `right` comes, some s in `interval` later, with this set on [t, t + s)."""
        _require_same(self.axis, right.axis)
        window = _Window.of(self.axis, interval)
        start, last = 2 * self.axis.repeat_from, 2 * self.axis.end
        spans = list(_pairs(right.cuts)) if Fraction(0) in interval else []
        left, come = self.cuts, right.cuts
        if left and left[-1] == last and left[-2] <= start:
            # The last stretch of the left side never ends, so only the right side limits it.
            since = left[-2]
            spans += _pairs(_clipped(right.eventually(interval).cuts, since, last))
            spans += _handed_over(window, left[:-2], come)
        else:
            # Every stretch of the left side is shorter than the period: two rounds show it whole.
            spans += _handed_over(window, _two_rounds(left, start, last), _two_rounds(come, start, last))
        return IntervalSet(self.axis, _joined(_within(spans, 0, last)))


def union(axis: Axis, sets: Iterable[IntervalSet]) -> IntervalSet:
    """The union of any number of sets on `axis`, in one sweep.

    Raises
    ------
    ValueError
        If a set has another axis.

    Examples
    --------
    >>> axis = Axis(Fraction(1), 0, 4)
    >>> print(union(axis, [IntervalSet(axis, (2, 4)), IntervalSet(axis, (4, 6))]))
    [1,3), and again every 4 from 0 on
    """
    spans: list[tuple[int, int]] = []
    for each in sets:
        _require_same(axis, each.axis)
        spans += _pairs(each.cuts)
    return IntervalSet(axis, _joined(spans))


def intersection(axis: Axis, sets: Iterable[IntervalSet]) -> IntervalSet:
    """The intersection of any number of sets on `axis`, in one sweep; of none, all times.

    Raises
    ------
    ValueError
        If a set has another axis.
    """
    return ~union(axis, (~each for each in sets))


@dataclass(frozen=True, slots=True)
class _Window:
    """The interval of an operator, in cells: seen from an instant, where one looks."""

    nearest: int
    farthest: int | None
    nearest_open: bool
    farthest_open: bool

    @classmethod
    def of(cls, axis: Axis, interval: Interval) -> _Window:
        farthest = None if interval.upper is None else 2 * axis.count(interval.upper)
        return cls(2 * axis.count(interval.lower), farthest, interval.lower_open, interval.upper_open)

    def earliest(self, low: int) -> int:
        """The first cell from which a span that begins with cell `low` is seen."""
        # Bit 0 of a lower cut says "open": an end is reached only if both ends are closed.
        return 0 if self.farthest is None else (low - self.farthest) | self.farthest_open

    def back(self, low: int, high: int) -> tuple[int, int]:
        """The cells from which the span ``low, high`` is seen."""
        # Bit 0 of an upper cut says "closed".
        last = high - self.nearest
        return self.earliest(low), last & ~1 if self.nearest_open else last


def _seen_in_loop(window: _Window, loop: Cuts, start: int, last: int) -> list[tuple[int, int]]:
    """The cells from 0 to `last` from which a span of the loop, or of a repetition of it, is seen."""
    if window.farthest is None:
        return [(0, last)]
    period = last - start
    folded = []
    for low, high in map(window.back, loop[::2], loop[1::2]):
        if high - low >= period:
            folded = [(start, last)]
            break
        rounds = (low - start) // period * period
        folded += [(low - rounds, min(high - rounds, last)), (start, high - rounds - period)]
    pattern = _joined(_within(folded, start, last))
    # Before `lookout` one sees the prefix first: what is seen of the loop is then seen from the moment on at
    # which the loop's first span comes into reach. From `lookout` on one sees the loop only, as within it.
    lookout = max(0, start - window.nearest)
    spans = [(window.earliest(loop[0]), lookout), *_pairs(pattern)]
    if pattern == (start, last):
        return [*spans, (lookout, start)]
    for back in range(period, start - lookout + period, period):
        spans += _within(((low - back, high - back) for low, high in _pairs(pattern)), lookout, start)
    return spans


def _handed_over(window: _Window, left: Cuts, right: Cuts) -> Iterator[tuple[int, int]]:
    """For each stretch of `left`, the cells in it from which `right` is seen no later than its end."""
    rights = list(_pairs(right))
    first = 0
    for low, high in _pairs(left):
        # The left side must hold before the right side comes, so the instant of its end still counts.
        closed = high | 1
        while first < len(rights) and rights[first][1] <= low:
            first += 1
        index = first
        while index < len(rights) and rights[index][0] < closed:
            come, gone = rights[index]
            since, until = window.back(max(come, low), min(gone, closed))
            yield max(since, low), min(until, high)
            index += 1


def _two_rounds(cuts: Cuts, start: int, last: int) -> Cuts:
    """The set up to the end of the second repetition."""
    period = last - start
    again = [(low + period, high + period) for low, high in _pairs(_clipped(cuts, start, last))]
    return _joined([*_pairs(cuts), *again])


def _pairs(cuts: Cuts) -> Iterator[tuple[int, int]]:
    return zip(cuts[::2], cuts[1::2], strict=True)


def _within(spans: Iterable[tuple[int, int]], low: int, high: int) -> Iterator[tuple[int, int]]:
    return ((max(since, low), min(until, high)) for since, until in spans)


def _clipped(cuts: Cuts, low: int, high: int) -> Cuts:
    """The part of the set between the cells `low` (included) and `high` (left out)."""
    begin, stop = bisect_right(cuts, low), bisect_right(cuts, high - 1)
    inside = cuts[begin:stop]
    if begin % 2:
        inside = (low, *inside)
    if stop % 2:
        inside = (*inside, high)
    return inside if low < high else ()


def _joined(spans: Iterable[tuple[int, int]]) -> Cuts:
    """The union of `spans`, the empty ones dropped, as cuts."""
    cuts: list[int] = []
    for low, high in sorted(spans):
        if high <= low:
            continue
        if cuts and low <= cuts[-1]:
            cuts[-1] = max(cuts[-1], high)
        else:
            cuts += (low, high)
    return tuple(cuts)


def _require_same(one: Axis, other: Axis) -> None:
    if one != other:
        raise ValueError("sets of times are put together on one axis only")


def _shown(interval: Interval) -> str:
    return f"{{{interval.lower}}}" if interval.punctual else str(interval)
