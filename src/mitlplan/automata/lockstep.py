"""Transducers in lock step as a network that other tools can run.

Elsewhere there is no step in which everyone moves at once, so a step becomes a chain of edges in no time: the
map moves (or, for a silent step, stays), sets the signals that its label means and passes the turn to the
first transducer; each takes one edge, sets what it emits and passes the turn on. All of that happens in
committed locations, so nothing comes between, and a chain that cannot be finished is no step. A clock makes
sure that time passes between two steps. For the last step the turn is passed on other channels: ``end``
where nothing is owed whatever follows, ``park`` where nothing is owed if the robot stays for ever.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from mitlplan.automata import transducer as steps
from mitlplan.automata.chart import chart
from mitlplan.automata.timed_automaton import (
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Location,
    Network,
    Number,
    Query,
    Synchronisation,
    Target,
    Test,
    Urgency,
    Variable,
)
from mitlplan.automata.transducer import TIME, Constraint, Guard, Relation

STEP = "step"
"""The clock that measures the time since the last step."""

MAP = "map"
MAP_CLOCK = "z"
FINAL, PARKED = "final", "parked"
_TURNS = {"go": "", "end": FINAL, "park": PARKED}


@dataclass(frozen=True, slots=True)
class Lockstep:
    """A network that steps as the transducers do.

    Parameters
    ----------
    network
        The first automaton is the map, the others are the transducers in their order.
    query
        Reach the end of a last step; parking counts where the robot may park.
    cells
        For each location of the map automaton the cell, or ``None`` for the start and the end.
    meanings
        What the variables ``s[i]`` and the clocks ``x[i]`` stand for.
    """

    network: Network
    query: Query
    cells: tuple[int | None, ...]
    meanings: tuple[str, ...]


def lockstep(network: steps.Network, names: Sequence[str], *, parkings: bool) -> Lockstep:
    """The network as timed automata with channels, committed locations and bounded integers.

    Parameters
    ----------
    names
        Of the cells.
    parkings
        Whether a plan may end by staying somewhere for ever.
    """
    return _Lockstep(network, names, parkings and network.map.may_park).build()


@dataclass
class _Lockstep:
    source: steps.Network
    names: Sequence[str]
    parks: bool
    signals: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)

    def build(self) -> Lockstep:
        for transducer in self.source.transducers:
            for location in transducer.locations:
                for constraint in location.invariant:
                    self.clock(constraint.clock)
            for edge in (*transducer.edges, *transducer.endings, *transducer.parkings):
                for signal in sorted(edge.requires | edge.excludes):
                    self.signals.setdefault(signal, f"s[{len(self.signals)}]")
                for clock in sorted({each.clock for each in edge.guard} | edge.resets):
                    self.clock(clock)
        robot, cells = self.robot()
        watchers = [self.watcher(place) for place in range(len(self.source.transducers))]
        kinds = [kind for kind in _TURNS if kind != "park" or self.parks]
        channels = [Channel(f"{kind}[{place}]") for kind in kinds for place in range(len(watchers))]
        last = watchers[-1].name
        return Lockstep(
            network=Network(
                automata=(robot, *watchers),
                clocks=(MAP_CLOCK, STEP, *self.clocks.values(), TIME),
                channels=tuple(channels),
                variables=tuple(BoundedInteger(name) for name in self.signals.values()),
            ),
            query=Query(tuple(Target({last: _TURNS[kind]}) for kind in kinds[1:]), clock=TIME),
            cells=cells,
            meanings=tuple(
                f"{shown} is {meant}" for shown, meant in self._meant(self.signals) + self._meant(self.clocks)
            ),
        )

    def clock(self, meaning: str) -> None:
        """See to it that a clock of the transducers has a name."""
        if meaning != TIME:
            self.clocks.setdefault(meaning, f"x[{len(self.clocks)}]")

    def _meant(self, shown: dict[str, str]) -> list[tuple[str, str]]:
        return [(name, meaning) for meaning, name in shown.items()]

    # -- the map -------------------------------------------------------------------------------------------

    def robot(self) -> tuple[Automaton, tuple[int | None, ...]]:
        """A location a cell, and one where the robot has just got there and the others take their turns."""
        plain = chart(self.source.map, self.names, clock=MAP_CLOCK)
        count = len(plain.locations)
        arrived = [Location(f"{at.name}_", urgency=Urgency.COMMITTED) for at in plain.locations]
        start = Location("start", urgency=Urgency.COMMITTED)
        over = Location("over")
        edges = list(self._steps(plain, count))
        for cell in range(count):
            edges.append(Edge(count + cell, cell, synchronisation=_turn("go", 0)))
            edges.append(Edge(count + cell, 2 * count + 1, synchronisation=_turn("end", 0)))
            if self.parks:
                edges.append(Edge(count + cell, 2 * count + 1, synchronisation=_turn("park", 0)))
        automaton = Automaton(MAP, (*plain.locations, *arrived, start, over), tuple(edges), 2 * count)
        return automaton, (*range(count), *range(count), None, None)

    def _steps(self, plain: Automaton, count: int) -> Iterator[Edge]:
        later = (Constraint(STEP, Relation.GREATER, Fraction(0)),)
        stepped = frozenset({STEP})
        for cell in self.source.map.initial:
            yield Edge(2 * count, count + cell, assignments=self._signals_of(cell))
        for move in plain.edges:
            yield Edge(
                move.source,
                count + move.target,
                (*move.guard, *later),
                move.resets | stepped,
                assignments=self._signals_of(move.target),
            )
        for cell in range(count):
            # In a step without a move the robot is still there: its longest stay is not over.
            still = tuple(replace(bound, relation=Relation.LESS) for bound in plain.locations[cell].invariant)
            yield Edge(cell, count + cell, (*still, *later), stepped, assignments=self._signals_of(cell))

    def _signals_of(self, cell: int) -> tuple[Assignment, ...]:
        """The label's predicates as they are, and every other signal off."""
        label = int(self.source.map.label_of[cell])
        return tuple(
            Assignment(shown, Number(int(label in self.source.predicates.get(signal, ()))))
            for signal, shown in self.signals.items()
        )

    # -- the transducers -----------------------------------------------------------------------------------

    def watcher(self, place: int) -> Automaton:
        """A transducer; behind each location one in which it passes the turn on."""
        transducer = self.source.transducers[place]
        last = place == len(self.source.transducers) - 1
        number = {location.name: index for index, location in enumerate(transducer.locations)}
        count = len(number)
        locations = [Location(at.name, self._guard(at.invariant)) for at in transducer.locations]
        edges: list[Edge] = []
        if not last:
            locations += [Location(f"{at.name}_", urgency=Urgency.COMMITTED) for at in locations]
            edges += [Edge(count + at, at, synchronisation=_turn("go", place + 1)) for at in range(count)]
        offset = 0 if last else count
        for edge in transducer.edges:
            edges.append(self._taken(edge, number[edge.source], offset + number[edge.target], "go", place))
        for kind, ends in (("end", transducer.endings), ("park", transducer.parkings if self.parks else ())):
            if kind == "park" and not self.parks:
                continue
            locations.append(Location(_TURNS[kind], urgency=Urgency.NORMAL if last else Urgency.COMMITTED))
            target = len(locations) - 1
            edges += [self._taken(edge, number[edge.source], target, kind, place) for edge in ends]
            if not last:
                locations.append(Location(f"{_TURNS[kind]}_"))
                edges.append(Edge(target, target + 1, synchronisation=_turn(kind, place + 1)))
        return Automaton(f"watch{place}", tuple(locations), tuple(edges))

    def _taken(self, edge: steps.Edge, source: int, target: int, kind: str, place: int) -> Edge:
        return Edge(
            source,
            target,
            guard=self._guard(edge.guard),
            resets=frozenset(self.clocks[clock] for clock in edge.resets),
            synchronisation=Synchronisation(f"{kind}[{place}]", sends=False),
            tests=(
                *(Test(Variable(self.signals[signal]), "==", Number(1)) for signal in sorted(edge.requires)),
                *(Test(Variable(self.signals[signal]), "==", Number(0)) for signal in sorted(edge.excludes)),
            ),
            assignments=tuple(
                Assignment(self.signals[signal], Number(1))
                for signal in sorted(edge.emits)
                if signal in self.signals
            ),
        )

    def _guard(self, guard: Guard) -> Guard:
        return tuple(
            Constraint(self.clocks.get(each.clock, each.clock), each.relation, each.bound) for each in guard
        )


def _turn(kind: str, place: int) -> Synchronisation:
    return Synchronisation(f"{kind}[{place}]", sends=True)
