"""The published model: map times formula, generator apart, verification automaton (Figs. 7 to 9).

UNSOUND, kept for comparison. Three automata run side by side: ``sys`` is the map with everything that reads
its labels, ``sys0`` the generator of the timed eventualities (if there are any), ``sys1`` waits until every
checker has announced a verified falling edge. From every Buechi location a free edge leads to ``final``; the
query asks for all finals. The robot's moves carry the formula's moves; the formula never moves alone.
The published program leaves the start to be chosen by hand: here ``Gen0`` is one location for all generators,
as in the published models, and a checker begins as the formula asks of its guess at time 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from mitlplan.automata.chart import chart, labels
from mitlplan.automata.iota import Iota, IotaEdge, MapProduct, along_map
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
from mitlplan.automata.transducer import TIME, MapAutomaton
from mitlplan.errors import TranslationError
from mitlplan.logic.formula import Formula
from mitlplan.translation.seed.published import (
    PublishedAutomaton,
    clock_name,
    event_name,
    published_automaton,
)
from mitlplan.translation.seed.published_transducers import Flavour

FINAL = "final"
GUESS = "guess"
"""The variable that hands the first values of the guess from the checkers to the generator."""

MOST_CHECKERS = 6
"""The verification automaton has a location for each set of checkers."""


@dataclass(frozen=True, slots=True)
class PublishedModel:
    """A network ready to be searched, drawn or exported.

    Parameters
    ----------
    network
        ``sys``, and where there are timed eventualities ``sys0`` and ``sys1``; ``t`` is never reset.
    query
        Reach every ``final``.
    cells
        For each location of ``sys`` the cell it stands for, or ``None`` (``final``, a start).
    layers
        For each location of ``sys`` a number for what the formula does there, the same in every cell.
    counted
        Locations and transitions as the paper counts them: those of the product, and the generator with
        separate starts, of which only edges into locations where the formula is true are kept.
    """

    network: Network
    query: Query
    cells: tuple[int | None, ...]
    layers: tuple[int, ...]
    counted: tuple[int, int]


def published_model(
    formula: Formula,
    map_automaton: MapAutomaton,
    *,
    names: Sequence[str] | None = None,
    flavour: Flavour = Flavour.PAPER,
) -> PublishedModel:
    """The published model of `formula` for the robot of `map_automaton`.

    Parameters
    ----------
    names
        Of the cells; ``pos0``, ``pos1`` and so on if not given.

    Raises
    ------
    TranslationError
        If the paper has no transducer for an operator, or its program mixes what it cannot: a timed
        eventually beside untimed operators over atoms, or inside another one.
    """
    automaton = published_automaton(formula, flavour=flavour)
    _refuse_mixture(automaton)
    clock = clock_name(len(automaton.clocks))
    cell_names = names or [f"pos{cell}" for cell in range(map_automaton.location_count)]
    cells = chart(map_automaton, cell_names, clock=clock)
    walkers = automaton.checkers or (automaton.main,)
    product = along_map(cells, labels(map_automaton), *walkers)
    if automaton.checkers:
        return _timed_model(automaton, product, map_automaton.initial, clock)
    return _untimed_model(automaton.main, product, map_automaton.initial, clock)


def _refuse_mixture(automaton: PublishedAutomaton) -> None:
    nested = any(location.writes is None for location in automaton.main.locations) and automaton.main.inputs
    if len(automaton.checkers) > MOST_CHECKERS:
        raise TranslationError(f"the published construction is offered for {MOST_CHECKERS} timed operators")
    if nested or any(_has_generator(checker) for checker in automaton.checkers):
        raise TranslationError(
            "the published program cannot handle a timed operator inside another one or mixed with untimed "
            "ones over propositions; use --construction seed (repaired) or compact"
        )


def _has_generator(checker: Iota) -> bool:
    return any(location.stopped for location in checker.locations)


def _untimed_model(main: Iota, product: MapProduct, starts: tuple[int, ...], clock: str) -> PublishedModel:
    accepting = frozenset[int]().union(*main.buechi)
    marked = [part[1] in accepting for part in product.parts]
    beginnings = [
        index
        for index, part in enumerate(product.parts)
        if part[0] in starts and part[1] in main.initial and main.locations[part[1]].writes
    ]
    system = _Assembly("sys", product.locations, product.edges, marked)
    system.finish()
    system.begin([Edge(0, index) for index in beginnings])
    return PublishedModel(
        network=Network((system.automaton(),), clocks=(*main.clocks, clock, TIME)),
        query=Query((Target({"sys": FINAL}),), clock=TIME),
        cells=_cells(product, system),
        layers=_layers(product, system),
        counted=product.size,
    )


def _timed_model(
    automaton: PublishedAutomaton, product: MapProduct, starts: tuple[int, ...], clock: str
) -> PublishedModel:
    guesses = _first_guesses(automaton)
    distinct = sorted({guess for guess, _ in guesses}, reverse=True)
    channels = _channels(automaton)
    named = {event_name(k): channel for k, channel in enumerate(channels)}
    edges = [replace(edge, events=frozenset(named[event] for event in edge.events)) for edge in product.edges]
    system = _Assembly("sys", product.locations, edges, [False] * len(product.parts))
    system.begin(
        [
            Edge(0, index, assignments=_told(place, distinct))
            for place, guess in enumerate(distinct)
            for index, part in enumerate(product.parts)
            if part[0] in starts and _begins(automaton.checkers, part[1:], guess)
        ]
    )
    generator = _generator(automaton, guesses, distinct, len(product.parts))
    verifier = _verifier(channels)
    network = Network(
        automata=(system.automaton(), generator.automaton(), verifier),
        clocks=(*automaton.clocks, clock, TIME),
        channels=tuple(Channel(name, broadcast=True) for name in channels),
        variables=(BoundedInteger(GUESS, 0, len(distinct) - 1),) if len(distinct) > 1 else (),
    )
    finals = {each.name: FINAL for each in network.automata if any(at.name == FINAL for at in each.locations)}
    return PublishedModel(
        network=network,
        query=Query((Target(finals),), clock=TIME),
        cells=_cells(product, system),
        layers=_layers(product, system),
        counted=_counted(automaton.main, product),
    )


_Guess = tuple[bool, ...]


def _first_guesses(automaton: PublishedAutomaton) -> list[tuple[_Guess, IotaEdge]]:
    """How the merged ``Gen0`` may be left: the first value of every generator, with one edge for all.

    The edges lead to locations of `main` where the formula is true, from the first one's ``Gen0``.
    """
    main = automaton.main
    starts = [index for index, location in enumerate(main.locations) if location.writes is None]
    # A generator's edges out of Gen0 tell its phase: into the low one they reset the first of its clocks.
    phases: list[dict[int, tuple[bool, frozenset[str]]]] = []
    for begin in sorted(starts, key=lambda index: _earliest(main, index)):
        reached: dict[int, tuple[bool, frozenset[str]]] = {}
        low = _earliest(main, begin)
        for edge in main.edges:
            if edge.source == begin:
                reached[edge.target] = (low not in edge.resets, edge.resets)
        phases.append(reached)
    found = []
    for index, location in enumerate(main.locations):
        if location.writes and all(index in reached for reached in phases):
            guess = tuple(reached[index][0] for reached in phases)
            resets = frozenset[str]().union(*(reached[index][1] for reached in phases))
            found.append((guess, IotaEdge(starts[0], index, resets=resets)))
    return found


def _earliest(main: Iota, begin: int) -> str:
    """The clock x_1 of the generator that begins here."""
    return min(main.locations[begin].stopped, key=main.clocks.index)


def _begins(checkers: Sequence[Iota], part: Sequence[int], guess: _Guess) -> bool:
    """Whether every checker is in the start that belongs to the guess: CHK01 where it is true first."""
    return all(
        at in checker.initial and checker.locations[at].name.endswith("CHK01" if first else "CHK00")
        for checker, at, first in zip(checkers, part, guess, strict=True)
    )


def _told(place: int, distinct: Sequence[_Guess]) -> tuple[Assignment, ...]:
    return (Assignment(GUESS, Number(place)),) if len(distinct) > 1 else ()


def _asked(place: int, distinct: Sequence[_Guess]) -> tuple[Test, ...]:
    return (Test(Variable(GUESS), "==", Number(place)),) if len(distinct) > 1 else ()


def _generator(
    automaton: PublishedAutomaton,
    guesses: Iterable[tuple[_Guess, IotaEdge]],
    distinct: Sequence[_Guess],
    first_number: int,
) -> _Assembly:
    """``sys0``: the formula over its guesses, with one ``Gen0`` for all generators."""
    main = automaton.main
    kept = [index for index, location in enumerate(main.locations) if location.writes is not None]
    number = {index: place for place, index in enumerate(kept)}
    locations = [
        Location(location.name, location.invariant, location.stopped, location.running)
        for location in (main.locations[index] for index in kept)
    ]
    edges = [
        replace(edge, source=number[edge.source], target=number[edge.target])
        for edge in main.edges
        if edge.source in number and edge.target in number
    ]
    accepting = frozenset[int]().union(*main.buechi)
    assembly = _Assembly("sys0", locations, edges, [index in accepting for index in kept], first_number)
    stopped = frozenset[str]().union(*(at.stopped for at in main.locations if at.writes is None))
    gen0 = assembly.add(Location(f"loc{first_number + len(kept)}", stopped=stopped))
    for guess, edge in guesses:
        place = distinct.index(guess)
        tests = _asked(place, distinct)
        assembly.edges.append(Edge(gen0, number[edge.target], resets=edge.resets, tests=tests))
    assembly.initial = gen0
    if any(index in accepting for index in kept):
        assembly.finish()
    return assembly


def _channels(automaton: PublishedAutomaton) -> list[str]:
    """The channels of the checkers; a single one is called ``ch``, as in the paper."""
    count = len(automaton.checkers)
    return ["ch"] if count == 1 else [event_name(k) for k in range(count)]


def _verifier(channels: Sequence[str]) -> Automaton:
    """``sys1``: receives each checker's announcement once, in any order."""
    checkers = len(channels)
    sets = [frozenset(heard) for size in range(checkers + 1) for heard in combinations(range(checkers), size)]
    names = ["wait", *("heard" + "".join(f"_{k}" for k in sorted(heard)) for heard in sets[1:-1]), FINAL]
    edges = [
        Edge(source, sets.index(heard | {k}), synchronisation=Synchronisation(channels[k], sends=False))
        for source, heard in enumerate(sets)
        for k in range(checkers)
        if k not in heard
    ]
    return Automaton("sys1", tuple(Location(name) for name in names), tuple(edges))


