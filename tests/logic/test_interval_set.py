"""Sets of times, cell by cell, and what they refuse."""

from __future__ import annotations

from fractions import Fraction
from time import perf_counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.logic.interval import ALWAYS, Interval
from mitlplan.logic.interval_set import Axis, IntervalSet, intersection, union
from tests.logic.signal_strategies import intervals

AXIS = Axis(Fraction(1, 2), 3, 7)
"""Half seconds; from 3/2 on everything repeats every 2 seconds."""

CELLS = range(2 * AXIS.end)


def sets() -> st.SearchStrategy[IntervalSet]:
    """Any set on the axis."""
    return st.sets(st.sampled_from(range(2 * AXIS.end + 1))).map(_from_ends)


def _from_ends(ends: set[int]) -> IntervalSet:
    in_order = sorted(ends)
    return IntervalSet(AXIS, tuple(in_order[: len(in_order) // 2 * 2]))


def instant(cell: int) -> Fraction:
    """A time of the cell."""
    return Fraction(cell, 2) * AXIS.tick


def members(times: IntervalSet) -> set[int]:
    return {cell for cell in CELLS if instant(cell) in times}


@given(sets(), sets(), sets())
def test_are_sets(one: IntervalSet, two: IntervalSet, three: IntervalSet) -> None:
    assert members(one | two) == members(one) | members(two)
    assert members(one & two) == members(one) & members(two)
    assert members(~one) == set(CELLS) - members(one)
    assert members(union(AXIS, [one, two, three])) == members(one) | members(two) | members(three)
    assert members(intersection(AXIS, [one, two, three])) == members(one) & members(two) & members(three)
    assert bool(one) == bool(members(one))
    assert (one == two) == (members(one) == members(two))


@given(sets())
def test_repeat_for_ever(times: IntervalSet) -> None:
    for cell in range(2 * AXIS.repeat_from, 6 * AXIS.end):
        later = instant(cell) + (AXIS.end - AXIS.repeat_from) * AXIS.tick
        assert (instant(cell) in times) == (later in times)


@given(sets())
def test_are_their_intervals(times: IntervalSet) -> None:
    listed = list(times.intervals())
    for cell in CELLS:
        assert (instant(cell) in times) == any(instant(cell) in interval for interval in listed)
    assert IntervalSet.of(AXIS, listed) == times


@pytest.mark.parametrize(
    ("cuts", "text"),
    [
        ((), "never"),
        ((0, 2), "[0,1/2)"),
        ((1, 2, 4, 5), "(0,1/2) {1}"),
        ((0, 14), "[0,inf)"),
        ((5, 14), "(1,inf)"),
        ((8, 10), "[2,5/2), and again every 2 from 3/2 on"),
        ((9, 14), "(2,7/2), and again every 2 from 3/2 on"),
    ],
)
def test_are_written_in_seconds(cuts: tuple[int, ...], text: str) -> None:
    assert str(IntervalSet(AXIS, cuts)) == text


@given(sets(), intervals())
def test_eventually_looks_at_every_distance(times: IntervalSet, interval: Interval) -> None:
    expected = set()
    for cell in CELLS:
        # Half a cell apart, so that from an open cell both the cells at a distance are met.
        distances = [Fraction(count, 4) * AXIS.tick for count in range(120)]
        wanted = [distance for distance in distances if distance in interval]
        if any(instant(cell) + distance in times for distance in wanted):
            expected.add(cell)
    assert members(times.eventually(interval)) == expected


@given(sets(), sets(), intervals())
def test_an_until_is_an_eventually_while_the_left_side_holds(
    left: IntervalSet, right: IntervalSet, interval: Interval
) -> None:
    everything = IntervalSet.everything(AXIS)
    come = left.until(right, interval)
    assert everything.until(right, interval) == right.eventually(interval)
    assert members(come) <= members(right.eventually(interval))
    assert members(come) <= members(left) | members(right)
    assert come == left.until(right & (left | right), interval) | come
    assert IntervalSet.nothing(AXIS).until(right, ALWAYS) == right


def test_the_work_does_not_grow_with_the_bounds() -> None:
    axis = Axis(Fraction(1, 1000), 10**12, 10**12 + 2000)
    visits = IntervalSet.of(
        axis, [Interval(Fraction(10**9), Fraction(10**9) + Fraction(1, 1000), upper_open=True)]
    )
    began = perf_counter()
    assert visits.eventually(Interval(Fraction(0), Fraction(10**9))) == IntervalSet.everything(axis)
    assert list(visits.eventually(Interval(Fraction(0), Fraction(1))).intervals()) == [
        Interval(Fraction(10**9 - 1), Fraction(10**9) + Fraction(1, 1000), upper_open=True),
        Interval(Fraction(10**9 + 1), Fraction(10**9 + 2), upper_open=True),
    ]
    assert visits.eventually(Interval(Fraction(10**15), Fraction(10**15 + 2))) == IntervalSet.everything(axis)
    assert perf_counter() - began < 0.1


def test_refuse_what_is_not_on_their_axis() -> None:
    with pytest.raises(ValueError, match=r"^1/3 is not a multiple of the tick 1/2$"):
        IntervalSet.of(AXIS, [Interval(Fraction(1, 3), Fraction(1))])
    with pytest.raises(ValueError, match=r"^sets of times are put together on one axis only$"):
        IntervalSet.nothing(AXIS) | IntervalSet.nothing(Axis(Fraction(1), 0, 1))
    with pytest.raises(ValueError, match=r"^sets of times are put together on one axis only$"):
        IntervalSet.nothing(AXIS).until(IntervalSet.nothing(Axis(Fraction(1), 0, 1)), ALWAYS)
    for cuts in ((1,), (2, 1), (-1, 3), (3, 3), (0, 2 * AXIS.end + 1)):
        problem = r"^the cuts of a set of times come in pairs, in order, on its axis$"
        with pytest.raises(ValueError, match=problem):
            IntervalSet(AXIS, cuts)
    for tick, repeat_from, end in ((Fraction(0), 0, 1), (Fraction(1), 1, 1), (Fraction(1), -1, 1)):
        problem = r"^an axis has a positive tick and a part of positive length that repeats$"
        with pytest.raises(ValueError, match=problem):
            Axis(tick, repeat_from, end)
