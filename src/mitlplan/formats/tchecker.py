"""Networks of timed automata as TChecker models (``.tck``).

Constants are integers as for UPPAAL. A channel becomes a pair of events and a synchronisation for each sender
and receiver; a broadcast takes along whoever can. TChecker has no stopped clocks. Targets become labels:
``tck-reach -a reach -l`` followed by the labels named in the first lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction

from mitlplan.automata.timed_automaton import (
    Automaton,
    Edge,
    Location,
    Network,
    Query,
    Synchronisation,
    Urgency,
    ticks_per_second,
)
from mitlplan.automata.transducer import TIME, Constraint, Relation
from mitlplan.errors import ToolError
from mitlplan.formats.identifiers import identifiers, with_identifiers
from mitlplan.formats.uppaal import bounds, comparison, update

KEYWORDS = frozenset(["system", "clock", "int", "process", "location", "event", "edge", "sync", "nop"])
SILENT = "tau"


def write_tchecker(
    network: Network, query: Query, *, bound: Fraction | None = None, notes: Iterable[str] = ()
) -> str:
    """The text of a TChecker model.

    Parameters
    ----------
    network, query
        What is modelled, and the one target to be reached; only locations are asked for there.
    bound
        A bound on the clock ``t``, in seconds, put on the edges into the target.
    notes
        Lines of comment.

    Raises
    ------
    ToolError
        If the network stops clocks, or the query is not of that kind.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Target
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1),))
    >>> print(write_tchecker(Network((walk,)), Query((Target({"robot": "there"}),))))
    # A time unit is 1 s: every constant was multiplied by 1.
    # tck-reach -a reach -l goal0
    system:mitlplan
    event:tau
    process:robot
    location:robot:here{initial:}
    location:robot:there{labels: goal0}
    edge:robot:here:there:tau
    <BLANKLINE>
    """
    if any(location.stopped for automaton in network.automata for location in automaton.locations):
        raise ToolError("TChecker has no stopped clocks; export the model to UPPAAL, or another construction")
    if len(query.targets) != 1 or query.targets[0].guard or query.targets[0].tests:
        raise ToolError("TChecker is asked for one set of locations")
    return _Writer(network, query, bound).text(notes)


class _Writer:
    def __init__(self, network: Network, query: Query, bound: Fraction | None) -> None:
        network, query = with_identifiers(network, query, KEYWORDS)
        self._network = network
        self._goals = query.targets[0].locations
        self._label = {name: f"goal{index}" for index, name in enumerate(self._goals)}
        self._scale = ticks_per_second(network)
        if bound is not None:
            self._scale *= (bound * self._scale).denominator
            self._network = self._bounded(bound)
        self._event = identifiers((channel.name for channel in network.channels), KEYWORDS | {SILENT})

    def _bounded(self, bound: Fraction) -> Network:
        """The network with the bound on every edge into a goal."""
        in_time = (Constraint(TIME, Relation.AT_MOST, bound),)
        automata = []
        for each in self._network.automata:
            goal = self._goals.get(each.name)
            edges = (
                replace(edge, guard=(*edge.guard, *in_time))
                if each.locations[edge.target].name == goal
                else edge
                for edge in each.edges
            )
            automata.append(replace(each, edges=tuple(edges)))
        return replace(self._network, automata=tuple(automata))

    def text(self, notes: Iterable[str]) -> str:
        unit = "1 s" if self._scale == 1 else f"1/{self._scale} s"
        lines = [
            f"# A time unit is {unit}: every constant was multiplied by {self._scale}.",
            *(f"# {note}" for note in notes),
            f"# tck-reach -a reach -l {','.join(self._label.values())}",
            "system:mitlplan",
            *self._declarations(),
        ]
        for automaton in self._network.automata:
            lines += self._process(automaton)
        lines += self._synchronisations()
        return "\n".join(lines) + "\n"

    def _declarations(self) -> Iterator[str]:
        for name, size in _arrays(self._network.clocks):
            yield f"clock:{size}:{name}"
        for variable in self._network.variables:
            base, bracket, _ = variable.name.partition("[")
            same = [each for each in self._network.variables if each.name.partition("[")[0] == base]
            if variable is same[0]:
                size = len(same) if bracket else 1
                yield f"int:{size}:{variable.least}:{variable.most}:{variable.initial}:{base}"
        yield f"event:{SILENT}"
        for event in self._event.values():
            yield f"event:{event}_send"
            yield f"event:{event}_receive"

    def _process(self, automaton: Automaton) -> Iterator[str]:
        yield f"process:{automaton.name}"
        for index, location in enumerate(automaton.locations):
            attributes = list(self._attributes(automaton, index, location))
            shown = f"{{{' : '.join(attributes)}}}" if attributes else ""
            yield f"location:{automaton.name}:{location.name}{shown}"
        for edge in automaton.edges:
            # An event without a partner would happen alone.
            if edge.synchronisation is None or self._has_partner(automaton.name, edge.synchronisation):
                yield self._edge(automaton, edge)

    def _has_partner(self, name: str, side: Synchronisation) -> bool:
        if side.sends and any(each.broadcast for each in self._network.channels if each.name == side.channel):
            return True
        return any(other != name for other in self._taking_part(side.channel, sends=not side.sends))

    def _attributes(self, automaton: Automaton, index: int, location: Location) -> Iterator[str]:
        if index == automaton.initial:
            yield "initial:"
        if self._goals.get(automaton.name) == location.name:
            yield f"labels: {self._label[automaton.name]}"
        if location.urgency is Urgency.COMMITTED:
            yield "committed:"
        if location.urgency is Urgency.URGENT:
            yield "urgent:"
        if location.invariant:
            yield f"invariant: {' && '.join(bounds(location.invariant, self._scale))}"

    def _edge(self, automaton: Automaton, edge: Edge) -> str:
        names = [automaton.locations[end].name for end in (edge.source, edge.target)]
        event = SILENT
        if edge.synchronisation is not None:
            side = "send" if edge.synchronisation.sends else "receive"
            event = f"{self._event[edge.synchronisation.channel]}_{side}"
        guard = [*bounds(edge.guard, self._scale), *map(comparison, edge.tests)]
        done = [*(f"{clock} = 0" for clock in sorted(edge.resets)), *map(update, edge.assignments)]
        attributes = [f"provided: {' && '.join(guard)}"] if guard else []
        attributes += [f"do: {'; '.join(done)}"] if done else []
        shown = f"{{{' : '.join(attributes)}}}" if attributes else ""
        return f"edge:{automaton.name}:{names[0]}:{names[1]}:{event}{shown}"

    def _synchronisations(self) -> Iterator[str]:
        for channel in self._network.channels:
            event = self._event[channel.name]
            senders, receivers = (list(self._taking_part(channel.name, sends=side)) for side in (True, False))
            for sender in senders:
                others = [receiver for receiver in receivers if receiver != sender]
                if channel.broadcast and others:
                    heard = "".join(f":{receiver}@{event}_receive?" for receiver in others)
                    yield f"sync:{sender}@{event}_send{heard}"
                elif not channel.broadcast:
                    yield from (f"sync:{sender}@{event}_send:{other}@{event}_receive" for other in others)

    def _taking_part(self, channel: str, *, sends: bool) -> Iterator[str]:
        for automaton in self._network.automata:
            sides = (edge.synchronisation for edge in automaton.edges if edge.synchronisation is not None)
            if any(side.channel == channel and side.sends == sends for side in sides):
                yield automaton.name


def _arrays(names: Iterable[str]) -> Iterator[tuple[str, int]]:
    """Base names and sizes: 1 for what is no array."""
    sizes: dict[str, int] = {}
    for name in names:
        base = name.partition("[")[0]
        sizes[base] = sizes.get(base, 0) + 1
    yield from sizes.items()
