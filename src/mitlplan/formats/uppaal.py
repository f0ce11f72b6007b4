"""Networks of timed automata as UPPAAL models (XML, flat system 1.6).

Times are integers there: every constant is multiplied by the least factor that makes all of them whole, and a
comment says how long a time unit is. Names of the form ``z[3]`` become elements of an array. Everything has a
place in the editor's drawing (:mod:`mitlplan.formats.layout`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from xml.sax.saxutils import escape

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    BoundedInteger,
    Edge,
    Expression,
    Location,
    Network,
    Number,
    Query,
    Target,
    Test,
    Urgency,
    Variable,
    ticks_per_second,
)
from mitlplan.automata.transducer import Guard
from mitlplan.formats.identifiers import with_identifiers
from mitlplan.formats.layout import Layout, Point, nails, rows

_HEADER = """<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System 1.6//EN' \
'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd'>
"""
_ELEMENT = re.compile(r"(\w+)\[(\d+)\]", re.ASCII)

_KEYWORDS_TEXT = """
after_update and assign before_update bool branchpoint break broadcast case chan clock commit const continue
deadlock default do double else enum exists false for forall guard hybrid if imply import init int invariant
location meta not or priority process progress rate return scalar select state string struct sum switch sync
system trans true typedef urgent void while
"""
KEYWORDS = frozenset(_KEYWORDS_TEXT.split())
"""What UPPAAL does not accept as a name."""

LARGEST = 2**30
"""Constants beyond this are refused: UPPAAL's zones are made of 32-bit integers."""


def write_uppaal(
    network: Network, query: Query, *, layout: Layout | None = None, notes: Iterable[str] = ()
) -> str:
    r"""The XML text of a UPPAAL model.

    Parameters
    ----------
    network, query
        What is modelled, and what is asked: written as ``E<>``, and as ``inf{...}`` if a clock is given.
    layout
        Places of the locations, where there is something better than rows.
    notes
        Lines of comment for the declarations.

    Raises
    ------
    OverflowError
        If a constant is too large for UPPAAL once it is an integer.

    Examples
    --------
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1),))
    >>> text = write_uppaal(Network((walk,)), Query((Target({"robot": "there"}),)))
    >>> [line for line in text.splitlines() if "formula>" in line]
    ['\t\t\t<formula>E&lt;&gt; robot.there</formula>']
    """
    scale = ticks_per_second(network, query)
    placed = layout or {}
    places = [placed.get(each.name) or rows(len(each.locations)) for each in network.automata]
    network, query = with_identifiers(network, query, KEYWORDS)
    parts = [_HEADER, "<nta>\n", _element("declaration", _declarations(network, scale, notes), 1)]
    first = 0
    for automaton, own_places in zip(network.automata, places, strict=True):
        parts += _template(automaton, own_places, first, scale)
        first += len(automaton.locations)
    system = f"system {', '.join(automaton.name for automaton in network.automata)};"
    parts += [_element("system", system, 1), *_queries(query, scale), "</nta>\n"]
    return "".join(parts)


def _element(name: str, text: str, depth: int, attributes: str = "") -> str:
    return f"{chr(9) * depth}<{name}{attributes}>{escape(text)}</{name}>\n"


def _at(point: Point) -> str:
    return f' x="{point[0]}" y="{point[1]}"'


# -- declarations ---------------------------------------------------------------------------------------


def _declarations(network: Network, scale: int, notes: Iterable[str]) -> str:
    unit = "1 s" if scale == 1 else f"1/{scale} s"
    lines = [f"// A time unit is {unit}: every constant was multiplied by {scale}."]
    lines += [f"// {note}" for note in notes]
    if network.clocks:
        lines.append(f"clock {', '.join(_grouped(network.clocks))};")
    for broadcast in (False, True):
        names = [channel.name for channel in network.channels if channel.broadcast == broadcast]
        if names:
            lines.append(f"{'broadcast ' if broadcast else ''}chan {', '.join(_grouped(names))};")
    lines += _integers(network.variables)
    return "\n".join(lines) + "\n"


def _grouped(names: Sequence[str]) -> list[str]:
    """Names of elements as one declaration of their array, the others as they are."""
    arrays: dict[str, int] = {}
    for name in names:
        element = _ELEMENT.fullmatch(name)
        key, size = (element[1], int(element[2]) + 1) if element else (name, 0)
        arrays[key] = max(arrays.get(key, 0), size)
    return [f"{name}[{size}]" if size else name for name, size in arrays.items()]


def _integers(variables: Sequence[BoundedInteger]) -> list[str]:
    """One line for each range; the elements of an array share theirs."""
    lines = []
    ranges = dict.fromkeys((each.least, each.most) for each in variables)
    for least, most in ranges:
        same = [each for each in variables if (each.least, each.most) == (least, most)]
        plain = [each for each in same if each.initial == 0 and least <= 0 <= most]
        if plain:
            lines.append(f"int[{least},{most}] {', '.join(_grouped([each.name for each in plain]))};")
        lines += [f"int[{least},{most}] {each.name} = {each.initial};" for each in same if each not in plain]
    return lines


# -- templates ------------------------------------------------------------------------------------------


