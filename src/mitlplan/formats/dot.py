"""Automata as graphs for Graphviz, with the marks of the paper's figures.

A location shows its name, input and output (``10 11 / 1``), invariant and rates; an edge its guard, resets
and communication (``z>0 | z:=0``). Buechi locations have a double border, the start an arrow from nowhere.
Where the places of the locations are given the drawing keeps them: so a product looks like the map.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import TypeAlias

from mitlplan.automata.iota import Iota, IotaLocation
from mitlplan.automata.timed_automaton import Automaton, Edge, Location, Urgency
from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.formats.layout import Point
from mitlplan.formats.uppaal import comparison, update

_STYLE = """\
  graph [fontname="Helvetica", bgcolor="white", splines=true, outputorder=edgesfirst];
  node [fontname="Helvetica", fontsize=10, shape=ellipse, style=filled, fillcolor="white"];
  node [margin="0.04,0.02"];
  edge [fontname="Helvetica", fontsize=8, arrowsize=0.6];
"""
_INCHES_AN_UNIT = 1 / 64
_LABEL_WIDTH = 30


@dataclass(frozen=True, slots=True)
class Tree:
    """A node of a tree and what hangs under it."""

    label: str
    children: tuple[Tree, ...] = ()


_Node: TypeAlias = tuple[str, bool, bool]
"""The text, whether the border is double, whether it is a start."""
_Line: TypeAlias = tuple[int, int, str]


def iota_dot(iota: Iota, name: str) -> str:
    r"""An input/output timed automaton.

    Examples
    --------
    >>> location = IotaLocation("T", frozenset({()}), True)
    >>> print([line for line in iota_dot(Iota((), (location,), (), frozenset({0})), "true").splitlines()
    ...     if "n0 [" in line][0].strip())
    n0 [label="T\n* / 1"];
    """
    accepting = frozenset[int]().union(*iota.buechi)
    count = len(iota.locations)
    nodes = [
        (_shown_iota(location), index in accepting, index in iota.initial and len(iota.initial) < count)
        for index, location in enumerate(iota.locations)
    ]
    lines = [
        (edge.source, edge.target, _joined(guard_text(edge.guard), edge.resets, sorted(edge.events)))
        for edge in iota.edges
    ]
    return _graph(name, nodes, lines, None)


def _shown_iota(location: IotaLocation) -> str:
    written = "*" if location.writes is None else str(int(location.writes))
    letters = sorted(location.reads, reverse=True)
    free = len(letters) == 2 ** len(letters[0])
    read = "*" if free else " ".join("".join(str(int(bit)) for bit in letter) for letter in letters)
    rates = [f"{clock}'=0" for clock in sorted(location.stopped)]
    rates += [f"{clock}'=1" for clock in sorted(location.running)]
    below = [text for text in (guard_text(location.invariant), ", ".join(rates)) if text]
    return "\n".join([location.name, f"{read} / {written}", *below])


def automaton_dot(
    automaton: Automaton, *, points: Sequence[Point] | None = None, marked: Iterable[int] = ()
) -> str:
    """A timed automaton of a network.

    Parameters
    ----------
    points
        Places of its locations, as in :mod:`mitlplan.formats.layout`.
    marked
        Its Buechi locations; those whose names end in ``_b``, as in the paper, are marked anyway.
    """
    doubled = set(marked)
    nodes = [
        (_shown(location), index in doubled or location.name.endswith("_b"), index == automaton.initial)
        for index, location in enumerate(automaton.locations)
    ]
    lines = [(edge.source, edge.target, _edge_text(edge)) for edge in automaton.edges]
    return _graph(automaton.name, nodes, lines, points)


def _shown(location: Location) -> str:
    rates = [f"{clock}'=0" for clock in sorted(location.stopped)]
    rates += [f"{clock}'=1" for clock in sorted(location.running - location.stopped)]
    urgency = "" if location.urgency is Urgency.NORMAL else f"({location.urgency.value})"
    parts = (location.name, guard_text(location.invariant), ", ".join(rates), urgency)
    return "\n".join(part for part in parts if part)


def _edge_text(edge: Edge) -> str:
    tests = [comparison(test) for test in edge.tests]
    guard = " ∧ ".join(part for part in (guard_text(edge.guard), *tests) if part)
    said = [str(edge.synchronisation)] if edge.synchronisation else []
    return _joined(guard, edge.resets, [*map(update, edge.assignments), *said])


def _joined(guard: str, resets: Iterable[str], more: Iterable[str]) -> str:
    """``guard | resets``, as the paper writes it."""
    done = ", ".join([*(f"{clock}:=0" for clock in sorted(resets)), *more])
    text = f"{guard or '*'} | {done or '*'}" if guard or done else ""
    return "\n".join(wrap(text, _LABEL_WIDTH))


def guard_text(guard: Guard) -> str:
    """A guard as it is written in the figures; two bounds that are one instant are one.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from mitlplan.automata.timed_automaton import exactly
    >>> guard_text(exactly("x", Fraction(2)))
    'x=2'
    """
    shown: list[str] = []
    bounds = list(dict.fromkeys(guard))
    for each in bounds:
        other = Constraint(each.clock, Relation.AT_MOST, each.bound)
        if each.relation is Relation.AT_LEAST and other in bounds:
            shown.append(f"{each.clock}={each.bound}")
        elif not (
            each.relation is Relation.AT_MOST
            and Constraint(each.clock, Relation.AT_LEAST, each.bound) in bounds
        ):
            shown.append(str(each))
    return " ∧ ".join(shown)


def tree_dot(tree: Tree, name: str) -> str:
    """A tree, such as that of a formula, the root on top.

    Examples
    --------
    >>> tree_dot(Tree("and", (Tree("A"), Tree("B"))), "phi").count(" -> ")
    2
    """
    labels: list[str] = []
    edges: list[tuple[int, int]] = []

    def visit(node: Tree) -> int:
        index = len(labels)
        labels.append(node.label)
        edges.extend((index, visit(child)) for child in node.children)
        return index

    visit(tree)
    lines = [f"  n{index} [label={_quoted(label)}, shape=box];" for index, label in enumerate(labels)]
    lines += [f"  n{source} -> n{target} [dir=none];" for source, target in edges]
    return f"digraph {_quoted(name)} {{\n{_STYLE}{chr(10).join(lines)}\n}}\n"


def _graph(name: str, nodes: Sequence[_Node], lines: Sequence[_Line], points: Sequence[Point] | None) -> str:
    body = "\n".join([*_nodes(nodes, points), *(_line(line) for line in lines)])
    direction = "" if points is not None else "  graph [rankdir=LR];\n"
    return f"digraph {_quoted(name)} {{\n{_STYLE}{direction}{body}\n}}\n"


def _nodes(nodes: Sequence[_Node], points: Sequence[Point] | None) -> Iterator[str]:
    for index, (text, double, start) in enumerate(nodes):
        attributes = [f"label={_quoted(text)}"]
        if double:
            attributes.append("peripheries=2")
        if points is not None:
            x, y = points[index]
            attributes.append(f'pos="{x * _INCHES_AN_UNIT:g},{-y * _INCHES_AN_UNIT:g}!"')
        if start and points is not None:
            attributes.append("penwidth=2.5")
        yield f"  n{index} [{', '.join(attributes)}];"
        if start and points is None:
            yield f'  s{index} [label="", shape=point, width=0.01, style=invis];\n  s{index} -> n{index};'


def _line(line: _Line) -> str:
    source, target, text = line
    return f"  n{source} -> n{target}{f' [label={_quoted(text)}]' if text else ''};"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
