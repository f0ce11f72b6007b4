"""The map automaton as a plain timed automaton: the paper's Fig. 1, to be drawn, exported and composed."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from mitlplan.automata.timed_automaton import Automaton, Edge, Location
from mitlplan.automata.transducer import NEVER, Constraint, Guard, MapAutomaton, Relation


def chart(map_automaton: MapAutomaton, names: Sequence[str], *, clock: str = "z") -> Automaton:
    """A location a cell and an edge a move, with the time in a cell as `clock`, from the first start.

    Parameters
    ----------
    names
        Those of the cells.
    """
    durations = map_automaton.durations
    locations = tuple(
        Location(name, _at_most(clock, durations, int(bound)))
        for name, bound in zip(names, map_automaton.invariant, strict=True)
    )
    ends = zip(map_automaton.source, map_automaton.target, strict=True)
    stays = zip(map_automaton.least, map_automaton.most, strict=True)
    edges = []
    for (source, target), (least, most) in zip(ends, stays, strict=True):
        # What the invariant says already need not be said again.
        late = () if most == map_automaton.invariant[source] else _at_most(clock, durations, int(most))
        guard = (_at_least(clock, durations[int(least)]), *late)
        edges.append(Edge(int(source), int(target), guard=guard, resets=frozenset({clock})))
    return Automaton("map", locations, tuple(edges), map_automaton.initial[0])


def _at_least(clock: str, bound: Fraction) -> Constraint:
    """The least stay; a stay of 0 is none, so there it must be longer."""
    return Constraint(clock, Relation.AT_LEAST if bound > 0 else Relation.GREATER, bound)


def _at_most(clock: str, durations: Sequence[Fraction], index: int) -> Guard:
    return () if index == NEVER else (Constraint(clock, Relation.AT_MOST, durations[index]),)


def labels(map_automaton: MapAutomaton) -> list[frozenset[str]]:
    """The propositions of every cell."""
    return [map_automaton.label_sets[index] for index in map_automaton.label_of]
