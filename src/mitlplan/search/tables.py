"""The Python half of the border: a network as flat arrays of integers.

Times become ticks of the least common denominator, clocks, signals and sets of them become numbers, and
everything that occurs often is interned. What each location contributes to the extrapolation (the largest
constants its clocks are still compared with: Behrmann, Bouyer, Fleury, Larsen 2003) is computed here by a
worklist over the edges of each small transducer; the map needs none, because every move resets its clock.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan import _core
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

FARTHEST = 2**53
"""Ticks at which distances are cut off, so that sums of them are safe; as bounds they are still right."""

NOTHING = 0
"""The number of the empty guard, of no resets, no signals and no bounds: they are interned first."""

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
        return self.guards(guard_row(constraints, self.clock, self.ticks)) if constraints else NOTHING

    def signal_set(self, signals: Collection[str] = ()) -> int:
        if not signals:
            return NOTHING
        mask = 0
        for signal in signals:
            number = self.signals.numbers.get(signal)
            if number is not None:
                mask |= 1 << number
        return self.signal_sets(mask)

    def run(self) -> Tables:
        network = self.network
        columns: dict[str, Any] = {}
        self.signal_sets(0)
        for empty in (self.guards, self.resets, self.bounds):
            empty(())
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
                self.signal_set([name for name, where in self.network.predicates.items() if label in where])
                for label in range(len(automaton.label_sets))
            ],
            dtype=np.int32,
        )
        times, which = _pairs(automaton.least, automaton.most, len(durations))
        guards = np.array([self.map_guard(durations, *pair) for pair in times] or [0], dtype=np.int32)[which]
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
        count = automaton.location_count
        starts = np.zeros(count + 1, dtype=np.int32)
        np.cumsum(np.bincount(automaton.source, minlength=count), out=starts[1:])
        # Of the times in order, that the largest may be found among their numbers.
        ordered = sorted({UNBOUNDED, *durations})
        rank = {time: number for number, time in enumerate(ordered)}
        asked = np.array([rank[durations[least] or UNBOUNDED] for least, _ in times], dtype=np.int32)
        allowed = np.array([rank[_time(durations, most)] for _, most in times], dtype=np.int32)
        stays = np.array(
            [rank[_time(durations, index)] for index in range(NEVER, len(durations))], dtype=np.int32
        )
        lower = _largest_of_each(asked, which, starts)
        upper = np.maximum(stays[automaton.invariant + 1], _largest_of_each(allowed, which, starts))
        constants, which = _pairs(lower, upper, len(ordered))
        bound_numbers = np.array(
            [
                self.bounds(((self.clock(MAP_CLOCK), ordered[low], ordered[high]),) if low or high else ())
                for low, high in constants
            ],
            dtype=np.int32,
        )
        resets = self.resets((self.clock(MAP_CLOCK),) if MAP_CLOCK in self.clocks.numbers else ())
        moves, begins = len(automaton.source), len(automaton.initial)
        locations = {
            "invariant": np.append(invariants, 0),
            "still": np.append(stills, 0),
            "bounds": np.append(bound_numbers[which], 0),
            "emits": np.append(labels[automaton.label_of], NOTHING),
        }
        edges = {
            "start": np.append(starts, moves + begins),
            "target": np.append(automaton.target, np.array(automaton.initial, dtype=np.int32)),
            "guard": np.append(guards, np.zeros(begins, dtype=np.int32)),
            "resets": np.full(moves + begins, resets, dtype=np.int32),
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
            leaving: dict[str, list[Edge]] = {location.name: [] for location in transducer.locations}
            for edge in edges:
                if edge.requires <= self.emitted:
                    leaving[edge.source].append(edge)
            for location in transducer.locations:
                column.start.append(len(column.rows))
                for edge in leaving[location.name]:
                    target = number[edge.target] if kind == "move" else number[edge.source]
                    resets = tuple(sorted(self.clock(clock) for clock in edge.resets))
                    column.rows.append(
                        (
                            target,
                            self.guard(edge.guard),
                            self.resets(resets) if resets else NOTHING,
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
            NOTHING,
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
        columns["location_still"] = np.zeros(count + len(own), dtype=np.int32)
        columns["location_still"][:count] = driver["still"]
        for index, name in enumerate(names):
            column = np.empty(count + len(own), dtype=np.int64 if name == "deadline" else np.int32)
            column[:count] = driver.get(name, 0 if name == "deadline" else UNBOUNDED)
            column[count:] = own[:, index]
            columns[f"location_{name}"] = column

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
        if len(result) == 0:
            return result.reshape(-1)
        goals = []
        for name in self.fields.numbers:
            shown = np.zeros(len(automaton.label_sets), dtype=np.bool_)
            shown[list(self.network.predicates[str(name)])] = True
            goals.append(np.flatnonzero(shown[automaton.label_of]).astype(np.int32))
        ticks = np.array([self.ticks(duration) for duration in automaton.durations], dtype=np.int64)
        result[:, :count] = nearest(count, automaton.source, automaton.target, automaton.least, ticks, goals)
        # From before the start the way begins in any cell of the start.
        for row in result:
            row[count] = min(
                (there for there in row[list(automaton.initial)].tolist() if there >= 0), default=UNBOUNDED
            )
        return result.reshape(-1)


def nearest(
    count: int,
    source: NDArray[np.int32],
    target: NDArray[np.int32],
    time: NDArray[np.int32],
    ticks: NDArray[np.int64],
    goals: Sequence[NDArray[np.int32]],
) -> NDArray[np.int64]:
    """For each array of goals the least ticks from every place to one of them.

    Parameters
    ----------
    count
        How many places there are.
    source, target, time
        Shape (moves,): between which places, and the index into `ticks` of how long it takes.

    Returns
    -------
    int64, shape (goals, count)
        Negative where there is no way; what is farther than :data:`FARTHEST` counts as so far.
    """
    return _core.distances(count, source, target, time, ticks, list(goals)).reshape(-1, count)


def _pairs(
    first: NDArray[np.int32], second: NDArray[np.int32], count: int
) -> tuple[list[tuple[int, int]], NDArray[np.int64]]:
    """The distinct pairs of numbers from -1 to `count` - 1, in order, and the number of each among them."""
    if len(first) and _same(first) and _same(second):
        return [(int(first[0]), int(second[0]))], np.zeros(len(first), dtype=np.int64)
    width = count + 1
    keys = (first.astype(np.int64) + 1) * width + (second + 1)
    if width * width > len(keys):
        distinct, which = np.unique(keys, return_inverse=True)
    else:
        occurs = np.zeros(width * width, dtype=np.bool_)
        occurs[keys] = True
        distinct, which = np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[keys]
    return [(key // width - 1, key % width - 1) for key in distinct.tolist()], which.reshape(-1)


def _same(numbers: NDArray[np.int32]) -> bool:
    return bool(numbers.min() == numbers.max())


def _largest_of_each(
    values: NDArray[np.int32], which: NDArray[np.int64], starts: NDArray[np.int32]
) -> NDArray[np.int32]:
    """For each row of entries, ``values[which[start:next start]]``, the largest; 0 where there is none."""
    filled = starts[:-1] < starts[1:]
    result = np.zeros(len(filled), dtype=np.int32)
    if len(values) == 1:
        result[filled] = values[0]
    elif len(values):
        result[filled] = np.maximum.reduceat(values[which], starts[:-1][filled])
    return result


def _time(durations: Sequence[int], index: int) -> int:
    return UNBOUNDED if index == NEVER else durations[index]


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
    count = 0 if driver is None else len(driver["target"])
    starts = np.zeros(driver_locations + len(rows.start) + 1, dtype=np.int32)
    if driver is not None:
        starts[:driver_locations] = driver["start"][:driver_locations]
    starts[driver_locations:] = np.array([*rows.start, len(rows.rows)], dtype=np.int32) + count
    columns[f"{kind}_start"] = starts
    for index, name in enumerate(names):
        # Zeros that nobody writes cost nothing, however many moves there are.
        column = np.zeros(count + len(own), dtype=np.int32)
        if driver is not None and name in driver:
            column[:count] = driver[name]
        column[count:] = own[:, index]
        columns[f"{kind}_{name}"] = column


def _every_edge(transducer: Transducer) -> tuple[Edge, ...]:
    return (*transducer.edges, *transducer.endings, *transducer.parkings)


def ticks_per_second(network: Network) -> int:
    """The least common denominator of all times of `network`, in seconds: the scale of its tables.

    Raises
    ------
    OverflowError
        If a time needs more ticks than 64-bit arithmetic holds safely.
    """
    times = set(network.map.durations)
    for transducer in network.transducers:
        for edge in _every_edge(transducer):
            times.update(constraint.bound for constraint in edge.guard)
        for location in transducer.locations:
            times.update(constraint.bound for constraint in location.invariant)
            if location.deadline is not None:
                times.add(location.deadline.bound)
    scale = lcm(*(time.denominator for time in times))
    ticks_of(max(times, default=Fraction(0)), scale)
    return scale
