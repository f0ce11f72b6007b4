"""The crossings at which the sum of cost / duration along a chain is least.

Every crossing has a window, every duration between two crossings its bounds, and any two crossings may be
held apart: a convex problem over difference bounds. What leaves no choice is found first, in exact
arithmetic: all times keep a bound with equality if it lies on a cycle of weight 0, and bounds on such cycles
are among those that the earliest times keep with equality. Crossings on one cycle move together, and for the
others there is a point strictly inside all bounds. From there a logarithmic barrier is followed; with m
bounds and barrier weight v the sum is within m v of the least one, and that tells when to stop. (S. Boyd and
L. Vandenberghe, Convex Optimization, 2004, section 11.)
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, pairwise
from math import lcm
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

Array: TypeAlias = NDArray[np.float64]
Window: TypeAlias = tuple[Fraction, Fraction]

TICK = Fraction(1, 10**6)
"""What crossings are rounded to, and by how much a strict bound is kept; in seconds."""

_GAP = 1e-9
_EASING = 0.2
_MOST_STEPS = 60
_SHORTEST_STEP = 1e-9
_DENSE = 40
"""Up to so many unknowns, full matrices are quicker than sparse ones."""


@dataclass(frozen=True, slots=True)
class Span:
    """What is done between two crossings.

    Parameters
    ----------
    cost
        In one second; in d seconds a d-th of it.
    least, most
        Seconds; a `most` of ``None`` is no bound.
    """

    cost: float
    least: Fraction
    most: Fraction | None = None


@dataclass(frozen=True, slots=True)
class Apart:
    """Two crossings, by their numbers: from `earlier` to `later` it takes `least` or more; more, if strict.

    A negative `least` bounds how long it takes the other way round.
    """

    earlier: int
    later: int
    least: Fraction
    strict: bool = False

    @property
    def broken(self) -> Apart:
        """What holds exactly where this does not."""
        return Apart(self.later, self.earlier, -self.least, not self.strict)


def cheapest_times(
    spans: Sequence[Span], windows: Sequence[Window], apart: Sequence[Apart] = ()
) -> list[Fraction] | None:
    """The crossings, a window each, with a span between each two; exact numbers that keep every bound.

    Parameters
    ----------
    spans
        In order.
    windows
        One more than `spans`.
    apart
        What else is asked of the crossings; a strict bound is kept by a millionth of a second.

    Returns
    -------
    list of Fraction or None
        ``None``, if no times keep all bounds.

    Examples
    --------
    >>> start, end = Fraction(0), Fraction(6)
    >>> spans = [Span(1.0, Fraction(1)), Span(4.0, Fraction(1))]
    >>> windows = [(start, start), (start, end), (end, end)]
    >>> [str(time) for time in cheapest_times(spans, windows)]
    ['0', '2', '6']
    >>> [str(time) for time in cheapest_times(spans, windows, [Apart(2, 1, Fraction(-3))])]
    ['0', '3', '6']
    """
    bounds = list(_bounds(spans, windows, apart))
    scale = lcm(TICK.denominator, *(least.denominator for _, _, least in bounds))
    ticks = [(earlier, later, int(least * scale)) for earlier, later, least in bounds]
    # Time 0 is a node of its own, behind the crossings.
    earliest = _earliest(len(windows) + 1, ticks)
    if earliest is None:
        return None
    choice = _Choice.of([span.cost for span in spans], ticks, earliest, scale)
    return _nearest(choice.settle(), ticks, scale)


def _bounds(
    spans: Sequence[Span], windows: Sequence[Window], apart: Sequence[Apart]
) -> Iterator[tuple[int, int, Fraction]]:
    """Every bound, as how long it takes at least from a crossing to another."""
    origin = len(windows)
    for place, (low, high) in enumerate(windows):
        yield origin, place, low
        yield place, origin, -high
    for place, span in enumerate(spans):
        yield place, place + 1, span.least
        if span.most is not None:
            yield place + 1, place, -span.most
    for one in apart:
        yield one.earlier, one.later, one.least + (TICK if one.strict else 0)


# ----------------------------------------------------------------------------------------- in whole ticks

_Bound: TypeAlias = tuple[int, int, int]


def _earliest(count: int, bounds: Sequence[_Bound]) -> list[int] | None:
    """The least times that keep all bounds, the last node at time 0; ``None`` if there are none.

    These are the longest ways from there: the algorithm of Bellman and Ford.
    """
    onward: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    for earlier, later, least in bounds:
        onward[earlier].append((later, least))
    times: list[int | None] = [None] * (count - 1) + [0]
    visits = [0] * count
    waiting, listed = deque([count - 1]), [False] * count
    while waiting:
        node = waiting.popleft()
        listed[node] = False
        visits[node] += 1
        now = times[node]
        if visits[node] > count:
            return None
        assert now is not None
        for later, least in onward[node]:
            known = times[later]
            if known is None or known < now + least:
                if later == count - 1:
                    return None
                times[later] = now + least
                if not listed[later]:
                    listed[later] = True
                    waiting.append(later)
    return [time for time in times if time is not None]


def _latest(count: int, bounds: Sequence[_Bound]) -> list[int] | None:
    """The greatest times that keep all bounds."""
    mirrored = _earliest(count, [(later, earlier, least) for earlier, later, least in bounds])
    return None if mirrored is None else [-time for time in mirrored]


def _nearest(times: Sequence[float], bounds: Sequence[_Bound], scale: int) -> list[Fraction]:
    """Times that keep all bounds, one after the other at the tick that is nearest to what it should be.

    What is settled narrows what the others may be.
    """
    count = len(times) + 1
    low, high = _earliest(count, bounds), _latest(count, bounds)
    assert low is not None
    assert high is not None
    onward: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    back: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    for earlier, later, least in bounds:
        onward[earlier].append((later, least))
        back[later].append((earlier, least))
    grid = scale // TICK.denominator
    for place, time in enumerate(times):
        settled = min(max(round(time * TICK.denominator) * grid, low[place]), high[place])
        _push(low, onward, place, settled, 1)
        _push(high, back, place, settled, -1)
    return [Fraction(time, scale) for time in low[:-1]]


def _push(
    ends: list[int], ways: Sequence[Sequence[tuple[int, int]]], place: int, to: int, sense: int
) -> None:
    """Move one end, and those that it moves in turn: all least times up or all greatest times down."""
    if ends[place] == to:
        return
    ends[place] = to
    waiting = deque([place])
    while waiting:
        node = waiting.popleft()
        for other, least in ways[node]:
            pushed = ends[node] + sense * least
            if sense * (pushed - ends[other]) > 0:
                ends[other] = pushed
                waiting.append(other)


# ------------------------------------------------------------------------------------- what is left to choose


@dataclass(frozen=True, slots=True)
class _Choice:
    """Groups of crossings that only move together, and the bounds between them, in seconds.

    `offset` is how far behind its group's moment each crossing is; group 0 is that of time 0. The durations
    of the spans between groups are ``change @ moments + lag``, where `moments` are those of the groups from 1
    on; ``bound @ moments - limit`` are the margins of all bounds, which at `begin` are positive.
    """

    group: NDArray[np.int64]
    offset: Array
    cost: Array
    change: Any
    lag: Array
    bound: Any
    limit: Array
    begin: Array

    @classmethod
    def of(
        cls, costs: Sequence[float], bounds: Sequence[_Bound], earliest: Sequence[int], scale: int
    ) -> _Choice:
        count = len(earliest)
        tight = np.array([(i, j) for i, j, least in bounds if earliest[j] - earliest[i] == least])
        links = csr_array((np.ones(len(tight)), (tight[:, 0], tight[:, 1])), shape=(count, count))
        groups, label = connected_components(links, directed=True, connection="strong")
        # The group of time 0 comes first, the others in the order of their first crossing.
        number: dict[int, int] = {int(label[count - 1]): 0}
        for one in label.tolist():
            number.setdefault(one, len(number))
        group = [number[one] for one in label.tolist()]
        first = {one: time for time, one in reversed([*zip(earliest, group, strict=True)])} | {0: 0}
        offset = [time - first[one] for time, one in zip(earliest, group, strict=True)]
        between = {
            (group[i], group[j], least + offset[i] - offset[j])
            for i, j, least in bounds
            if group[i] != group[j]
        }
        moved = [
            (group[i], group[j], offset[j] - offset[i], cost)
            for cost, (i, j) in zip(costs, pairwise(range(count - 1)), strict=True)
            if group[i] != group[j] and cost > 0
        ]
        ordered = sorted(between)
        change = _differences([(i, j) for i, j, _, _ in moved], groups)
        bound = _differences([(i, j) for i, j, _ in ordered], groups)
        full = groups <= _DENSE
        return cls(
            np.array(group[:-1]),
            np.array(offset[:-1]) / scale,
            np.array([cost for _, _, _, cost in moved]),
            change.toarray() if full else change,
            np.array([lag for _, _, lag, _ in moved]) / scale,
            bound.toarray() if full else bound,
            np.array([least for _, _, least in ordered]) / scale,
            _inside(groups, ordered) / scale,
        )

    def settle(self) -> list[float]:
        """The best times of the crossings, in seconds."""
        moments = self.begin
        if len(moments) and len(self.cost):
            weight = self._sum(moments) / len(self.limit)
            while len(self.limit) * weight > _GAP * self._sum(moments):
                moments = self._centred(moments, weight)
                weight *= _EASING
            moments = self._centred(moments, weight)
        times: Array = np.append(0.0, moments)[self.group] + self.offset
        return [float(time) for time in times]

    def _durations(self, moments: Array) -> Array:
        return np.asarray(self.change @ moments + self.lag)

    def _margins(self, moments: Array) -> Array:
        return np.asarray(self.bound @ moments - self.limit)

    def _sum(self, moments: Array) -> float:
        return float((self.cost / self._durations(moments)).sum())

    def _centred(self, moments: Array, weight: float) -> Array:
        """Newton's method on the sum and `weight` times the barrier."""
        value = self._barrier(moments, weight)
        for _ in range(_MOST_STEPS):
            step, slope = self._newton(moments, weight)
            if slope < _GAP * weight:
                break
            size = 1.0
            while not (found := self._barrier(moments + size * step, weight)) <= value - 0.1 * size * slope:
                size /= 2
                if size < _SHORTEST_STEP:
                    return moments
            moments, value = moments + size * step, found
        return moments

    def _barrier(self, moments: Array, weight: float) -> float:
        margins = self._margins(moments)
        if (margins <= 0).any() or (self._durations(moments) <= 0).any():
            return np.inf
        return self._sum(moments) - weight * float(np.log(margins).sum())

    def _newton(self, moments: Array, weight: float) -> tuple[Array, float]:
        """The step, and the decrease that it promises."""
        durations, margins = self._durations(moments), self._margins(moments)
        downhill = self.change.T @ (self.cost / durations**2) + weight * (self.bound.T @ (1 / margins))
        curved = _weighed(self.change, 2 * self.cost / durations**3)
        curved = curved + _weighed(self.bound, weight / margins**2)
        step = _solved(curved, downhill)
        return step, float(downhill @ step)