class _Assembly:
    """A timed automaton in the making: locations named as in the paper, final, start, announcements."""

    def __init__(
        self,
        name: str,
        locations: Sequence[Location],
        edges: Iterable[IotaEdge],
        marked: Sequence[bool],
        first_number: int = 0,
    ) -> None:
        self.name = name
        self.marked = [index for index, accepting in enumerate(marked) if accepting]
        self.locations = [
            replace(location, name=f"loc{first_number + index}{'_b' if accepting else ''}")
            for index, (location, accepting) in enumerate(zip(locations, marked, strict=True))
        ]
        self.initial = 0
        self.edges: list[Edge] = []
        for edge in edges:
            self._announce(edge)

    def add(self, location: Location) -> int:
        """The index of a further location."""
        self.locations.append(location)
        return len(self.locations) - 1

    def _announce(self, edge: IotaEdge) -> None:
        """The edge with the events as broadcasts, one after the other if there are several at once."""
        plain = Edge(edge.source, edge.target, edge.guard, edge.resets)
        if not edge.events:
            self.edges.append(plain)
        source = edge.source
        for place, event in enumerate(sorted(edge.events), start=1):
            target = edge.target if place == len(edge.events) else self._stop()
            sent = Synchronisation(event, sends=True)
            if place == 1:
                self.edges.append(replace(plain, target=target, synchronisation=sent))
            else:
                self.edges.append(Edge(source, target, synchronisation=sent))
            source = target

    def _stop(self) -> int:
        return self.add(Location(f"{self.name}_{len(self.locations)}", urgency=Urgency.COMMITTED))

    def finish(self) -> None:
        """Free edges from the Buechi locations to ``final``."""
        final = self.add(Location(FINAL))
        self.edges.extend(Edge(index, final) for index in self.marked)

    def begin(self, edges: Sequence[Edge]) -> None:
        """Begin where one of `edges` leads (their sources are ignored); a choice is made at once."""
        if len(edges) == 1 and not edges[0].assignments:
            self.initial = edges[0].target
            return
        self.initial = self.add(Location("start", urgency=Urgency.COMMITTED))
        self.edges.extend(replace(edge, source=self.initial) for edge in edges)

    def automaton(self) -> Automaton:
        """The finished automaton."""
        return Automaton(self.name, tuple(self.locations), tuple(self.edges), self.initial)


