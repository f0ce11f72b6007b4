"""Networks of timed automata as TChecker models (``.tck``).

Constants are integers as for UPPAAL. A channel becomes a pair of events and a synchronisation for each sender
and receiver; a broadcast takes along whoever can. TChecker has no stopped clocks. Targets become labels:
``tck-reach -a covreach -l`` followed by the labels named in the first lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from math import prod

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
        What is modelled, and the locations to be reached: one of some in each automaton that is asked for.
    bound
        A bound on the clock ``t``, in seconds, put on the edges into these locations; where such an edge
        hears a broadcast, and so may have no guard, on the location.
    notes
        Lines of comment.

    Raises
    ------
    ToolError
        If the network stops clocks or asks something of an edge that hears a broadcast, or the query is
        not of that kind.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Target
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1),))
    >>> print(write_tchecker(Network((walk,)), Query((Target({"robot": "there"}),))))
    # A time unit is 1 s: every constant was multiplied by 1.
    # tck-reach -a covreach -l goal0
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
    return _Writer(network, query, bound).text(notes)


def _goals(query: Query) -> dict[str, frozenset[str]]:
    """For each automaton that is asked for the locations one of which it must be in.

    Raises
    ------
    ToolError
        If they depend on where others are, or more is asked: a state has the labels of its locations alone.
    """
    asked = {frozenset(target.locations.items()) for target in query.targets}
    goals: dict[str, set[str]] = {}
    for name, location in (pair for each in asked for pair in each):
        goals.setdefault(name, set()).add(location)
    free = all(len(each) == len(goals) for each in asked)
    bounded = any(target.guard or target.tests for target in query.targets)
    if bounded or not asked or not free or len(asked) != prod(map(len, goals.values())):
        raise ToolError(
            "TChecker is asked for locations alone, in each automaton independently of the others"
        )
    return {name: frozenset(locations) for name, locations in goals.items()}


class _Writer:
    def __init__(self, network: Network, query: Query, bound: Fraction | None) -> None:
        network, query = with_identifiers(network, query, KEYWORDS)
        self._network = network
        self._goals = _goals(query)
        self._broadcast = frozenset(channel.name for channel in network.channels if channel.broadcast)
        self._label = {name: f"goal{index}" for index, name in enumerate(self._goals)}
        self._scale = ticks_per_second(network)
        if bound is not None:
            self._scale *= (bound * self._scale).denominator
            self._network = self._bounded(bound)
        self._event = identifiers((channel.name for channel in network.channels), KEYWORDS | {SILENT})

    def _bounded(self, bound: Fraction) -> Network:
        """The network in which no goal is entered after the bound."""
        in_time = (Constraint(TIME, Relation.AT_MOST, bound),)
        automata = []
        for each in self._network.automata:
            goals = {index for index, at in enumerate(each.locations) if self._is_goal(each.name, at)}
            entering = [edge for edge in each.edges if edge.target in goals]
            heard = {edge.target for edge in entering if self._hears(edge)}
            edges = tuple(
                replace(edge, guard=(*edge.guard, *in_time)) if edge.target in goals - heard else edge
                for edge in each.edges
            )
            locations = tuple(
                replace(at, invariant=(*at.invariant, *in_time)) if index in heard else at
                for index, at in enumerate(each.locations)
            )
            automata.append(replace(each, locations=locations, edges=edges))
        return replace(self._network, automata=tuple(automata))

    def _is_goal(self, name: str, location: Location) -> bool:
        return location.name in self._goals.get(name, ())

    def _hears(self, edge: Edge) -> bool:
        """Whether the edge takes part in a broadcast without being the sender."""
        side = edge.synchronisation
        return side is not None and not side.sends and side.channel in self._broadcast

    def text(self, notes: Iterable[str]) -> str:
        unit = "1 s" if self._scale == 1 else f"1/{self._scale} s"
        lines = [
            f"# A time unit is {unit}: every constant was multiplied by {self._scale}.",
            *(f"# {note}" for note in notes),
            f"# tck-reach -a covreach -l {','.join(self._label.values())}",
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
        if side.sends and side.channel in self._broadcast:
            return True
        return any(other != name for other in self._taking_part(side.channel, sends=not side.sends))

    def _attributes(self, automaton: Automaton, index: int, location: Location) -> Iterator[str]:
        if index == automaton.initial:
            yield "initial:"
        if self._is_goal(automaton.name, location):
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
        if guard and self._hears(edge):
            raise ToolError(
                f"in TChecker an edge that hears a broadcast has no guard, as {automaton.name} has at "
                f"{names[0]}; export the model to UPPAAL"
            )
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
