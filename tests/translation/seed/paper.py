"""The paper's maps and formulas, for the tests of its construction."""

from __future__ import annotations

from mitlplan.automata.transducer import MapAutomaton
from mitlplan.logic.formula import Formula
from mitlplan.logic.parse import parse
from mitlplan.workspace import Move, graph, grid
from mitlplan.workspace.abstract import abstract

PHI: dict[str, Formula] = {
    "phi1": parse("(!A U B) & F A"),
    "phi2": parse("G F[0,2] A"),
    "phi3": parse("F[0,4] A & F[0,4] B"),
    "phi4": parse("F[2,4] A & F[0,2] B"),
}


def ring() -> MapAutomaton:
    """The 2x2 map of the paper's Fig. 1, the robot in pos0."""
    cells = {"pos0": [], "pos1": ["B"], "pos2": [], "pos3": ["A"]}
    names = list(cells)
    moves = [Move(one, names[(index + 1) % 4], 1, both=True) for index, one in enumerate(names)]
    return abstract(graph(cells, moves), 0)


def square(size: int, *, a: tuple[int, int] | None = None, b: tuple[int, int] | None = None) -> MapAutomaton:
    """A grid with A bottom left and B top right, or A (and B) where asked; the robot top left."""
    regions = {"A": [a or (size - 1, 0)]}
    if b is not None or a is None:
        regions["B"] = [b or (0, size - 1)]
    return abstract(grid(size, size, regions=regions), 0)
