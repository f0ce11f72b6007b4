"""What a search of a network came to, as JSON and as text.

A trace alternates between states, in which time passes, and moves, which take none. Times are those of the
model, exact.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from mitlplan.automata.timed_automaton import Edge, Network, value_of
from mitlplan.automata.trace import Trace
from mitlplan.formats.uppaal import bounds, comparison, update
from mitlplan.search.fastest import Stopped
from mitlplan.search.reach import Effort, Reachable, Reached, Unknown, Unreachable

_UNKNOWN = (
    "every trace that was found needs times that stopped clocks do not allow; whether there is another is "
    "not known, because zones over-approximate where such clocks are read"
)


@dataclass(frozen=True, slots=True)
class Stop:
    """A state of a trace, how long it lasts, and the edges that end it, by automaton."""

    entered: Fraction
    delay: Fraction
    locations: dict[str, str]
    values: dict[str, int]
    edges: tuple[tuple[str, Edge], ...]


def stops(network: Network, trace: Trace) -> Iterator[Stop]:
    """The states of `trace` from the start to the end, where no edge follows."""
    at = [automaton.initial for automaton in network.automata]
    values = {variable.name: variable.initial for variable in network.variables}
    now = Fraction(0)
    for move, time in zip((*trace.moves, ()), (*trace.times, trace.end), strict=True):
        edges = tuple(
            (network.automata[place], network.automata[place].edges[index]) for place, index in move
        )
        yield Stop(
            now,
            time - now,
            {each.name: each.locations[here].name for each, here in zip(network.automata, at, strict=True)},
            dict(values),
            tuple((automaton.name, edge) for automaton, edge in edges),
        )
        now = time
        for (place, _), (_, edge) in zip(move, edges, strict=True):
            at[place] = edge.target
            for assignment in edge.assignments:
                values[assignment.variable] = value_of(assignment.value, values)


def reachable_to_json(network: Network, answer: Reachable, seconds: float) -> str:
    """The answer as a JSON document.

    Parameters
    ----------
    seconds
        How long it took.
    """
    document: dict[str, Any] = {
        "mitlplan": 1,
        "status": status(answer),
        "time": None,
        "attained": None,
        "bound": None,
        "trace": None,
        "reason": _reason(answer),
        "statistics": {**_statistics(answer), "seconds": round(seconds, 6)},
    }
    if isinstance(answer, Reached):
        document["time"] = str(answer.trace.least)
        document["attained"] = answer.trace.attained
        document["bound"] = str(answer.bound)
        document["trace"] = [_stop(network, stop) for stop in stops(network, answer.trace)]
    return json.dumps(document, indent=1) + "\n"


def status(answer: Reachable) -> str:
    """The answer in a word."""
    match answer:
        case Reached():
            return "reached"
        case Unreachable():
            return "unreachable"
        case Unknown():
            return "unknown"
        case Stopped():
            return "limit"


def _reason(answer: Reachable) -> str | None:
    match answer:
        case Stopped(reason):
            return reason
        case Unknown():
            return _UNKNOWN
        case _:
            return None


def _statistics(answer: Reachable) -> dict[str, int]:
    if isinstance(answer, Stopped):
        return {"stored": answer.states}
    effort: Effort = answer.effort
    return {"visited": effort.visited, "stored": effort.stored, "transitions": effort.transitions}


def _stop(network: Network, stop: Stop) -> dict[str, Any]:
    return {
        "locations": stop.locations,
        **({"values": stop.values} if stop.values else {}),
        "delay": str(stop.delay),
        "edges": [_edge(network, name, edge) for name, edge in stop.edges],
    }


def _edge(network: Network, name: str, edge: Edge) -> dict[str, Any]:
    locations = network.automata[network.automaton(name)].locations
    return {
        "automaton": name,
        "source": locations[edge.source].name,
        "target": locations[edge.target].name,
        "synchronisation": None if edge.synchronisation is None else str(edge.synchronisation),
        "guard": _guard(edge),
        "update": _update(edge),
    }


def _guard(edge: Edge) -> str:
    scale = 1
    return " && ".join([*bounds(edge.guard, scale), *map(comparison, edge.tests)])


def _update(edge: Edge) -> str:
    return ", ".join([*(f"{clock} = 0" for clock in sorted(edge.resets)), *map(update, edge.assignments)])


def reachable_to_text(network: Network, answer: Reachable) -> str:
    """The answer for people: a line for each move, with its time."""
    if not isinstance(answer, Reached):
        reason = _reason(answer)
        return f"{status(answer)}\n" if reason is None else f"{status(answer)}: {reason}\n"
    trace = answer.trace
    proved = "" if answer.bound >= trace.least else f" (none before {answer.bound} is all that is proved)"
    if trace.attained:
        lines = [f"reached at {trace.least}{proved}"]
    else:
        lines = [f"reached at any time after {trace.least}{proved}; this one at {trace.end}"]
    rows = [("0", _places(next(stops(network, trace))))]
    rows += [
        (str(stop.entered + stop.delay), "; ".join(_told(network, name, edge) for name, edge in stop.edges))
        for stop in stops(network, trace)
        if stop.edges
    ]
    rows.append((str(trace.end), "reached"))
    width = max(len(time) for time, _ in rows)
    return "\n".join([*lines, *(f"  {time:>{width}}  {text}" for time, text in rows)]) + "\n"


def _places(stop: Stop) -> str:
    return " ".join(f"{name}.{at}" for name, at in stop.locations.items())


def _told(network: Network, name: str, edge: Edge) -> str:
    locations = network.automata[network.automaton(name)].locations
    side = "" if edge.synchronisation is None else f" {edge.synchronisation}"
    details = "; ".join(part for part in (_guard(edge), _update(edge)) if part)
    shown = f" [{details}]" if details else ""
    return f"{name}: {locations[edge.source].name} -> {locations[edge.target].name}{side}{shown}"
