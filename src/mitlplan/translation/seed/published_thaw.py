"""The published model without stopped clocks, with the same runs.

The generator stops clocks in its first location only, where they are all still 0. So as long as it is there,
what the checkers ask of these clocks is decided: the system gets a second copy of every location, for the
time before, in which they are not asked at all, and the generator's first move takes the system along to the
other copy and resets them. Other tools, and exact searches over zones, have no stopped clocks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from mitlplan.automata.timed_automaton import Automaton, Channel, Edge, Network, Synchronisation
from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.translation.seed.published_network import PublishedModel

THAW = "thaw"
"""The channel on which the generator says that its clocks run from now on."""


def without_stopped_clocks(model: PublishedModel) -> PublishedModel:
    """The same model with a copy of the system for the time before the generator has begun.

    Examples
    --------
    >>> from mitlplan import paper
    >>> thawed = without_stopped_clocks(paper.model("phi2"))
    >>> any(at.stopped for each in thawed.network.automata for at in each.locations)
    False
    """
    stopped = frozenset[str]().union(
        *(at.stopped for automaton in model.network.automata for at in automaton.locations)
    )
    if not stopped:
        return model
    system, generator, *others = model.network.automata
    count = len(system.locations)
    network = Network(
        automata=(_doubled(system, stopped), _beginning(generator, stopped), *others),
        clocks=model.network.clocks,
        channels=(*model.network.channels, Channel(THAW)),
        variables=model.network.variables,
    )
    most = max(model.layers) + 1
    return replace(
        model,
        network=network,
        cells=model.cells * 2,
        layers=(*model.layers, *(layer + most for layer in model.layers[:count])),
    )


def _doubled(system: Automaton, stopped: frozenset[str]) -> Automaton:
    """The system as it is, and behind it the copies for the time before."""
    count = len(system.locations)
    before = tuple(
        replace(at, name=f"{at.name}_before", invariant=_rest(at.invariant, stopped) or ())
        for at in system.locations
    )
    edges = [*system.edges, *_edges_before(system, stopped)]
    hears = Synchronisation(THAW, sends=False)
    edges += [Edge(count + index, index, synchronisation=hears) for index in range(count)]
    return Automaton(system.name, (*system.locations, *before), tuple(edges), count + system.initial)


def _edges_before(system: Automaton, stopped: frozenset[str]) -> Iterator[Edge]:
    count = len(system.locations)
    for edge in system.edges:
        guard = _rest(edge.guard, stopped)
        entered = _rest(system.locations[edge.target].invariant, stopped)
        if guard is not None and entered is not None:
            yield replace(edge, source=count + edge.source, target=count + edge.target, guard=guard)


def _rest(guard: Guard, stopped: frozenset[str]) -> Guard | None:
    """What is left of a guard if the stopped clocks are 0; ``None`` if it then fails."""
    if not all(_at_zero(each) for each in guard if each.clock in stopped):
        return None
    return tuple(each for each in guard if each.clock not in stopped)


def _at_zero(constraint: Constraint) -> bool:
    zero = Fraction(0)
    match constraint.relation:
        case Relation.LESS:
            return zero < constraint.bound
        case Relation.AT_MOST:
            return zero <= constraint.bound
        case Relation.AT_LEAST:
            return zero >= constraint.bound
        case Relation.GREATER:
            return zero > constraint.bound


def _beginning(generator: Automaton, stopped: frozenset[str]) -> Automaton:
    """The generator, whose first move resets all clocks and is heard by the system."""
    says = Synchronisation(THAW, sends=True)
    edges = tuple(
        replace(edge, resets=stopped, synchronisation=says) if edge.source == generator.initial else edge
        for edge in generator.edges
    )
    locations = tuple(replace(at, stopped=frozenset[str]()) for at in generator.locations)
    return replace(generator, edges=edges, locations=locations)