def _template(automaton: Automaton, places: Sequence[Point], first: int, scale: int) -> Iterable[str]:
    yield f'\t<template>\n\t\t<name x="5" y="5">{escape(automaton.name)}</name>\n'
    for index, (location, place) in enumerate(zip(automaton.locations, places, strict=True)):
        yield from _location(location, place, first + index, scale)
    yield f'\t\t<init ref="id{first + automaton.initial}"/>\n'
    for edge, through in zip(automaton.edges, nails(automaton, places), strict=True):
        yield from _transition(edge, places, through, first, scale)
    yield "\t</template>\n"


def _location(location: Location, place: Point, number: int, scale: int) -> Iterable[str]:
    x, y = place
    yield f'\t\t<location id="id{number}"{_at(place)}>\n'
    yield _element("name", location.name, 3, _at((x, y + 15)))
    if invariant := conditions(location, scale):
        yield _label("invariant", invariant, (x, y + 30))
    if location.urgency is Urgency.URGENT:
        yield "\t\t\t<urgent/>\n"
    if location.urgency is Urgency.COMMITTED:
        yield "\t\t\t<committed/>\n"
    yield "\t\t</location>\n"


def _transition(
    edge: Edge, places: Sequence[Point], through: Sequence[Point], first: int, scale: int
) -> Iterable[str]:
    yield "\t\t<transition>\n"
    yield f'\t\t\t<source ref="id{first + edge.source}"/>\n\t\t\t<target ref="id{first + edge.target}"/>\n'
    (x0, y0), (x1, y1) = places[edge.source], places[edge.target]
    x, y = through[0] if through else ((x0 + x1) // 2, (y0 + y1) // 2)
    resets = [f"{clock} = 0" for clock in sorted(edge.resets)]
    labels = (
        ("guard", " && ".join([*bounds(edge.guard, scale), *map(comparison, edge.tests)])),
        ("synchronisation", str(edge.synchronisation or "")),
        ("assignment", ", ".join([*resets, *map(update, edge.assignments)])),
    )
    for rank, (kind, text) in enumerate(labels):
        if text:
            yield _label(kind, text, (x, y + 15 * (rank - 1)))
    for nail in through:
        yield f"\t\t\t<nail{_at(nail)}/>\n"
    yield "\t\t</transition>\n"


def _label(kind: str, text: str, place: Point) -> str:
    return _element("label", text, 3, f' kind="{kind}"{_at(place)}')


# -- expressions ----------------------------------------------------------------------------------------


def bounds(guard: Guard, scale: int) -> list[str]:
    """The constraints as text, in time units.

    Raises
    ------
    OverflowError
        If a constant is too large.
    """
    return [f"{each.clock} {each.relation.value} {_ticks(each.bound, scale)}" for each in guard]


def conditions(location: Location, scale: int) -> str:
    """The invariant of a location as text, with the rates of its clocks."""
    rates = [f"{clock}' == 0" for clock in sorted(location.stopped)]
    rates += [f"{clock}' == 1" for clock in sorted(location.running - location.stopped)]
    return " && ".join([*bounds(location.invariant, scale), *rates])


def _ticks(seconds: Fraction, scale: int) -> int:
    ticks = int(seconds * scale)
    if ticks > LARGEST:
        raise OverflowError(
            f"{seconds} s are {ticks} time units of 1/{scale} s, more than UPPAAL's {LARGEST}; "
            "use coarser times"
        )
    return ticks


def comparison(test: Test) -> str:
    """A comparison of integers as text."""
    return f"{expression(test.left)} {test.comparison} {expression(test.right)}"


def update(assignment: Assignment) -> str:
    """An assignment as text."""
    return f"{assignment.variable} = {expression(assignment.value)}"


def expression(value: Expression) -> str:
    """An integer expression as text, with all parentheses."""
    match value:
        case Number(number):
            return str(number)
        case Variable(name):
            return name
        case Arithmetic(operator, left, right):
            return f"({expression(left)} {operator} {expression(right)})"


# -- queries --------------------------------------------------------------------------------------------


def _queries(query: Query, scale: int) -> Iterable[str]:
    wanted = targets(query, scale)
    yield "\t<queries>\n"
    yield from _query(f"E<> {wanted}", "Is there a plan? The fastest: verifyta -t 2.")
    if query.clock is not None:
        yield from _query(f"inf{{{wanted}}}: {query.clock}", "The least makespan.")
    yield "\t</queries>\n"


def _query(formula: str, comment: str) -> Iterable[str]:
    yield "\t\t<query>\n"
    yield _element("formula", formula, 3)
    yield _element("comment", comment, 3)
    yield "\t\t</query>\n"


def targets(query: Query, scale: int) -> str:
    """What is to be reached, as text."""
    texts = [_target(target, scale) for target in query.targets]
    return texts[0] if len(texts) == 1 else " || ".join(f"({text})" for text in texts)


def _target(target: Target, scale: int) -> str:
    parts = [f"{automaton}.{location}" for automaton, location in target.locations.items()]
    return " && ".join([*parts, *bounds(target.guard, scale), *map(comparison, target.tests)]) or "true"
