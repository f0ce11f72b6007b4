"""The Python half of the border: a network as flat arrays of integers.

Times become ticks of the least common denominator, clocks, signals and sets of them become numbers, and
everything that occurs often is interned. What each location contributes to the extrapolation (the largest
constants its clocks are still compared with: Behrmann, Bouyer, Fleury, Larsen 2003) is computed here by a
worklist over the edges of each small transducer; the map needs none, because every move resets its clock.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from mitlplan.automata.transducer import (
    NEVER,
    TIME,
    Edge,
    Guard,
    Location,
    MapAutomaton,
    Network,
    Relation,
    Restless,
    Transducer,
)

TICK_LIMIT = 2**60
"""Times beyond this many ticks are refused; the native side holds the same limit."""

EXACT_FLOATS = 2**53
"""Integers below this are exact as floats."""

MAP_CLOCK = "z"
UNBOUNDED = -1
KINDS = ("move", "ending", "parking")


@dataclass(frozen=True, eq=False)
class Tables:
    """A network in the form that the native search takes.

    Parameters
    ----------
    arrays
        The columns, by the names that ``native/tables.hpp`` explains.
    scale
        Ticks a second.
    acceptance
        How many Büchi sets there are; they are numbered from 1.
    cells
        How many locations of the driver are cells; the one behind them is where it begins.
    """

    arrays: dict[str, Any]
    scale: int
    acceptance: int
    cells: int

    @property
    def components(self) -> int:
        """The number of components, the map included."""
        return len(self.arrays["component_start"]) - 1


def tabulate(network: Network, *, objective: bool = True) -> Tables:
    """The tables of `network`.

    With `objective` the time of the mission is a clock that is never reset and that the search minimises;
    without, it is a clock like others, and drops out once nobody reads it.

    Raises
    ------
    OverflowError
        If a time needs more ticks than 64-bit arithmetic holds safely.
    """
    return _Tabulation(network, objective).run()


def ticks_of(seconds: Fraction, scale: int) -> int:
    """A time in ticks.

    Raises
    ------
    OverflowError
        If there are too many of them.
    """
    scaled = seconds * scale
    if scaled >= TICK_LIMIT:
        raise OverflowError(
            f"a time of {seconds} s is more than 2^60 ticks of 1/{scale} s, the common denominator "
            "of all times; use coarser times"
        )
    return int(scaled)


Row: TypeAlias = tuple[Any, ...]
"""Entries that stand one behind the other in the columns of a table."""


class Interner:
    """Numbers for values, in order of first appearance."""

    def __init__(self) -> None:
        self.numbers: dict[Hashable, int] = {}

    def __call__(self, value: Hashable) -> int:
        """The number of `value`."""
        return self.numbers.setdefault(value, len(self.numbers))


class Constants:
    """The largest lower and upper constants that clocks are still compared with, by location and clock.

    Local ones, by a worklist that goes backwards along the edges of one automaton: Behrmann, Bouyer, Fleury
    and Larsen 2003. A clock without an entry is not active.
    """

    def __init__(self, ticks: Callable[[Fraction], int]) -> None:
        self.at: dict[Hashable, dict[str, tuple[int, int]]] = {}
        self._ticks = ticks

    def read(self, location: Hashable, guard: Guard) -> None:
        """Note that `guard` is read in `location`."""
        for constraint in guard:
            value = self._ticks(constraint.bound)
            if constraint.relation in (Relation.LESS, Relation.AT_MOST):
                self._join(location, constraint.clock, UNBOUNDED, value)
            else:
                self._join(location, constraint.clock, value, UNBOUNDED)

    def _join(self, location: Hashable, clock: str, lower: int, upper: int) -> bool:
        here = self.at.setdefault(location, {})
        old = here.get(clock)
        new = (lower, upper) if old is None else (max(old[0], lower), max(old[1], upper))
        here[clock] = new
        return new != old

    def spread(self, edges: Iterable[tuple[Hashable, Hashable, frozenset[str]]]) -> None:
        """What is read behind an edge matters before it, unless the edge resets it."""
        into: dict[Hashable, list[tuple[Hashable, frozenset[str]]]] = {}
        for source, target, resets in edges:
            into.setdefault(target, []).append((source, resets))
        waiting = list(self.at)
        while waiting:
            location = waiting.pop()
            for source, resets in into.get(location, ()):
                changed = False
                for clock, (lower, upper) in list(self.at[location].items()):
                    if clock not in resets:
                        changed |= self._join(source, clock, lower, upper)
                if changed:
                    waiting.append(source)


GUARD_COLUMNS = {"clock": np.int32, "upper": np.uint8, "strict": np.uint8, "value": np.int64}
BOUNDS_COLUMNS = {"clock": np.int32, "lower": np.int64, "upper": np.int64}


def guard_row(guard: Guard, clock: Callable[[str], int], ticks: Callable[[Fraction], int]) -> Row:
    """A guard as a row of the tables."""
    return tuple(
        (
            clock(constraint.clock),
            constraint.relation in (Relation.LESS, Relation.AT_MOST),
            constraint.relation in (Relation.LESS, Relation.GREATER),
            ticks(constraint.bound),
        )
        for constraint in guard
    )


def put_rows(columns: dict[str, Any], name: str, interned: Interner, kinds: Mapping[str, Any]) -> None:
    """The interned rows as columns, one for each entry of `kinds`, and one that tells where rows begin."""
    rows: list[Any] = list(interned.numbers)
    flat = [entry for row in rows for entry in row]
    columns[f"{name}_start"] = _starts(rows)
    for index, (column, kind) in enumerate(kinds.items()):
        entries = flat if len(kinds) == 1 else [entry[index] for entry in flat]
        columns[f"{name}_{column}"] = np.array(entries, dtype=kind)


@dataclass
class _EdgeColumns:
    start: list[int] = field(default_factory=list)
    rows: list[tuple[int, int, int, int, int, int, int]] = field(default_factory=list)


class _Tabulation:
    def __init__(self, network: Network, objective: bool) -> None:
        self.network = network
        self.objective = objective
        self.scale = ticks_per_second(network)
        self.guards = Interner()
        self.resets = Interner()
        self.bounds = Interner()
        self.signal_sets = Interner()
        self.clocks = Interner()
        self.clocks("0")
        if objective:
            self.clocks(TIME)
        self.emitted = set(network.predicates) | {
            signal
            for transducer in network.transducers
            for edge in _every_edge(transducer)
            for signal in edge.emits
        }
        read = {
            signal
            for transducer in network.transducers
            for edge in _every_edge(transducer)
            for signal in edge.requires | edge.excludes
        }
        self.signals = Interner()
        for signal in sorted(self.emitted & read):
            self.signals(signal)
        self.fields = Interner()

    def ticks(self, seconds: Fraction) -> int:
        return ticks_of(seconds, self.scale)

    def clock(self, name: str) -> int:
        return self.clocks(name)

    def guard(self, constraints: Guard) -> int:
        return self.guards(guard_row(constraints, self.clock, self.ticks))

    def signal_set(self, signals: Iterable[str]) -> int:
        mask = 0
        for signal in signals:
            if signal in self.signals.numbers:
                mask |= 1 << self.signals(signal)
        return self.signal_sets(mask)

    def run(self) -> Tables:
        network = self.network
        columns: dict[str, Any] = {}
        self.signal_set(())
        self.guard(())
        self.resets(())
        self.bounds(())
        driver_locations, driver_edges = self.driver(network.map)
        component_start = [0, network.map.location_count + 1]
        location_rows: list[tuple[int, ...]] = []
        kinds = {kind: _EdgeColumns() for kind in KINDS}
        acceptance = 0
        for transducer in network.transducers:
            mark = 0
            if transducer.acceptance:
                acceptance += 1
                mark = acceptance
            self.transducer(transducer, component_start[-1], location_rows, kinds, mark)
            component_start.append(component_start[-1] + len(transducer.locations))
        if acceptance > 62:
            raise OverflowError("the formula has more than 62 unbounded promises; split the mission")
        self.put_locations(columns, driver_locations, location_rows)
        for kind in KINDS:
            own = driver_edges if kind == "move" else None
            _put_edges(columns, kind, kinds[kind], own, network.map.location_count + 1)
        self.put_interned(columns)
        park = np.full(network.map.location_count + 1, network.map.may_park, dtype=np.uint8)
        park[-1] = 0
        columns["parkable"] = park
        columns["component_start"] = np.array(component_start, dtype=np.int32)
        columns["distances"] = self.distances()
        columns["time_clock"] = self.clock(TIME) if self.objective else UNBOUNDED
        columns["driver_clock"] = self.clocks.numbers.get(MAP_CLOCK, UNBOUNDED)
        columns["clocks"] = len(self.clocks.numbers)
        return Tables(columns, self.scale, acceptance, network.map.location_count)

    # -- the map -------------------------------------------------------------------------------------------

    def driver(self, automaton: MapAutomaton) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[Any]]]:
        durations = [self.ticks(duration) for duration in automaton.durations]
        labels = np.array(
            [
                self.signal_set(name for name, where in self.network.predicates.items() if label in where)
                for label in range(len(automaton.label_sets))
            ],
            dtype=np.int32,
        )
        distinct, which = _distinct_pairs(automaton.least, automaton.most)
        guard_numbers = np.array(
            [self.map_guard(durations, int(least), int(most)) for least, most in distinct] or [0],
            dtype=np.int32,
        )
        guards = guard_numbers[which]
        invariants = np.array(
            [
                *(self.guards(((self.clock(MAP_CLOCK), True, False, value),)) for value in durations),
                0,
            ],
            dtype=np.int32,
        )[automaton.invariant]
        # In a step without a move the robot is still there: its longest stay is not over.
        stills = np.array(
            [
                *(self.guards(((self.clock(MAP_CLOCK), True, True, value),)) for value in durations),
                0,
            ],
            dtype=np.int32,
        )[automaton.invariant]
        ticks = np.array([*durations, UNBOUNDED], dtype=np.int64)
        lower = np.full(automaton.location_count, UNBOUNDED, dtype=np.int64)
        upper = ticks[automaton.invariant]
        asked = ticks[automaton.least]
        np.maximum.at(lower, automaton.source, np.where(asked > 0, asked, UNBOUNDED))
        np.maximum.at(upper, automaton.source, ticks[automaton.most])
        constants, which = _distinct_pairs(lower, upper)
        bound_numbers = np.array(
            [
                self.bounds(
                    ()
                    if low == UNBOUNDED and high == UNBOUNDED
                    else ((self.clock(MAP_CLOCK), int(low), int(high)),)
                )
                for low, high in constants
            ],
            dtype=np.int32,
        )
        count = automaton.location_count
        resets = self.resets((self.clock(MAP_CLOCK),) if MAP_CLOCK in self.clocks.numbers else ())
        empty = self.signal_set(())
        starts = np.searchsorted(automaton.source, np.arange(count + 1)).astype(np.int32)
        moves, begins = len(automaton.source), len(automaton.initial)
        locations = {
            "invariant": np.append(invariants, 0),
            "still": np.append(stills, 0),
            "bounds": np.append(bound_numbers[which], 0),
            "emits": np.append(labels[automaton.label_of], empty),
        }
        edges = {
            "start": np.append(starts, moves + begins),
            "target": np.append(automaton.target, automaton.initial),
            "guard": np.append(guards, np.zeros(begins)),
            "resets": np.full(moves + begins, resets),
        }
        return locations, edges

    def map_guard(self, durations: Sequence[int], least: int, most: int) -> int:
        # Every stay is positive, so a least time of 0 asks nothing.
        constraints: list[tuple[int, bool, bool, int]] = []
        if durations[least] > 0:
            constraints.append((self.clock(MAP_CLOCK), False, False, durations[least]))
        if most != NEVER:
            constraints.append((self.clock(MAP_CLOCK), True, False, durations[most]))
        return self.guards(tuple(constraints))

    # -- the transducers -----------------------------------------------------------------------------------

    def transducer(
        self,
        transducer: Transducer,
        first: int,
        location_rows: list[tuple[int, ...]],
        kinds: Mapping[str, _EdgeColumns],
        mark: int,
    ) -> None:
        number = {location.name: first + index for index, location in enumerate(transducer.locations)}
        constants = self.constants(transducer)
        for location in transducer.locations:
            relief = number[location.relief] if location.relief else UNBOUNDED
            location_rows.append((*self.location(location, constants[location.name]), relief))
        every = {"move": transducer.edges, "ending": transducer.endings, "parking": transducer.parkings}
        for kind, edges in every.items():
            column = kinds[kind]
            for location in transducer.locations:
                column.start.append(len(column.rows))
                for edge in edges:
                    if edge.source != location.name or not edge.requires <= self.emitted:
                        continue
                    target = number[edge.target] if kind == "move" else number[edge.source]
                    resets = tuple(sorted(self.clock(clock) for clock in edge.resets))
                    column.rows.append(
                        (
                            target,
                            self.guard(edge.guard),
                            self.resets(resets),
                            self.signal_set(edge.requires),
                            self.signal_set(edge.excludes),
                            self.signal_set(edge.emits),
                            mark if edge.marked else 0,
                        )
                    )

    def location(
        self, location: Location, constants: Mapping[str, tuple[int, int]]
    ) -> tuple[int, int, int, int, int, int, int]:
        restless = {Restless.NEVER: -1, Restless.ALWAYS: -2}.get(location.restless)
        if restless is None:
            restless = self.signals.numbers.get(location.target, -2) if location.target else -2
        deadline_clock, deadline = UNBOUNDED, 0
        if location.deadline is not None:
            deadline_clock = self.clock(location.deadline.clock)
            deadline = self.ticks(location.deadline.bound)
        bounds = self.bounds(
            tuple(
                sorted(
                    (self.clock(clock), lower, upper)
                    for clock, (lower, upper) in constants.items()
                    if not (self.objective and clock == TIME)
                )
            )
        )
        target = self.fields(location.target) if location.target else UNBOUNDED
        return (
            self.guard(location.invariant),
            bounds,
            self.signal_set(()),
            restless,
            target,
            deadline_clock,
            deadline,
        )

    def constants(self, transducer: Transducer) -> dict[str, dict[str, tuple[int, int]]]:
        """The largest lower and upper constants of each clock that is active in each location."""
        result = Constants(self.ticks)
        for location in transducer.locations:
            result.read(location.name, location.invariant)
        for edge in _every_edge(transducer):
            result.read(edge.source, edge.guard)
        result.spread([(edge.source, edge.target, edge.resets) for edge in transducer.edges])
        return {location.name: result.at.get(location.name, {}) for location in transducer.locations}

    # -- columns -------------------------------------------------------------------------------------------

    def put_locations(
        self,
        columns: dict[str, Any],
        driver: Mapping[str, NDArray[Any]],
        rows: Sequence[tuple[int, ...]],
    ) -> None:
        names = ("invariant", "bounds", "emits", "restless", "target", "deadline_clock", "deadline", "relief")
        count = len(driver["emits"])
        own = np.array(rows, dtype=np.int64).reshape(-1, len(names))
        columns["location_still"] = np.append(driver["still"], np.zeros(len(own))).astype(np.int32)
        for index, name in enumerate(names):
            default = 0 if name == "deadline" else UNBOUNDED
            head = driver.get(name, np.full(count, default))
            kind = np.int64 if name == "deadline" else np.int32
            columns[f"location_{name}"] = np.concatenate([head, own[:, index]]).astype(kind)

    def put_interned(self, columns: dict[str, Any]) -> None:
        put_rows(columns, "guard", self.guards, GUARD_COLUMNS)
        put_rows(columns, "reset", self.resets, {"clock": np.int32})
        put_rows(columns, "bounds", self.bounds, BOUNDS_COLUMNS)
        words = max(1, -(-len(self.signals.numbers) // 64))
        masks: list[Any] = list(self.signal_sets.numbers)
        columns["words"] = words
        columns["signals"] = np.array(
            [(mask >> (64 * word)) & (2**64 - 1) for mask in masks for word in range(words)],
            dtype=np.uint64,
        )

    def distances(self) -> NDArray[np.int64]:
        """For each target predicate the least ticks from each cell to one where it holds; negative: never."""
        automaton = self.network.map
        count = automaton.location_count
        result = np.zeros((len(self.fields.numbers), count + 1), dtype=np.int64)
        ticks = np.array([self.ticks(duration) for duration in automaton.durations], dtype=np.int64)
        times = ticks[automaton.least]
        # A sparse matrix drops weights of 0: one more for each move keeps them, and dividing takes it off.
        factor = 1 if times.all() else count + 1
        if (int(times.max(initial=0)) * factor + 1) * (count + 1) >= EXACT_FLOATS:
            return result.reshape(-1)
        weights = times * factor + (factor > 1)
        # A sparse matrix adds up entries of the same place: of parallel moves only the shortest is to count.
        order = np.lexsort((weights, automaton.source, automaton.target))
        ends = np.stack([automaton.target, automaton.source])[:, order]
        first = np.append(True, np.any(ends[:, 1:] != ends[:, :-1], axis=0))[: len(order)]
        reverse = csr_array((weights[order][first], (ends[0, first], ends[1, first])), shape=(count, count))
        for index, name in enumerate(self.fields.numbers):
            where = self.network.predicates[str(name)]
            goals = np.flatnonzero(np.isin(automaton.label_of, list(where)))
            if len(goals) == 0:
                result[index] = UNBOUNDED
                continue
            reached = dijkstra(reverse, indices=goals, min_only=True)
            finite = np.isfinite(reached)
            result[index, :count] = np.where(
                finite, np.where(finite, reached, 0).astype(np.int64) // factor, UNBOUNDED
            )
            from_start = [ticks for ticks in result[index, list(automaton.initial)] if ticks != UNBOUNDED]
            result[index, count] = min(from_start, default=UNBOUNDED)
        return result.reshape(-1)


def _distinct_pairs(first: NDArray[Any], second: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The distinct pairs in order, shape (distinct, 2), and the number of each pair among them."""
    # Not `np.unique(..., axis=0)`: it compares rows as bytes, some twenty times as slowly.
    order = np.lexsort((second, first))
    ordered = first[order], second[order]
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = (ordered[0][1:] != ordered[0][:-1]) | (ordered[1][1:] != ordered[1][:-1])
    which = np.empty(len(order), dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    return np.stack([ordered[0][new], ordered[1][new]], axis=1), which


def _starts(rows: Sequence[Sequence[Any]]) -> NDArray[np.int32]:
    return np.cumsum([0, *(len(row) for row in rows)]).astype(np.int32)


def _put_edges(
    columns: dict[str, Any],
    kind: str,
    rows: _EdgeColumns,
    driver: Mapping[str, NDArray[Any]] | None,
    driver_locations: int,
) -> None:
    names = ("target", "guard", "resets", "reads", "avoids", "emits", "marks")
    own = np.array(rows.rows, dtype=np.int32).reshape(-1, len(names))
    driver_start = np.zeros(driver_locations, dtype=np.int32) if driver is None else driver["start"]
    driver_count = 0 if driver is None else len(driver["target"])
    head = driver_start[:driver_locations]
    columns[f"{kind}_start"] = np.concatenate(
        [head, np.array([*rows.start, len(rows.rows)], dtype=np.int32) + driver_count]
    ).astype(np.int32)
    for index, name in enumerate(names):
        front: NDArray[np.int32] = np.zeros(driver_count, dtype=np.int32)
        if driver is not None and name in driver:
            front = driver[name].astype(np.int32)
        columns[f"{kind}_{name}"] = np.concatenate([front, own[:, index]]).astype(np.int32)


def _every_edge(transducer: Transducer) -> tuple[Edge, ...]:
    return (*transducer.edges, *transducer.endings, *transducer.parkings)


def ticks_per_second(network: Network) -> int:
    """The least common denominator of all times of `network`, in seconds: the scale of its tables."""
    times = set(network.map.durations)
    for transducer in network.transducers:
        for edge in _every_edge(transducer):
            times.update(constraint.bound for constraint in edge.guard)
        for location in transducer.locations:
            times.update(constraint.bound for constraint in location.invariant)
            if location.deadline is not None:
                times.add(location.deadline.bound)
    return lcm(*(time.denominator for time in times))