def _inside(groups: int, bounds: Sequence[_Bound]) -> Array:
    """Times of the groups from 1 on, strictly between all bounds, about as far as is possible, in ticks."""
    if groups == 1:
        return np.zeros(0)
    # Time 0 comes last there. A cycle has a bound for every group at most, and a tick or more to spare: with
    # whole ticks made that much finer, a bound can always be kept by one.
    finer = groups + 1
    turned = [((i - 1) % groups, (j - 1) % groups, least * finer) for i, j, least in bounds]
    spare = max(1, *(abs(least) for _, _, least in turned))
    while True:
        eased = [(i, j, least + spare) for i, j, least in turned]
        low, high = _earliest(groups, eased), _latest(groups, eased)
        if low is not None and high is not None:
            middle: Array = (np.array(low[:-1], dtype=np.float64) + np.array(high[:-1])) / 2
            return middle / finer
        assert spare > 1
        spare = max(1, spare // 4)


def _differences(pairs: Sequence[tuple[int, int]], groups: int) -> Any:
    """For each pair the row of the second moment less the first; group 0 is always at time 0."""
    rows = np.repeat(np.arange(len(pairs)), 2)
    columns = np.fromiter(chain.from_iterable(pairs), dtype=np.int64) - 1
    signs = np.tile([-1.0, 1.0], len(pairs))
    kept = columns >= 0
    return csr_array((signs[kept], (rows[kept], columns[kept])), shape=(len(pairs), groups - 1))


def _weighed(rows: Any, weights: Array) -> Any:
    """The sum of the squares of the rows, a weight each, as a matrix."""
    return rows.T @ (rows * weights[:, None] if isinstance(rows, np.ndarray) else diags_array(weights) @ rows)


def _solved(matrix: Any, right: Array) -> Array:
    full = isinstance(matrix, np.ndarray)
    return np.asarray(np.linalg.solve(matrix, right) if full else spsolve(matrix.tocsc(), right))
