"""A general network of timed automata, and what is asked of it, as flat arrays of integers.

The counterpart of :mod:`mitlplan.search.tables` for networks whose automata move one by one, in pairs or by
broadcast: what UPPAAL and TChecker call a system. Tests and assignments of integers become programs for a
stack machine (``native/system.hpp``). What a target asks of clocks counts among the constants of a location
that it names, so that the extrapolation keeps it apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    Expression,
    Network,
    Number,
    Query,
    Target,
    Test,
    Urgency,
    Variable,
    ticks_per_second,
)
from mitlplan.automata.transducer import Guard
from mitlplan.search.tables import (
    BOUNDS_COLUMNS,
    GUARD_COLUMNS,
    Constants,
    Interner,
    guard_row,
    put_rows,
    ticks_of,
)

PUSH, LOAD, STORE = 0, 1, 2
_WORDS = {"+": 3, "-": 4, "*": 5, "==": 6, "!=": 7, "<": 8, "<=": 9, ">": 10, ">=": 11}
_URGENCY = {Urgency.NORMAL: 0, Urgency.URGENT: 1, Urgency.COMMITTED: 2}
_ALONE = -1
_NO_CLOCK = -1


@dataclass(frozen=True, eq=False)
class SystemTables:
    """A network and its targets in the form that the native search takes.

    Parameters
    ----------
    arrays
        The columns, by the names that ``native/reachability_bindings.cpp`` reads.
    scale
        Ticks a second.
    edges
        For each edge of the tables the automaton and the number of the edge there.
    targets
        The targets, in the order of the aims.
    """

    arrays: dict[str, Any]
    scale: int
    edges: tuple[tuple[int, int], ...]
    targets: tuple[Target, ...]


def tabulate_system(network: Network, query: Query, *, objective: bool) -> SystemTables:
    """The tables of `network` with the targets of `query`.

    Parameters
    ----------
    objective
        Whether the time that has passed is a clock of its own, which the search minimises.

    Raises
    ------
    OverflowError
        If a time needs more ticks than 64-bit arithmetic holds safely.
    ValueError
        If an expression is nested too deeply.
    """
    return _Tabulation(network, query, objective).run()


class _Tabulation:
    def __init__(self, network: Network, query: Query, objective: bool) -> None:
        self.network = network
        self.query = query
        self.objective = objective
        self.scale = ticks_per_second(network, query)
        self.clocks = {name: number for number, name in enumerate(network.clocks, start=1)}
        self.variables = {variable.name: number for number, variable in enumerate(network.variables)}
        self.channels = {channel.name: number for number, channel in enumerate(network.channels)}
        self.guards, self.bounds, self.clock_sets = Interner(), Interner(), Interner()
        self.programs, self.place_sets = Interner(), Interner()
        counts = [len(automaton.locations) for automaton in network.automata]
        self.first = np.cumsum([0, *counts]).astype(np.int32)

    def run(self) -> SystemTables:
        count = len(self.network.clocks) + 1
        columns: dict[str, Any] = {
            "clocks": count + self.objective,
            "time_clock": count if self.objective else _NO_CLOCK,
            "broadcast": np.array([each.broadcast for each in self.network.channels], dtype=np.uint8),
            "component_start": self.first,
            "initial": self._column(
                int(first) + automaton.initial
                for first, automaton in zip(self.first, self.network.automata, strict=False)
            ),
        }
        for name in ("least", "most", "initial"):
            columns[f"variable_{name}"] = self._column(getattr(each, name) for each in self.network.variables)
        edges = self._automata(columns)
        targets = [target for target in self.query.targets if self._possible(target)]
        columns["aim_places"] = self._column(self._places(target) for target in targets)
        columns["aim_guard"] = self._column(self._guard(target.guard) for target in targets)
        columns["aim_tests"] = self._column(self._tests(target.tests) for target in targets)
        put_rows(columns, "guard", self.guards, GUARD_COLUMNS)
        put_rows(columns, "bounds", self.bounds, BOUNDS_COLUMNS)
        put_rows(columns, "clock_set", self.clock_sets, {"clock": np.int32})
        put_rows(columns, "program", self.programs, {"word": np.int32})
        put_rows(columns, "place_set", self.place_sets, {"place": np.int32})
        return SystemTables(columns, self.scale, tuple(edges), tuple(targets))

    @staticmethod
    def _column(numbers: Iterable[int]) -> Any:
        return np.array(list(numbers), dtype=np.int32)

    def _ticks(self, seconds: Fraction) -> int:
        return ticks_of(seconds, self.scale)

    def _guard(self, guard: Guard) -> int:
        return self.guards(guard_row(guard, self.clocks.__getitem__, self._ticks))

    def _clock_set(self, names: Iterable[str]) -> int:
        return self.clock_sets(tuple(sorted(self.clocks[name] for name in names)))

    # -- automata ------------------------------------------------------------------------------------------

    def _automata(self, columns: dict[str, Any]) -> list[tuple[int, int]]:
        """Locations and edges, those of a location side by side; which edge is which."""
        places: list[tuple[int, int, int, int]] = []
        rows: list[tuple[int, ...]] = []
        starts, order = [0], []
        for number, automaton in enumerate(self.network.automata):
            constants = self._constants(automaton)
            leaving: list[list[int]] = [[] for _ in automaton.locations]
            for index, edge in enumerate(automaton.edges):
                leaving[edge.source].append(index)
            for at, location in enumerate(automaton.locations):
                places.append(
                    (
                        self._guard(location.invariant),
                        self.bounds(self._bounds_row(constants.at.get(at, {}))),
                        self._clock_set(location.stopped),
                        _URGENCY[location.urgency],
                    )
                )
                rows += [self._edge(automaton, number, index) for index in leaving[at]]
                order += [(number, index) for index in leaving[at]]
                starts.append(len(rows))
        table = np.array(places, dtype=np.int32).reshape(-1, 4)
        for index, name in enumerate(("invariant", "bounds", "stopped")):
            columns[f"place_{name}"] = np.ascontiguousarray(table[:, index])
        columns["place_urgency"] = table[:, 3].astype(np.uint8)
        columns["edge_start"] = self._column(starts)
        table = np.array(rows, dtype=np.int32).reshape(-1, 7)
        for index, name in enumerate(
            ("target", "guard", "resets", "channel", "tests", "updates", "sends"),
        ):
            kind = np.uint8 if name == "sends" else np.int32
            columns[f"edge_{name}"] = table[:, index].astype(kind)
        return order

    def _bounds_row(self, constants: dict[str, tuple[int, int]]) -> tuple[tuple[int, int, int], ...]:
        return tuple(sorted((self.clocks[clock], *pair) for clock, pair in constants.items()))

    def _edge(self, automaton: Automaton, number: int, index: int) -> tuple[int, ...]:
        edge = automaton.edges[index]
        side = edge.synchronisation
        return (
            int(self.first[number]) + edge.target,
            self._guard(edge.guard),
            self._clock_set(edge.resets),
            _ALONE if side is None else self.channels[side.channel],
            self._tests(edge.tests),
            self._updates(edge.assignments),
            int(side is not None and side.sends),
        )

    def _constants(self, automaton: Automaton) -> Constants:
        """What clocks are still compared with in each location of one automaton."""
        constants = Constants(self._ticks)
        for at, location in enumerate(automaton.locations):
            constants.read(at, location.invariant)
        for edge in automaton.edges:
            constants.read(edge.source, edge.guard)
        for target in self.query.targets:
            asked = next(iter(target.locations), self.network.automata[0].name)
            if asked == automaton.name:
                for at, location in enumerate(automaton.locations):
                    if target.locations.get(asked, location.name) == location.name:
                        constants.read(at, target.guard)
        constants.spread((edge.source, edge.target, edge.resets) for edge in automaton.edges)
        return constants

    # -- targets -------------------------------------------------------------------------------------------

    def _possible(self, target: Target) -> bool:
        """Whether all that `target` names is there."""
        named = {automaton.name: automaton for automaton in self.network.automata}
        return all(
            name in named and any(location.name == at for location in named[name].locations)
            for name, at in target.locations.items()
        )

    def _places(self, target: Target) -> int:
        numbers = []
        for name, at in target.locations.items():
            automaton = self.network.automaton(name)
            numbers.append(int(self.first[automaton]) + self.network.automata[automaton].index(at))
        return self.place_sets(tuple(sorted(numbers)))

    # -- integers ------------------------------------------------------------------------------------------

    def _tests(self, tests: Iterable[Test]) -> int:
        words: list[int] = []
        for test in tests:
            words += [*self._pushed(test.left), *self._pushed(test.right), _WORDS[test.comparison]]
        return self.programs(tuple(words))

    def _updates(self, assignments: Iterable[Assignment]) -> int:
        words: list[int] = []
        for assignment in assignments:
            words += [*self._pushed(assignment.value), STORE, self.variables[assignment.variable]]
        return self.programs(tuple(words))

    def _pushed(self, expression: Expression) -> list[int]:
        match expression:
            case Number(value):
                return [PUSH, value]
            case Variable(name):
                return [LOAD, self.variables[name]]
            case Arithmetic(operator, left, right):
                return [*self._pushed(left), *self._pushed(right), _WORDS[operator]]
