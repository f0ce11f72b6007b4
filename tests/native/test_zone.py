"""The native zones against the slow matrix, operation by operation and point by point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan._core import Zone
from tests.oracles.matrix_zone import Bound, MatrixZone, close, exceeds

LIMIT = 2**60

numbers = st.integers(-6, 6)
constants = st.none() | st.integers(0, 5)


def entries(zone: Zone) -> list[list[Bound]]:
    clocks = range(zone.dimension)
    return [[zone.at(i, j) for j in clocks] for i in clocks]


def assert_same(zone: Zone, slow: MatrixZone) -> None:
    """Equal matrices; the slow one is closed, so this shows that the native one is too."""
    assert zone.empty == slow.empty
    assert zone.dimension == slow.dimension
    if slow.closed is None:
        assert zone == Zone.zero(zone.dimension).constrain(0, 0, -1)
    else:
        assert entries(zone) == slow.rows()


@st.composite
def steps(draw: st.DrawFn, pair: tuple[Zone, MatrixZone]) -> tuple[Zone, MatrixZone]:
    """One random operation, done to both."""
    zone, slow = pair
    clocks = st.integers(0, zone.dimension - 1)
    kinds = ["constrain", "up", "up_strict", "reset", "free", "extrapolate"] if zone.dimension > 1 else ["up"]
    # Most steps narrow the zone: the others alone would soon make it everything.
    match draw(st.sampled_from(["constrain", "constrain", *kinds])):
        case "constrain":
            i, j, value, strict = draw(clocks), draw(clocks), draw(numbers), draw(st.booleans())
            return zone.constrain(i, j, value, strict), slow.constrain(i, j, (value, strict))
        case "up":
            return zone.up(), slow.later(strictly=False)
        case "up_strict":
            return zone.up_strict(), slow.later(strictly=True)
        case "reset":
            i, value = draw(clocks.filter(bool)), draw(st.integers(0, 6))
            return zone.reset(i, value), slow.reset(i, value)
        case "free":
            i = draw(clocks.filter(bool))
            return zone.free(i), slow.free(i)
        case _:
            lower, upper = draw(constants_for(zone.dimension)), draw(constants_for(zone.dimension))
            return zone.extrapolate_lu_plus(lower, upper), slow.extrapolate_lu_plus(lower, upper)


def constants_for(dimension: int) -> st.SearchStrategy[list[int | None]]:
    return st.lists(constants, min_size=dimension, max_size=dimension)


@st.composite
def zones(draw: st.DrawFn, dimension: int | None = None) -> tuple[Zone, MatrixZone]:
    """A zone and its slow twin, reached by random operations; a step that leaves nothing is not taken."""
    size = draw(st.integers(1, 5)) if dimension is None else dimension
    pair = (Zone.zero(size), MatrixZone.zero(size))
    if draw(st.booleans()):
        pair = (Zone.universe(size), MatrixZone.universe(size))
    for _ in range(draw(st.integers(0, 8))):
        following = draw(steps(pair))
        assert_same(*following)
        if not following[0].empty:
            pair = following
    return pair


@settings(max_examples=500)
@given(zones(), st.data())
def test_every_operation_does_to_the_zone_what_it_does_to_the_matrix(
    pair: tuple[Zone, MatrixZone], data: st.DataObject
) -> None:
    assert_same(*data.draw(steps(pair)))


@settings(max_examples=500)
@given(zones(4), constants_for(4), constants_for(4))
def test_extrapolation_is_the_one_of_the_paper(
    pair: tuple[Zone, MatrixZone], lower: list[int | None], upper: list[int | None]
) -> None:
    zone, slow = pair
    assert_same(zone.extrapolate_lu_plus(lower, upper), slow.extrapolate_lu_plus(lower, upper))


@given(zones(), st.data())
def test_remap_takes_rows_and_columns(pair: tuple[Zone, MatrixZone], data: st.DataObject) -> None:
    zone, slow = pair
    source = [0, *data.draw(st.lists(st.integers(-1, zone.dimension - 1), max_size=6))]
    assert_same(zone.remap(source), slow.remap(source))
    kept = [i for i in source if i > 0]
    assert_same(zone.project(kept), slow.remap([0, *kept]))


@given(st.integers(1, 4).flatmap(lambda size: st.tuples(zones(size), zones(size))))
def test_relations_of_two_zones(pairs: tuple[tuple[Zone, MatrixZone], tuple[Zone, MatrixZone]]) -> None:
    (a, slow_a), (b, slow_b) = pairs
    both = a.intersect(b)
    assert_same(both, slow_a.intersect(slow_b))
    assert a.intersects(b) == (not both.empty)
    assert a.includes(b) == slow_a.includes(slow_b)
    assert a.includes(both)
    assert (a == b) == (a.includes(b) and b.includes(a))
    assert hash(a.intersect(b)) == hash(b.intersect(a))


@given(
    st.integers(1, 5).flatmap(
        lambda size: st.lists(
            st.lists(st.none() | st.tuples(numbers, st.booleans()), min_size=size, max_size=size),
            min_size=size,
            max_size=size,
        )
    )
)
def test_any_matrix_is_closed(rows: list[list[tuple[int, bool] | None]]) -> None:
    assert_same(Zone.from_matrix(rows), MatrixZone.of(rows))


halves = st.integers(0, 16).map(lambda k: Fraction(k, 2))
points = st.tuples(halves, halves)


@given(zones(3), points)
def test_delays_by_points(pair: tuple[Zone, MatrixZone], point: tuple[Fraction, Fraction]) -> None:
    """A point is reached by a delay if some delay, tried one by one, leads back into the zone.

    The zone has integer bounds and the point is on halves, so the delays that lead back form an interval with
    ends on halves: if there is one at all, there is one on quarters.
    """
    zone, slow = pair
    delays = [Fraction(k, 4) for k in range(int(min(point) * 4) + 1)]
    back = [delay for delay in delays if slow.contains([value - delay for value in point])]
    assert contains(zone.up(), point) == bool(back)
    assert contains(zone.up_strict(), point) == any(delay > 0 for delay in back)


@given(zones(3), constants_for(3), constants_for(3), points)
def test_extrapolation_adds_only_simulated_points(
    pair: tuple[Zone, MatrixZone],
    lower: list[int | None],
    upper: list[int | None],
    point: tuple[Fraction, Fraction],
) -> None:
    """What Extra+_LU adds, some valuation of the zone can mimic (the LU preorder of its paper)."""
    zone, slow = pair
    extrapolated = zone.extrapolate_lu_plus(lower, upper)
    assert extrapolated.includes(zone)
    if not contains(extrapolated, point):
        return
    choices = [mimics(i, value, lower[i], upper[i]) for i, value in enumerate(point, start=1)]
    assert any(not restricted(slow, choice).empty for choice in product(*choices))


quarters = st.integers(0, 36).map(lambda k: Fraction(k, 4))


@given(zones(3), zones(3), constants_for(3), constants_for(3), st.tuples(quarters, quarters))
def test_what_a_zone_simulates_it_simulates_point_by_point(
    outer: tuple[Zone, MatrixZone],
    inner: tuple[Zone, MatrixZone],
    lower: list[int | None],
    upper: list[int | None],
    point: tuple[Fraction, Fraction],
) -> None:
    if outer[0].simulates(inner[0], lower, upper) and inner[1].contains(point):
        assert mimicked(outer[1], point, lower, upper)


@settings(max_examples=60)
@given(zones(3), zones(3), constants_for(3), constants_for(3))
def test_what_a_zone_does_not_simulate_has_a_point_that_shows_it(
    outer: tuple[Zone, MatrixZone],
    inner: tuple[Zone, MatrixZone],
    lower: list[int | None],
    upper: list[int | None],
) -> None:
    """With two clocks and integer bounds of at most 6, some point on quarters up to 9 tells them apart."""
    if outer[0].simulates(inner[0], lower, upper):
        return
    grid = [Fraction(k, 4) for k in range(37)]
    inside = (point for point in product(grid, grid) if inner[1].contains(point))
    assert not all(mimicked(outer[1], point, lower, upper) for point in inside)


@given(zones(4), constants_for(4), constants_for(4))
def test_a_zone_simulates_what_extrapolation_adds(
    pair: tuple[Zone, MatrixZone], lower: list[int | None], upper: list[int | None]
) -> None:
    zone, _ = pair
    assert zone.simulates(zone.extrapolate_lu_plus(lower, upper), lower, upper)


def mimicked(
    zone: MatrixZone, point: Sequence[Fraction], lower: Sequence[int | None], upper: Sequence[int | None]
) -> bool:
    """Whether some valuation of `zone` can do what `point` can: a box of them is looked for."""
    for i, value in enumerate(point, start=1):
        if not exceeds(value, upper[i]):
            zone = zone.constrain(i, 0, (value, False))
        if not exceeds(value, lower[i]):
            zone = zone.constrain(0, i, (-value, False))
        elif (least := lower[i]) is not None:
            zone = zone.constrain(0, i, (-least, True))
    return not zone.empty


@given(zones(4), st.sets(st.integers(1, 3)), st.tuples(halves, halves, halves), halves)
def test_time_that_passes_for_some_clocks(
    pair: tuple[Zone, MatrixZone], stopped: set[int], point: tuple[Fraction, ...], delay: Fraction
) -> None:
    """Nothing possible is left out, nothing possible is far off, and without stopped clocks it is exact."""
    zone, slow = pair
    later = zone.up_partly(sorted(stopped))
    moved = [value if i in stopped else value + delay for i, value in enumerate(point, start=1)]
    if slow.contains(point):
        assert contains(later, moved)
    for i, j in product(range(4), range(4)):
        runs_away = i not in stopped | {0} and (j == 0 or j in stopped)
        assert later.empty or later.at(i, j) == (None if runs_away else zone.at(i, j))
    if not stopped:
        assert later == zone.up()
    assert_same(later, slow if slow.closed is None else MatrixZone.of(entries(later)))


Constraint = tuple[int, int, Bound]


def mimics(i: int, value: Fraction, lower: int | None, upper: int | None) -> list[list[Constraint]]:
    """The values v of clock i with v = value, or lower < v < value, or upper < value < v."""
    equal: list[Constraint] = [(i, 0, (value, False)), (0, i, (-value, False))]
    smaller: list[Constraint] = [(i, 0, (value, True)), (0, i, None if lower is None else (-lower, True))]
    larger: list[Constraint] = [(0, i, (-value, True))]
    return [equal, smaller, *([larger] if exceeds(value, upper) else [])]


def restricted(zone: MatrixZone, choice: Sequence[Sequence[Constraint]]) -> MatrixZone:
    for constraints in choice:
        for constraint in constraints:
            zone = zone.constrain(*constraint)
    return zone


def contains(zone: Zone, point: Sequence[Fraction]) -> bool:
    return not zone.empty and MatrixZone(zone.dimension, close(entries(zone))).contains(point)


def test_a_clock_without_constants_forgets_that_it_is_late() -> None:
    """No lower bound on a clock of absolute time is asked: later is never better, the upper bound goes."""
    at_five = Zone.zero(3).up().constrain(1, 0, 5).constrain(0, 1, -5).reset(2)
    seen = at_five.extrapolate_lu_plus([None, None, None], [None, 9, None])
    assert seen.at(1, 0) is None
    assert seen.at(0, 1) == (-5, False)
    assert seen.includes(at_five.up())


def test_a_contradiction_between_unbounded_clocks_is_seen() -> None:
    """x - y < 4 and x - y > 5."""
    zone = Zone.universe(3).constrain(1, 2, 4, strict=True)
    assert not zone.empty
    assert zone.constrain(2, 1, -5, strict=True).empty


def test_an_open_and_a_closed_end_do_not_meet() -> None:
    below = Zone.universe(2).constrain(1, 0, 3, strict=True)
    assert below.constrain(0, 1, -3).empty
    assert not Zone.universe(2).constrain(1, 0, 3).constrain(0, 1, -3).empty


def test_zones_may_be_disjoint_though_no_two_entries_disagree() -> None:
    """x1 < x2, x3 <= x4 in one, x2 <= x3, x4 <= x1 in the other: only the cycle of all four is negative."""
    one = Zone.universe(5).constrain(1, 2, 0, strict=True).constrain(3, 4, 0)
    other = Zone.universe(5).constrain(2, 3, 0).constrain(4, 1, 0)
    assert not one.intersects(other)


def test_the_empty_zone_stays_empty_and_is_one_value() -> None:
    empty = Zone.universe(3).constrain(1, 0, 2).constrain(0, 1, -4)
    other = Zone.zero(3).constrain(1, 2, -1)
    assert empty.empty
    assert empty == other
    assert hash(empty) == hash(other)
    changed = [empty.up(), empty.up_strict(), empty.reset(1, 3), empty.free(2), empty.constrain(1, 2, 9)]
    changed += [empty.extrapolate_lu_plus([None] * 3, [None] * 3), empty.intersect(Zone.universe(3))]
    assert all(zone == empty for zone in changed)
    assert empty.project([2]).empty
    assert Zone.universe(3).includes(empty)
    assert not empty.includes(Zone.zero(3))
    assert not empty.intersects(Zone.universe(3))


def test_an_operation_returns_a_new_zone() -> None:
    zone = Zone.zero(2)
    assert zone.up() != zone
    assert zone == Zone.zero(2)
    assert zone != Zone.zero(3)
    assert zone != "zone"


@pytest.mark.parametrize("value", [LIMIT, -LIMIT, 2**62, -(2**63)])
def test_a_constant_too_large_is_an_overflow(value: int) -> None:
    with pytest.raises(OverflowError, match="too large"):
        Zone.universe(2).constrain(1, 0, value)


def test_a_sum_too_large_is_an_overflow_and_spoils_nothing() -> None:
    zone = Zone.universe(3).constrain(1, 0, LIMIT - 1)
    assert zone.at(1, 0) == (LIMIT - 1, False)
    assert zone.constrain(2, 1, 0).at(2, 0) == (LIMIT - 1, False)
    with pytest.raises(OverflowError, match="too large"):
        zone.constrain(2, 1, 1)
    with pytest.raises(OverflowError, match="too large"):
        zone.reset(2, LIMIT)
    assert zone.at(2, 0) is None


def test_a_negative_cycle_of_large_numbers_is_empty_and_no_overflow() -> None:
    """Past the first negative cycle the numbers would double in every round."""
    size = 12
    large = [[(0 if i == j else -(2**58), False) for j in range(size)] for i in range(size)]
    assert Zone.from_matrix(large).empty


@pytest.mark.parametrize(
    "call",
    [
        lambda zone: zone.constrain(3, 0, 1),
        lambda zone: zone.constrain(0, -1, 1),
        lambda zone: zone.at(0, 3),
        lambda zone: zone.reset(0),
        lambda zone: zone.reset(1, -1),
        lambda zone: zone.free(0),
        lambda zone: zone.intersect(Zone.zero(2)),
        lambda zone: zone.includes(Zone.zero(2)),
        lambda zone: zone.intersects(Zone.zero(4)),
        lambda zone: zone.extrapolate_lu_plus([None] * 2, [None] * 3),
        lambda zone: zone.extrapolate_lu_plus([None] * 3, [None, -1, None]),
        lambda zone: zone.simulates(Zone.zero(2), [None] * 3, [None] * 3),
        lambda zone: zone.simulates(zone, [None] * 2, [None] * 3),
        lambda zone: zone.up_partly([3]),
        lambda zone: zone.up_partly([0]),
        lambda zone: zone.remap([]),
        lambda zone: zone.remap([1, 0]),
        lambda zone: zone.remap([0, -2]),
        lambda zone: zone.project([0]),
        lambda _: Zone.zero(0),
        lambda _: Zone.universe(-1),
        lambda _: Zone.zero(10**6),
        lambda _: Zone.from_matrix([[None], [None]]),
    ],
)
def test_nothing_from_python_is_trusted(call: Callable[[Zone], object]) -> None:
    with pytest.raises(ValueError, match=r"zone|clock|constant|matrix"):
        call(Zone.zero(3))
