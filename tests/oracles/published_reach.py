"""The least time to reach a target of a network of timed automata, by brute force over ticks.

Delays are whole ticks of 1/n seconds, clocks age until they are past every constant, and states are visited
in order of time. With closed constraints whose constants are on the grid nothing is lost; a strict one is
met a tick late, so least times with and without it are told apart by two values of n. Written from the
semantics of UPPAAL: committed locations first, a channel joins two, a broadcast takes everyone who can
receive, urgent locations let no time pass, a stopped clock stands still.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from mitlplan.automata.timed_automaton import Edge, Network, Query, Target, Urgency, holds, value_of
from mitlplan.automata.transducer import Guard, Relation

Move = tuple[tuple[int, int], ...]
"""Pairs of automaton and edge, the sender first."""


@dataclass(frozen=True)
class State:
    locations: tuple[int, ...]
    ages: tuple[int, ...]
    values: tuple[int, ...]


@dataclass(frozen=True)
class Reached:
    """The least time, and the moves with the times at which they are made."""

    time: Fraction
    trace: tuple[tuple[Fraction, Move], ...]


def reach(
    network: Network, query: Query, *, resolution: int = 1, latest: Fraction = Fraction(100)
) -> Reached | None:
    """The fastest way to a target on the grid, or ``None`` if there is none up to `latest`."""
    runner = _Runner(network, query, resolution)
    return runner.search(query, int(latest * resolution))


class _Runner:
    def __init__(self, network: Network, query: Query, resolution: int) -> None:
        self.network = network
        self.resolution = resolution
        self.clock = {name: index for index, name in enumerate(network.clocks)}
        self.variable = [variable.name for variable in network.variables]
        self.bounds = {variable.name: (variable.least, variable.most) for variable in network.variables}
        self.broadcasts = {channel.name for channel in network.channels if channel.broadcast}
        self.leaving = [
            [
                [index for index, edge in enumerate(each.edges) if edge.source == at]
                for at in range(len(each.locations))
            ]
            for each in network.automata
        ]
        guards = [location.invariant for each in network.automata for location in each.locations]
        guards += [edge.guard for each in network.automata for edge in each.edges]
        guards += [target.guard for target in query.targets]
        self.oldest = max((int(each.bound * resolution) for guard in guards for each in guard), default=0) + 1

    def search(self, query: Query, latest: int) -> Reached | None:
        begin = State(
            tuple(each.initial for each in self.network.automata),
            (0,) * len(self.clock),
            tuple(variable.initial for variable in self.network.variables),
        )
        if not self.within_invariants(begin):
            return None
        before: dict[State, tuple[State, int, Move] | None] = {begin: None}
        now, later = deque([begin]), deque[State]()
        for time in range(latest + 1):
            while now:
                state = now.popleft()
                if any(self.meets(state, target) for target in query.targets):
                    return self.traced(before, state, time)
                for move, after in self.moves(state):
                    if after not in before:
                        before[after] = (state, time, move)
                        now.append(after)
                older = self.delayed(state)
                if older is not None and older not in before:
                    before[older] = (state, time, ())
                    later.append(older)
            now, later = later, deque()
        return None

    def traced(
        self, before: Mapping[State, tuple[State, int, Move] | None], state: State, time: int
    ) -> Reached:
        trace = []
        step = before[state]
        while step is not None:
            state, at, move = step
            if move:
                trace.append((Fraction(at, self.resolution), move))
            step = before[state]
        return Reached(Fraction(time, self.resolution), tuple(reversed(trace)))

    def meets(self, state: State, target: Target) -> bool:
        located = all(
            each.locations[at].name == target.locations.get(each.name, each.locations[at].name)
            for each, at in zip(self.network.automata, state.locations, strict=True)
        )
        values = dict(zip(self.variable, state.values, strict=True))
        return (
            located
            and self.satisfied(target.guard, state.ages)
            and all(holds(test, values) for test in target.tests)
        )

    def satisfied(self, guard: Guard, ages: tuple[int, ...]) -> bool:
        return all(self.compared(ages[self.clock[each.clock]], each.relation, each.bound) for each in guard)

    def compared(self, age: int, relation: Relation, bound: Fraction) -> bool:
        other = bound * self.resolution
        match relation:
            case Relation.LESS:
                return age < other
            case Relation.AT_MOST:
                return age <= other
            case Relation.AT_LEAST:
                return age >= other
            case Relation.GREATER:
                return age > other

    def delayed(self, state: State) -> State | None:
        located = [
            each.locations[at] for each, at in zip(self.network.automata, state.locations, strict=True)
        ]
        if any(location.urgency is not Urgency.NORMAL for location in located):
            return None
        stopped = frozenset[str]().union(*(location.stopped for location in located))
        ages = tuple(
            age if name in stopped else min(age + 1, self.oldest)
            for name, age in zip(self.clock, state.ages, strict=True)
        )
        older = State(state.locations, ages, state.values)
        return older if self.within_invariants(older) else None

    def within_invariants(self, state: State) -> bool:
        here = zip(self.network.automata, state.locations, strict=True)
        return all(self.satisfied(each.locations[at].invariant, state.ages) for each, at in here)

    def moves(self, state: State) -> Iterator[tuple[Move, State]]:
        committed = [
            each.locations[at].urgency is Urgency.COMMITTED
            for each, at in zip(self.network.automata, state.locations, strict=True)
        ]
        for move in self.enabled(state):
            if any(committed) and not any(committed[place] for place, _ in move):
                continue
            after = self.moved(state, move)
            if after is not None:
                yield move, after

    def enabled(self, state: State) -> Iterator[Move]:
        for place, index, edge in self.open_edges(state):
            sent = edge.synchronisation
            if sent is None:
                yield ((place, index),)
            elif sent.sends:
                receivers = self.receivers(state, place, sent.channel)
                if sent.channel in self.broadcasts:
                    for chosen in product(*receivers.values()):
                        yield ((place, index), *zip(receivers, chosen, strict=True))
                else:
                    for other, edges in receivers.items():
                        yield from (((place, index), (other, each)) for each in edges)

    def receivers(self, state: State, sender: int, channel: str) -> dict[int, list[int]]:
        found: dict[int, list[int]] = {}
        for place, index, edge in self.open_edges(state):
            heard = edge.synchronisation
            if place != sender and heard is not None and not heard.sends and heard.channel == channel:
                found.setdefault(place, []).append(index)
        return found

    def open_edges(self, state: State) -> Iterator[tuple[int, int, Edge]]:
        values = dict(zip(self.variable, state.values, strict=True))
        for place, (each, at) in enumerate(zip(self.network.automata, state.locations, strict=True)):
            for index in self.leaving[place][at]:
                edge = each.edges[index]
                if self.satisfied(edge.guard, state.ages) and all(holds(test, values) for test in edge.tests):
                    yield place, index, edge

    def moved(self, state: State, move: Move) -> State | None:
        locations, ages = list(state.locations), list(state.ages)
        values = dict(zip(self.variable, state.values, strict=True))
        for place, index in move:
            edge = self.network.automata[place].edges[index]
            locations[place] = edge.target
            for clock in edge.resets:
                ages[self.clock[clock]] = 0
            for assignment in edge.assignments:
                name = assignment.variable
                values[name] = value_of(assignment.value, values)
                low, high = self.bounds[name]
                if not low <= values[name] <= high:
                    return None
        after = State(tuple(locations), tuple(ages), tuple(values.values()))
        return after if self.within_invariants(after) else None
