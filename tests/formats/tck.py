"""Reading TChecker models back, for tests: only what is written, and strictly.

Events called ``c_send`` and ``c_receive`` become a channel again; the synchronisations must be all the pairs
(or, for a broadcast, all the receivers of each sender).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from mitlplan.automata.timed_automaton import (
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Location,
    Network,
    Query,
    Synchronisation,
    Target,
    Test,
    Urgency,
)
from mitlplan.automata.transducer import Constraint
from mitlplan.formats.uppaal_scope import ArrayName, ClockName, IntegerName, Scope, View
from mitlplan.formats.uppaal_syntax import Place, Reader, conjuncts

NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


@dataclass
class _Process:
    locations: list[Location] = field(default_factory=list)
    labels: dict[str, str] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)
    initial: list[int] = field(default_factory=list)

    def index(self, name: str) -> int:
        return [location.name for location in self.locations].index(name)


def read_tck(text: str) -> tuple[Network, Query]:
    """The network, and the query for all labels at once."""
    return _Tck(text).read()


class _Tck:
    def __init__(self, text: str) -> None:
        self.lines = [line for line in text.splitlines() if not line.startswith("#")]
        self.scope = Scope()
        self.clocks: list[str] = []
        self.variables: list[BoundedInteger] = []
        self.events: list[str] = []
        self.processes: dict[str, _Process] = {}
        self.syncs: list[tuple[str, ...]] = []

    def read(self) -> tuple[Network, Query]:
        assert re.fullmatch(r"system:\w+", self.lines[0])
        for line in self.lines[1:]:
            head, rest = line.split(":", 1)
            getattr(self, f"read_{head}")(rest)
        assert len(set(self.events)) == len(self.events)
        channels = [event.removesuffix("_send") for event in self.events if event.endswith("_send")]
        automata = []
        targets = {}
        for name, process in self.processes.items():
            (initial,) = process.initial
            automata.append(Automaton(name, tuple(process.locations), tuple(process.edges), initial))
            for location in process.labels:
                targets[name] = location
        network = Network(
            tuple(automata),
            tuple(self.clocks),
            tuple(Channel(channel, self.is_broadcast(channel)) for channel in channels),
            tuple(self.variables),
        )
        for channel in network.channels:
            self.check_synchronisations(network, channel)
        return network, Query((Target(targets),))

    def is_broadcast(self, channel: str) -> bool:
        return any(f"@{channel}_receive?" in part for sync in self.syncs for part in sync)

    def check_synchronisations(self, network: Network, channel: Channel) -> None:
        sides: dict[bool, list[str]] = {True: [], False: []}
        for automaton in network.automata:
            for sends, names in sides.items():
                if any(
                    edge.synchronisation == Synchronisation(channel.name, sends) for edge in automaton.edges
                ):
                    names.append(automaton.name)
        expected = set()
        for sender in sides[True]:
            others = [name for name in sides[False] if name != sender]
            first = f"{sender}@{channel.name}_send"
            if channel.broadcast:
                expected.add((first, *(f"{name}@{channel.name}_receive?" for name in others)))
            else:
                assert others
                expected |= {(first, f"{name}@{channel.name}_receive") for name in others}
        assert {sync for sync in self.syncs if sync[0].endswith(f"@{channel.name}_send")} == expected

    def declared(self, size: int, name: str) -> list[str]:
        assert NAME.fullmatch(name)
        return (
            [name]
            if size == 1 and f"{name}[0]" not in "\n".join(self.lines)
            else [f"{name}[{index}]" for index in range(size)]
        )

    def read_clock(self, rest: str) -> None:
        size, name = rest.split(":")
        names = self.declared(int(size), name)
        self.clocks += names
        array = ArrayName(tuple(ClockName(each) for each in names))
        self.scope.names[name] = ClockName(name) if names == [name] else array

    def read_int(self, rest: str) -> None:
        size, least, most, initial, name = rest.split(":")
        names = self.declared(int(size), name)
        self.variables += [BoundedInteger(each, int(least), int(most), int(initial)) for each in names]
        array = ArrayName(tuple(IntegerName(each) for each in names))
        self.scope.names[name] = IntegerName(name) if names == [name] else array

    def read_event(self, rest: str) -> None:
        assert NAME.fullmatch(rest)
        self.events.append(rest)

    def read_process(self, rest: str) -> None:
        assert NAME.fullmatch(rest)
        assert rest not in self.processes
        self.processes[rest] = _Process()

    def attributes(self, text: str) -> dict[str, str]:
        if not text:
            return {}
        assert text[0] == "{"
        assert text[-1] == "}"
        parts = (part.partition(":") for part in text[1:-1].split(" : "))
        return {key.strip(): value.strip() for key, _, value in parts}

    def condition(self, text: str) -> tuple[tuple[Constraint, ...], tuple[Test, ...]]:
        place = Place("", 1, "")
        clocks: list[Constraint] = []
        tests: list[Test] = []
        if text:
            reader = Reader(text, place)
            tree = reader.expression()
            reader.finish()
            for part in conjuncts(tree):
                found = View(self.scope, place).condition(part)
                clocks += found[0]
                tests += found[1]
        return tuple(clocks), tuple(tests)

    def read_location(self, rest: str) -> None:
        match = re.fullmatch(r"(\w+):(\w+)(\{.*\})?", rest)
        assert match is not None
        process = self.processes[match[1]]
        attributes = self.attributes(match[3] or "")
        invariant, tests = self.condition(attributes.pop("invariant", ""))
        assert tests == ()
        urgency = Urgency.NORMAL
        if attributes.pop("committed", None) is not None:
            urgency = Urgency.COMMITTED
        if attributes.pop("urgent", None) is not None:
            urgency = Urgency.URGENT
        if attributes.pop("initial", None) is not None:
            process.initial.append(len(process.locations))
        if (label := attributes.pop("labels", None)) is not None:
            process.labels[match[2]] = label
        assert attributes == {}
        process.locations.append(Location(match[2], invariant, urgency=urgency))

    def read_edge(self, rest: str) -> None:
        match = re.fullmatch(r"(\w+):(\w+):(\w+):(\w+)(\{.*\})?", rest)
        assert match is not None
        name, source, target, event, text = match.groups()
        assert event in self.events
        attributes = self.attributes(text or "")
        guard, tests = self.condition(attributes.pop("provided", ""))
        side = None
        if event != "tau":
            channel, _, kind = event.rpartition("_")
            side = Synchronisation(channel, sends=kind == "send")
        process = self.processes[name]
        edge = Edge(process.index(source), process.index(target), guard, synchronisation=side, tests=tests)
        process.edges.append(self.with_updates(edge, attributes.pop("do", "")))
        assert attributes == {}

    def with_updates(self, edge: Edge, text: str) -> Edge:
        view = View(self.scope, Place("", 1, ""))
        resets, assignments = set(), []
        for statement in filter(None, text.split("; ")):
            reader = Reader(statement, view.place)
            found = view.meaning(reader.reference())
            reader.expect("=")
            value = reader.expression()
            reader.finish()
            if isinstance(found, ClockName):
                assert view.constant(value) == 0
                resets.add(found.name)
            else:
                assert isinstance(found, IntegerName)
                assignments.append(Assignment(found.name, view.integer(value)))
        return replace(edge, resets=frozenset(resets), assignments=tuple(assignments))

    def read_sync(self, rest: str) -> None:
        self.syncs.append(tuple(rest.split(":")))
