"""Names that other tools accept: letters, digits and underscores, no keywords, no two alike."""

from __future__ import annotations

from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from dataclasses import replace

from mitlplan.automata.timed_automaton import Automaton, Network, Query


def identifiers(names: Iterable[str], reserved: AbstractSet[str] = frozenset()) -> dict[str, str]:
    """For each name an identifier close to it.

    Examples
    --------
    >>> identifiers(["pos0", "dock-1", "dock.1", "and", "7th"], {"and"})
    {'pos0': 'pos0', 'dock-1': 'dock_1', 'dock.1': 'dock_1_2', 'and': 'and_2', '7th': 'l7th'}
    """
    taken = set(reserved)
    found: dict[str, str] = {}
    for name in names:
        plain = name.replace("[", "_").replace("]", "")
        base = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in plain)
        if not base[:1].isalpha():
            base = f"l{base}"
        candidate, number = base, 2
        while candidate in taken:
            candidate, number = f"{base}_{number}", number + 1
        taken.add(candidate)
        found[name] = candidate
    return found


def with_identifiers(network: Network, query: Query, reserved: AbstractSet[str]) -> tuple[Network, Query]:
    """The same network and query with identifiers for the names of automata and locations."""
    shared = [each.name for each in network.channels] + [each.name for each in network.variables]
    used = {*reserved, *network.clocks, *shared}
    automata = identifiers((each.name for each in network.automata), used)
    locations = {
        each.name: identifiers((location.name for location in each.locations), reserved)
        for each in network.automata
    }
    targets = tuple(
        replace(
            target,
            locations={automata[name]: locations[name][at] for name, at in target.locations.items()},
        )
        for target in query.targets
    )
    renamed = tuple(_renamed(each, automata[each.name], locations[each.name]) for each in network.automata)
    return replace(network, automata=renamed), replace(query, targets=targets)


def _renamed(automaton: Automaton, name: str, locations: dict[str, str]) -> Automaton:
    kept = tuple(replace(location, name=locations[location.name]) for location in automaton.locations)
    return replace(automaton, name=name, locations=kept)
