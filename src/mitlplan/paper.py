"""The paper's map, formulas and figures, from the code's own automata.

Y. Zhou, D. Maity and J. S. Baras, "Timed automata approach for motion planning using metric interval temporal
logic" (European Control Conference 2016). What is drawn is what :mod:`mitlplan.translation.seed` builds.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import count

from mitlplan.automata.chart import chart
from mitlplan.automata.timed_automaton import Automaton
from mitlplan.automata.transducer import MapAutomaton
from mitlplan.formats.dot import Tree, automaton_dot, iota_dot, tree_dot
from mitlplan.formats.layout import cell_points, copies_of_map
from mitlplan.logic.formula import Atom, Constant, Formula
from mitlplan.logic.parse import parse
from mitlplan.logic.show import show
from mitlplan.translation.seed import published_transducers as elementary
from mitlplan.translation.seed.published import (
    Binary,
    Rewritten,
    RewrittenNot,
    TimedEventually,
    clock_name,
    rewrite,
)
from mitlplan.translation.seed.published_network import PublishedModel, published_model
from mitlplan.translation.seed.published_transducers import Flavour
from mitlplan.workspace import Move, Workspace, graph
from mitlplan.workspace.abstract import abstract

MISSIONS = {
    "phi1": "(!A U B) & F A",
    "phi2": "G F[0,2] A",
    "phi3": "F[0,4] A & F[0,4] B",
    "phi4": "F[2,4] A & F[0,2] B",
}
"""The formulas of the paper's Table I."""

CELLS = {"pos0": [], "pos1": ["B"], "pos2": [], "pos3": ["A"]}


def workspace() -> Workspace:
    """The 2x2 map of Fig. 1: every move takes 1 s, and the robot never waits."""
    names = list(CELLS)
    moves = [Move(one, names[(index + 1) % 4], 1, both=True) for index, one in enumerate(names)]
    return graph(CELLS, moves)


def robot() -> MapAutomaton:
    """The map automaton of Fig. 1, the robot in pos0."""
    return abstract(workspace(), 0)


def formula(name: str) -> Formula:
    """One of :data:`MISSIONS`."""
    return parse(MISSIONS[name])


def model(name: str, *, flavour: Flavour = Flavour.PAPER) -> PublishedModel:
    """The published model of one of :data:`MISSIONS` on the 2x2 map."""
    return published_model(formula(name), robot(), names=list(CELLS), flavour=flavour)


def figures() -> dict[str, str]:
    """The paper's figures as graphs, by name.

    Examples
    --------
    >>> sorted(figures())
    ['fig1', 'fig2', 'fig4', 'fig5', 'fig6', 'fig7', 'fig8', 'fig9']
    """
    clocks = (clock_name(number) for number in count())
    timed = elementary.timed_eventually(Fraction(0), Fraction(2), clocks)
    points = cell_points(workspace())
    patrol = model("phi2")
    return {
        "fig1": automaton_dot(chart(robot(), list(CELLS)), points=points),
        "fig2": tree_dot(_tree(rewrite(formula("phi1"))), show(formula("phi1"))),
        "fig4": iota_dot(elementary.until(iter(["z"])), "p U q"),
        "fig5": iota_dot(elementary.generator(timed, Flavour.PAPER), "generator of F[0,2] p"),
        "fig6": iota_dot(elementary.checker(timed, Flavour.PAPER, "ch!"), "checker of F[0,2] p"),
        "fig7": _product(model("phi1")),
        "fig8": _product(patrol),
        "fig9": "".join(_plain(automaton) for automaton in patrol.network.automata[1:2]),
    }


def _product(drawn: PublishedModel) -> str:
    places = copies_of_map(drawn.cells, drawn.layers, cell_points(workspace()))
    return automaton_dot(drawn.network.automata[0], points=places)


def _plain(automaton: Automaton) -> str:
    return automaton_dot(automaton)


def _tree(rewritten: Rewritten) -> Tree:
    """The logic tree: every node becomes a transducer."""
    match rewritten:
        case Constant(value):
            return Tree("true" if value else "false")
        case Atom(name):
            return Tree(name)
        case RewrittenNot(operand):
            return Tree("!", (_tree(operand),))
        case Binary(operator, left, right):
            return Tree(operator, (_tree(left), _tree(right)))
        case TimedEventually(operand, least, most):
            return Tree(f"F[{least},{most}]", (_tree(operand),))