def _cells(product: MapProduct, system: _Assembly) -> tuple[int | None, ...]:
    known = [part[0] for part in product.parts]
    return (*known, *(None for _ in range(len(system.locations) - len(known))))


def _layers(product: MapProduct, system: _Assembly) -> tuple[int, ...]:
    """What the formula does gets the first copy of the map on which its cells are still free."""
    cells: dict[tuple[int, ...], set[int]] = {}
    for part in product.parts:
        cells.setdefault(part[1:], set()).add(part[0])
    copies: list[set[int]] = []
    number: dict[tuple[int, ...], int] = {}
    for formula_part, wanted in cells.items():
        free = (index for index, taken in enumerate(copies) if not taken & wanted)
        number[formula_part] = index = next(free, len(copies))
        if index == len(copies):
            copies.append(set())
        copies[index] |= wanted
    known = [number[part[1:]] for part in product.parts]
    return (*known, *(len(copies) for _ in range(len(system.locations) - len(known))))


def _counted(main: Iota, product: MapProduct) -> tuple[int, int]:
    starts = {index for index, location in enumerate(main.locations) if location.writes is None}
    kept = sum(edge.source not in starts or bool(main.locations[edge.target].writes) for edge in main.edges)
    locations, edges = product.size
    return locations + len(main.locations), edges + kept
