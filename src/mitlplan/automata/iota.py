"""Input/output timed automata: Definition 4 of Zhou, Maity and Baras, and how they are composed.

An IOTA reads boolean signals and writes one. A location says which letters it may read (the input function)
and which value it writes (the output function), so a run turns input signals into an output signal: an IOTA
is a transducer over signals (Maler, Nickovic and Pnueli 2006, "From MITL to timed automata").
Invariants bound the time in a location, edges have guards and resets, a clock may be stopped in a location,
and every Buechi set must be visited infinitely often (the paper has one set; several are needed as soon as
two promises must be kept, see docs/paper.md). Two operations are the whole construction: `compose` feeds
the outputs of one or two IOTA to the inputs of another, and `along_map` runs them along a map, where the
label is the input and a move of the robot is one edge with all that it causes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from typing import TypeAlias

from mitlplan.automata.timed_automaton import Automaton, Location
from mitlplan.automata.transducer import Guard

Letter: TypeAlias = tuple[bool, ...]
"""A value for each input signal, in the order of ``Iota.inputs``."""


@dataclass(frozen=True, slots=True)
class IotaLocation:
    """A location with its values under the input and the output function.

    Parameters
    ----------
    reads
        The letters that may be read here.
    writes
        The value written, or ``None`` in a location that takes no part in the output: the checker of a
        timed eventually, and the start of its generator.
    invariant, stopped, running
        As in :class:`~mitlplan.automata.timed_automaton.Location`.
    """

    name: str
    reads: frozenset[Letter]
    writes: bool | None
    invariant: Guard = ()
    stopped: frozenset[str] = frozenset()
    running: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class IotaEdge:
    """A move between two locations, given by their indices; it may announce events (the paper's ``ch!``)."""

    source: int
    target: int
    guard: Guard = ()
    resets: frozenset[str] = frozenset()
    events: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Iota:
    """An input/output timed automaton.

    Parameters
    ----------
    inputs
        The names of the signals it reads; the input alphabet is the set of their valuations.
    clocks
        All start at 0.
    initial
        Where a run may begin.
    buechi
        Sets of locations; a run that goes on for ever visits each of them infinitely often.

    Raises
    ------
    ValueError
        If an index points nowhere, a letter has the wrong length, a location reads nothing, or an edge or an
        invariant mentions a clock that is not declared.

    Examples
    --------
    The transducer of "not" has two locations and moves with its input.

    >>> at = [IotaLocation("p", frozenset({(True,)}), False), IotaLocation("!p", frozenset({(False,)}), True)]
    >>> negation = Iota(("p",), tuple(at), (IotaEdge(0, 1), IotaEdge(1, 0)), frozenset({0, 1}))
    >>> negation.size
    (2, 2)
    """

    inputs: tuple[str, ...]
    locations: tuple[IotaLocation, ...]
    edges: tuple[IotaEdge, ...]
    initial: frozenset[int]
    clocks: tuple[str, ...] = ()
    buechi: tuple[frozenset[int], ...] = ()

    def __post_init__(self) -> None:
        known = range(len(self.locations))
        ends = chain.from_iterable((edge.source, edge.target) for edge in self.edges)
        if not all(index in known for index in chain(ends, self.initial, *self.buechi)):
            raise ValueError(f"an edge, a start or a Buechi set points outside the {len(known)} locations")
        for location in self.locations:
            if not location.reads:
                raise ValueError(f"{location.name} reads no letter")
            if any(len(letter) != len(self.inputs) for letter in location.reads):
                raise ValueError(f"{location.name} reads letters that do not fit the inputs {self.inputs}")
        if unknown := set(self._clocks_used()) - set(self.clocks):
            raise ValueError(f"the clocks {sorted(unknown)} are not declared")

    def _clocks_used(self) -> Iterator[str]:
        for location in self.locations:
            yield from (constraint.clock for constraint in location.invariant)
            yield from location.stopped | location.running
        for edge in self.edges:
            yield from (constraint.clock for constraint in edge.guard)
            yield from edge.resets

    @property
    def size(self) -> tuple[int, int]:
        """The numbers of locations and of edges."""
        return len(self.locations), len(self.edges)


Parts: TypeAlias = tuple[int, ...]
"""A location of a composition, by the locations of its parts: those of the parent and of each child."""

ABSENT = -1
"""In ``Parts``: this automaton takes no part in the location."""

BuechiSets: TypeAlias = tuple[frozenset[int], ...]
BuechiRule: TypeAlias = Callable[[Iota, Sequence[Iota], Sequence[Parts]], BuechiSets]
"""Makes the Buechi sets of a composition from those of parent and children."""


def every_set(parent: Iota, children: Sequence[Iota], parts: Sequence[Parts]) -> BuechiSets:
    """The generalised rule: every set of parent and children must be visited infinitely often.

    A location of a child that writes nothing is carried along beside the product (see :func:`compose`); it is
    in the product's sets if it is in the child's.
    """
    return tuple(
        frozenset(index for index, part in enumerate(parts) if part[place] in buechi)
        for place, automaton in enumerate((parent, *children))
        for buechi in automaton.buechi
    )


def compose(parent: Iota, *children: Iota, buechi: BuechiRule = every_set) -> Iota:
    """Feed the outputs of `children` to the inputs of `parent`, in order.

    A location of the composition is a location of the parent with one of each child, such that what the
    children write is a letter that the parent reads there, and the children agree on the signals they share.
    An edge moves some of them at once, each along an edge of its own, at least one. Locations of a child that
    write nothing (``writes is None``) cannot feed the parent: they are carried along unmultiplied, and an
    edge from there into the product leads to every location that the rest may be in.

    Parameters
    ----------
    parent
        With one input for each child.
    children
        One or two (any number works). Clocks of the same name are the same clock.
    buechi
        How acceptance is combined; the paper's own rule is in
        :mod:`mitlplan.translation.seed.published`.

    Raises
    ------
    ValueError
        If the parent's inputs are not as many as the children.

    Examples
    --------
    >>> at = [IotaLocation("p", frozenset({(True,)}), False), IotaLocation("!p", frozenset({(False,)}), True)]
    >>> negation = Iota(("p",), tuple(at), (IotaEdge(0, 1), IotaEdge(1, 0)), frozenset({0, 1}))
    >>> twice = compose(negation, negation)
    >>> [(location.name, location.writes) for location in twice.locations]
    [('!p x p', False), ('p x !p', True)]
    >>> twice.size
    (2, 2)
    """
    if len(parent.inputs) != len(children):
        raise ValueError(f"the parent reads {len(parent.inputs)} signals, not {len(children)}")
    inputs = tuple(dict.fromkeys(chain.from_iterable(child.inputs for child in children)))
    locations: list[IotaLocation] = []
    parts: list[Parts] = []
    for part, reads in _matching(parent, children, inputs):
        parts.append(part)
        locations.append(_joined(parent, children, part, reads))
    multiplied = len(parts)
    for place, child in enumerate(children, start=1):
        for index, location in enumerate(child.locations):
            if location.writes is None:
                parts.append(tuple(index if at == place else ABSENT for at in range(len(children) + 1)))
                locations.append(replace(location, reads=_widened(location.reads, child.inputs, inputs)))
    return Iota(
        inputs=inputs,
        locations=tuple(locations),
        edges=tuple(_composed_edges((parent, *children), parts, multiplied)),
        initial=_composed_initial((parent, *children), parts),
        clocks=tuple(dict.fromkeys(chain.from_iterable(each.clocks for each in (*children, parent)))),
        buechi=buechi(parent, children, parts),
    )


def _matching(
    parent: Iota, children: Sequence[Iota], inputs: tuple[str, ...]
) -> Iterator[tuple[Parts, frozenset[Letter]]]:
    writers: list[dict[bool | None, list[int]]] = []
    for child in children:
        writer: dict[bool | None, list[int]] = defaultdict(list)
        for at, writing in enumerate(child.locations):
            writer[writing.writes].append(at)
        writers.append(writer)
    for index, location in enumerate(parent.locations):
        for letter in sorted(location.reads, reverse=True):
            for chosen in product(*(writer[value] for writer, value in zip(writers, letter, strict=True))):
                located = zip(children, chosen, strict=True)
                reads = _agreed(((child.inputs, child.locations[at].reads) for child, at in located), inputs)
                if reads:
                    yield (index, *chosen), reads


def _agreed(
    readings: Iterable[tuple[tuple[str, ...], frozenset[Letter]]], inputs: tuple[str, ...]
) -> frozenset[Letter]:
    """The letters over `inputs` that every reading allows, by joining one reading after the other."""
    partial: list[dict[str, bool]] = [{}]
    for names, letters in readings:
        partial = [
            known | dict(zip(names, letter, strict=True))
            for known in partial
            for letter in letters
            if all(known.get(name, value) == value for name, value in zip(names, letter, strict=True))
        ]
    return frozenset(tuple(known[name] for name in inputs) for known in partial)


def _widened(reads: frozenset[Letter], names: tuple[str, ...], inputs: tuple[str, ...]) -> frozenset[Letter]:
    anything = [((name,), frozenset({(False,), (True,)})) for name in inputs if name not in names]
    return _agreed([(names, reads), *anything], inputs)


def _joined(parent: Iota, children: Sequence[Iota], part: Parts, reads: frozenset[Letter]) -> IotaLocation:
    own = parent.locations[part[0]]
    theirs = [child.locations[index] for child, index in zip(children, part[1:], strict=True)]
    names = [location.name for location in theirs]
    everyone = (*theirs, own)
    return IotaLocation(
        name=f"{names[0] if len(names) == 1 else '(' + ' , '.join(names) + ')'} x {own.name}",
        reads=reads,
        writes=own.writes,
        invariant=tuple(chain.from_iterable(location.invariant for location in everyone)),
        stopped=frozenset().union(*(location.stopped for location in everyone)),
        running=frozenset().union(*(location.running for location in everyone)),
    )


def _composed_edges(automata: Sequence[Iota], parts: Sequence[Parts], multiplied: int) -> Iterator[IotaEdge]:
    index_of = {part: index for index, part in enumerate(parts)}
    leaving = [_edges_by_source(automaton) for automaton in automata]
    for source, part in enumerate(parts[:multiplied]):
        choices = [(None, *edges[at]) for at, edges in zip(part, leaving, strict=True)]
        for moves in product(*choices):
            reached = tuple(at if move is None else move.target for at, move in zip(part, moves, strict=True))
            if any(moves) and (target := index_of.get(reached)) is not None:
                yield joint_edge(source, target, [move for move in moves if move is not None])
    for source in range(multiplied, len(parts)):
        place = next(place for place, at in enumerate(parts[source]) if at != ABSENT)
        for move in leaving[place][parts[source][place]]:
            for target, part in enumerate(parts):
                if part[place] == move.target:
                    yield joint_edge(source, target, [move])


def _edges_by_source(automaton: Iota) -> dict[int, list[IotaEdge]]:
    leaving: dict[int, list[IotaEdge]] = defaultdict(list)
    for edge in automaton.edges:
        leaving[edge.source].append(edge)
    return leaving


def joint_edge(source: int, target: int, moves: Sequence[IotaEdge]) -> IotaEdge:
    """One edge that does what all of `moves` do at once."""
    return IotaEdge(
        source=source,
        target=target,
        guard=tuple(dict.fromkeys(chain.from_iterable(move.guard for move in moves))),
        resets=frozenset().union(*(move.resets for move in moves)),
        events=frozenset().union(*(move.events for move in moves)),
    )


def _composed_initial(automata: Sequence[Iota], parts: Sequence[Parts]) -> frozenset[int]:
    return frozenset(
        index
        for index, part in enumerate(parts)
        if all(at in (ABSENT, *each.initial) for at, each in zip(part, automata, strict=True))
    )


@dataclass(frozen=True, slots=True)
class MapProduct:
    """A map with IOTA running along it.

    Parameters
    ----------
    locations
        Invariants of map and IOTA together.
    parts
        For each location the cell, and then the location of each IOTA.
    """

    locations: tuple[Location, ...]
    edges: tuple[IotaEdge, ...]
    parts: tuple[Parts, ...]

    @property
    def size(self) -> tuple[int, int]:
        """The numbers of locations and of edges."""
        return len(self.locations), len(self.edges)


def along_map(chart: Automaton, labels: Sequence[frozenset[str]], *automata: Iota) -> MapProduct:
    """Run IOTA along a map: the label of the robot's cell is what they all read.

    A location is a cell with a location of each IOTA that may read its label. Every move of the robot is one
    edge, and with it each IOTA stays or takes one edge of its own. They do not move while the robot stays.

    Parameters
    ----------
    chart
        The map: a location a cell.
    labels
        The propositions that hold in each cell.

    Examples
    --------
    >>> at = [IotaLocation("p", frozenset({(True,)}), True), IotaLocation("!p", frozenset({(False,)}), False)]
    >>> atom = Iota(("A",), tuple(at), (IotaEdge(0, 1), IotaEdge(1, 0)), frozenset({0, 1}))
    >>> from mitlplan.automata.timed_automaton import Edge
    >>> chart = Automaton("map", (Location("hall"), Location("dock")), (Edge(0, 1), Edge(1, 0)))
    >>> product = along_map(chart, [frozenset(), frozenset({"A"})], atom)
    >>> [location.name for location in product.locations], product.size
    (['dock x p', 'hall x !p'], (2, 2))
    """
    readers = [_cells_by_location(automaton, labels) for automaton in automata]
    parts: list[Parts] = [
        (cell, *chosen)
        for chosen in product(*(range(len(automaton.locations)) for automaton in automata))
        for cell in range(len(labels))
        if all(cell in cells[at] for cells, at in zip(readers, chosen, strict=True))
    ]
    return MapProduct(
        locations=tuple(_walked(chart, automata, part) for part in parts),
        edges=tuple(_map_edges(chart, automata, parts)),
        parts=tuple(parts),
    )


def _cells_by_location(automaton: Iota, labels: Sequence[frozenset[str]]) -> list[frozenset[int]]:
    letters = [tuple(name in label for name in automaton.inputs) for label in labels]
    return [
        frozenset(cell for cell, letter in enumerate(letters) if letter in location.reads)
        for location in automaton.locations
    ]


def _walked(chart: Automaton, automata: Sequence[Iota], part: Parts) -> Location:
    cell = chart.locations[part[0]]
    theirs = [automaton.locations[at] for automaton, at in zip(automata, part[1:], strict=True)]
    return Location(
        name=" x ".join([cell.name, *(location.name for location in theirs)]),
        invariant=tuple(chain(cell.invariant, *(location.invariant for location in theirs))),
        stopped=frozenset().union(*(location.stopped for location in theirs)),
        running=frozenset().union(*(location.running for location in theirs)),
    )


def _map_edges(chart: Automaton, automata: Sequence[Iota], parts: Sequence[Parts]) -> Iterator[IotaEdge]:
    index_of = {part: index for index, part in enumerate(parts)}
    leaving = [_edges_by_source(automaton) for automaton in automata]
    moves_from: dict[int, list[IotaEdge]] = defaultdict(list)
    for move in chart.edges:
        moves_from[move.source].append(IotaEdge(move.source, move.target, move.guard, move.resets))
    for source, part in enumerate(parts):
        choices = [(None, *edges[at]) for at, edges in zip(part[1:], leaving, strict=True)]
        for moves in product(moves_from[part[0]], *choices):
            reached = tuple(at if move is None else move.target for at, move in zip(part, moves, strict=True))
            if (target := index_of.get(reached)) is not None:
                yield joint_edge(source, target, [move for move in moves if move is not None])
