"""Networks of timed automata as JSON: everything by name, times exact, as text."""

from __future__ import annotations

import json
from typing import Any

from mitlplan.automata.timed_automaton import Automaton, Edge, Location, Network, Query, Target
from mitlplan.automata.transducer import Guard
from mitlplan.formats.uppaal import comparison, update


def network_to_json(network: Network, query: Query) -> str:
    """The text of a JSON document with a network and its query.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Target
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1),))
    >>> text = network_to_json(Network((walk,)), Query((Target({"robot": "there"}),)))
    >>> json.loads(text)["targets"][0]["locations"]
    {'robot': 'there'}
    """
    document = {
        "mitlplan": 1,
        "clocks": list(network.clocks),
        "channels": [{"name": each.name, "broadcast": each.broadcast} for each in network.channels],
        "variables": [
            {"name": each.name, "least": each.least, "most": each.most, "initial": each.initial}
            for each in network.variables
        ],
        "automata": [_automaton(automaton) for automaton in network.automata],
        "targets": [_target(target) for target in query.targets],
    }
    return json.dumps(document, indent=1) + "\n"


def _automaton(automaton: Automaton) -> dict[str, Any]:
    return {
        "name": automaton.name,
        "initial": automaton.locations[automaton.initial].name,
        "locations": [_location(location) for location in automaton.locations],
        "edges": [_edge(automaton, edge) for edge in automaton.edges],
    }


def _location(location: Location) -> dict[str, Any]:
    return {
        "name": location.name,
        "urgency": location.urgency.value,
        "invariant": _guard(location.invariant),
        "stopped": sorted(location.stopped),
    }


def _edge(automaton: Automaton, edge: Edge) -> dict[str, Any]:
    return {
        "source": automaton.locations[edge.source].name,
        "target": automaton.locations[edge.target].name,
        "guard": _guard(edge.guard),
        "tests": [comparison(test) for test in edge.tests],
        "synchronisation": None if edge.synchronisation is None else str(edge.synchronisation),
        "resets": sorted(edge.resets),
        "assignments": [update(assignment) for assignment in edge.assignments],
    }


def _target(target: Target) -> dict[str, Any]:
    return {
        "locations": dict(target.locations),
        "guard": _guard(target.guard),
        "tests": [comparison(test) for test in target.tests],
    }


def _guard(guard: Guard) -> list[str]:
    return [f"{each.clock} {each.relation.value} {each.bound}" for each in guard]
