"""Loops: runs that go on for ever, with exactly periodic times.

The zone graph without the time of the mission is finite, and an infinite run through its extrapolation
exists if and only if one exists in the network (Li 2009: LU-abstractions preserve Büchi acceptance;
inclusion would not, so zones are told apart by equality). A strongly connected part in which the robot
moves and every Büchi set is visited yields loops; if there is none there is no loop at all. A loop in the
graph is not yet a timetable: its delays have to repeat, which is a linear program in the times of one round
and the period. Every round after the second obeys the same constraints as the second, because whatever is
read was reset at most one round before, or only grows older.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from mitlplan import _core
from mitlplan.search.fastest import MEGABYTE, Exhausted, Limits, Stopped, drive
from mitlplan.search.schedule import Difference, Path, columns, differences, infinitesimals_a_tick, listed
from mitlplan.search.tables import KINDS, Tables

ORIGINS = 64
"""From how many states of a strongly connected part loops are sought."""

LARGEST_DENOMINATOR = 10_000
"""Of a period, in ticks."""


@dataclass(frozen=True, eq=False, slots=True)
class Lasso:
    """A path to a state, and a round back to it; rows of edges as in :class:`Path`."""

    prefix: NDArray[np.int32]
    round: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Timetable:
    """Times of the steps of the prefix and of one round, in seconds, and the period of the round."""

    times: tuple[Fraction, ...]
    period: Fraction


def lassos(
    tables: Tables, limits: Limits, most_states: int | None = None
) -> Iterator[Lasso] | Exhausted | Stopped:
    """Loops of the network, the shortest of each strongly connected part first, or a proof of none.

    Parameters
    ----------
    tables
        Of a network without the time as objective.
    most_states
        Gives up when the graph has more states.
    """
    search = _core.Search(
        tables.arrays,
        record=True,
        memory=0 if limits.megabytes is None else limits.megabytes * MEGABYTE,
    )
    stopped = drive(search, tables, limits, most_states)
    if stopped is not None:
        return Stopped(stopped.reason, None, stopped.states)
    graph = _Graph.of(search, tables)
    parts = list(graph.accepting_parts())
    if not parts:
        return Exhausted(search.stored)
    return graph.shortest_lassos(parts)


@dataclass(frozen=True, eq=False)
class _Graph:
    search: Any
    components: int
    source: NDArray[np.int32]
    target: NDArray[np.int32]
    marks: NDArray[np.uint64]
    weight: NDArray[np.int64]
    wanted: int

    @staticmethod
    def of(search: Any, tables: Tables) -> _Graph:
        source, target, marks = search.graph()
        arrays = tables.arrays
        edges = np.asarray(search.recorded_driver_edges())
        # The least time of a move is what its guard asks of the map's clock.
        start = arrays["guard_start"]
        least = np.zeros(len(start) - 1, dtype=np.int64)
        for guard in range(len(start) - 1):
            for entry in range(start[guard], start[guard + 1]):
                asks_driver = arrays["guard_clock"][entry] == arrays["driver_clock"]
                if asks_driver and not arrays["guard_upper"][entry]:
                    least[guard] = arrays["guard_value"][entry]
        taken = np.where(edges < 0, 0, least[arrays["move_guard"][edges]])
        wanted = sum(1 << number for number in range(tables.acceptance + 1))
        return _Graph(
            search,
            tables.components,
            np.asarray(source),
            np.asarray(target),
            np.asarray(marks),
            taken,
            wanted,
        )

    def accepting_parts(self) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """The strongly connected parts in which every mark is met: their states and their inner steps."""
        count = self.search.stored
        ones = np.ones(len(self.source), dtype=np.int8)
        adjacency: Any = csr_array((ones, (self.source, self.target)), (count, count))
        _, part = connected_components(adjacency, connection="strong")
        inner = np.flatnonzero(part[self.source] == part[self.target])
        order = inner[np.argsort(part[self.source[inner]], kind="stable")]
        labels = part[self.source[order]]
        for chunk in np.split(order, np.flatnonzero(np.diff(labels)) + 1):
            if len(chunk) == 0:
                continue
            met = int(np.bitwise_or.reduce(self.marks[chunk]))
            if met & self.wanted == self.wanted:
                yield np.unique(self.source[chunk]), chunk

    def shortest_lassos(self, parts: Sequence[tuple[NDArray[np.intp], NDArray[np.intp]]]) -> Iterator[Lasso]:
        for states, steps in parts:
            leaving: dict[int, list[int]] = {}
            for step in steps.tolist():
                leaving.setdefault(int(self.source[step]), []).append(step)
            # The states that were reached first have the shortest prefixes.
            found = []
            for origin in states[:ORIGINS].tolist():
                round_trip = self.shortest_round(origin, leaving)
                if round_trip is not None:
                    found.append((sum(int(self.weight[step]) for step in round_trip), origin, round_trip))
            for _, origin, round_trip in sorted(found):
                edges = [np.asarray(self.search.recorded_edges(step)) for step in round_trip]
                prefix = np.asarray(self.search.path_to(origin)).reshape(-1, self.components)
                yield Lasso(prefix, np.stack(edges))

    def shortest_round(self, origin: int, leaving: dict[int, list[int]]) -> list[int] | None:
        """The steps of a quickest way from a state back to it on which every mark is met."""
        start = (origin, 0)
        best: dict[tuple[int, int], int] = {start: 0}
        came: dict[tuple[int, int], tuple[tuple[int, int], int]] = {}
        queue = [(0, 0, start)]
        count = 0
        while queue:
            cost, _, at = heappop(queue)
            if cost > best[at]:
                continue
            state, met = at
            for step in leaving.get(state, ()):
                after = (int(self.target[step]), met | int(self.marks[step]) & self.wanted)
                if after == (origin, self.wanted):
                    way = [step]
                    while at != start:
                        at, before = came[at]
                        way.append(before)
                    return way[::-1]
                # Among ways that take the same time the one with fewer steps.
                weight = cost + (int(self.weight[step]) << 20) + 1
                if weight < best.get(after, 1 << 120):
                    best[after] = weight
                    came[after] = (at, step)
                    count += 1
                    heappush(queue, (weight, count, after))
        return None


def timetable(tables: Tables, lasso: Lasso, epsilon: Fraction) -> Timetable | None:
    """Periodic times for a loop, with the least end of the first round; ``None`` if there are none.

    Parameters
    ----------
    epsilon
        Where strict bounds leave no least end, how near to come to it, in seconds.
    """
    first = len(lasso.prefix) - 1
    length = len(lasso.round)
    unrolled = Path(np.concatenate([lasso.prefix, lasso.round, lasso.round]), KINDS[0])
    constraints = listed(differences(tables, unrolled))
    period = _least_period(constraints, first, length)
    if period is None:
        return None
    for extra in (Fraction(0), epsilon * tables.scale / 2):
        times = _times_for_period(constraints, first, length, period + extra, epsilon * tables.scale / 2)
        if times is not None:
            scale = tables.scale
            return Timetable(tuple(time / scale for time in times), (period + extra) / scale)
    return None


def _folded(step: int, first: int, length: int) -> tuple[int, int]:
    """A step of the unrolled path as one of the prefix or the first round, and by how many periods later."""
    if step < first:
        return step, 0
    rounds, place = divmod(step - first, length)
    return first + place, rounds


def _least_period(constraints: Sequence[Difference], first: int, length: int) -> Fraction | None:
    """The period, in ticks, of the times with the least end of the first round."""
    from scipy.optimize import linprog

    variables = first + length + 1  # the period is the last one
    rows, columns_, entries, bounds = [], [], [], []
    for row, one in enumerate(constraints):
        (source, early), (target, late) = (_folded(step, first, length) for step in (one.source, one.target))
        # The row says: t_source + early * period - t_target - late * period <= -weight.
        for column, entry in ((source, 1), (target, -1), (variables - 1, early - late)):
            rows.append(row)
            columns_.append(column)
            entries.append(entry)
        bounds.append(-one.weight)
    # The stubs of scipy know dense matrices and, in some releases, a single bound only.
    matrix: Any = csr_array((entries, (rows, columns_)), shape=(len(constraints), variables))
    objective = np.zeros(variables)
    objective[first] = objective[-1] = 1
    limits: Any = [(0, 0), *[(0, None)] * (variables - 1)]
    solution = linprog(objective, A_ub=matrix, b_ub=bounds, bounds=limits, method="highs")
    if solution.status != 0 or solution.x is None:
        return None
    return Fraction(float(solution.x[-1])).limit_denominator(LARGEST_DENOMINATOR)


def _times_for_period(
    constraints: Sequence[Difference], first: int, length: int, period: Fraction, epsilon: Fraction
) -> list[Fraction] | None:
    """The least times with exactly this period, in ticks; strict bounds are kept by parts of `epsilon`."""
    factor = period.denominator
    folded = []
    for one in constraints:
        (source, early), (target, late) = (_folded(step, first, length) for step in (one.source, one.target))
        weight = one.weight * factor - (late - early) * period.numerator
        if source == target:
            if weight > 0 or (weight == 0 and one.strict):
                return None
            continue
        folded.append(Difference(source, target, weight, one.strict))
    try:
        times = _core.earliest_times(first + length, *columns(folded))
    except ValueError:
        return None
    parts = infinitesimals_a_tick(times, folded, epsilon * factor)
    return [Fraction(ticks * parts + rest, parts * factor) for ticks, rest in times]
