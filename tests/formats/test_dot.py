"""Graphs for Graphviz have the marks of the paper's figures, and Graphviz draws them."""

from __future__ import annotations

import re
import sys
from fractions import Fraction

import pytest

from mitlplan import paper
from mitlplan.automata.timed_automaton import Automaton, Edge, Location, Synchronisation, Urgency, exactly
from mitlplan.automata.transducer import Constraint, Relation
from mitlplan.draw.automata import draw_graph
from mitlplan.errors import ToolError
from mitlplan.formats.dot import Tree, automaton_dot, guard_text, iota_dot, tree_dot
from mitlplan.translation.seed import exact_transducers as exact

FIGURES = paper.figures()


def labels(dot: str) -> list[str]:
    found = re.findall(r'^  n\d+ \[label="([^"]*)"', dot, re.MULTILINE)
    return [label.replace("\\n", "|") for label in found]


def test_a_transducer_shows_input_and_output() -> None:
    dot = iota_dot(exact.eventually_within(Fraction(2), "x"), "F[0,2] p")
    nodes = [line for line in dot.splitlines() if re.match(r"  n\d+ \[", line)]
    assert [re.findall(r'label="([^"]*)"', node)[0] for node in nodes] == [
        r"now\n1 / 1",
        r"soon\n0 / 1\nx<=2",
        r"far\n0 / 0",
        r"due\n0 / 1\nx<=2",
    ]
    assert r'n3 -> n0 [label="x=2 | *"]' in dot
    assert r'n0 -> n1 [label="* | x:=0"]' in dot
    assert r"n0 -> n2;" in dot
    starts = re.findall(r"s(\d) -> n", dot)
    assert starts == ["0", "1", "2"]


def test_buechi_locations_have_a_double_border() -> None:
    doubled = [line for line in iota_dot(exact.until(), "until").splitlines() if "peripheries=2" in line]
    assert len(doubled) == 3
    assert not any('"p!q\\n' in line for line in doubled)


def test_every_mark_of_a_timed_automaton() -> None:
    late = (Constraint("z", Relation.GREATER, Fraction(1, 2)), *exactly("y", Fraction(3)))
    automaton = Automaton(
        'a "map"',
        (
            Location("loc0_b", (Constraint("z", Relation.AT_MOST, Fraction(1)),), stopped=frozenset({"y"})),
            Location("loc1", running=frozenset({"z"}), urgency=Urgency.COMMITTED),
        ),
        (Edge(0, 1, late, frozenset({"z"}), Synchronisation("ch", sends=True)), Edge(1, 0)),
    )
    free = automaton_dot(automaton, marked=[1])
    assert free.startswith(r'digraph "a \"map\"" {')
    assert labels(free) == ["loc0_b|z<=1|y'=0", "loc1|z'=1|(committed)"]
    assert free.count("peripheries=2") == 2
    assert 'label="z>1/2 ∧ y=3 | z:=0, ch!"' in free
    assert "rankdir=LR" in free
    placed = automaton_dot(automaton, points=[(0, 0), (272, 64)])
    assert 'pos="4.25,-1!"' in placed
    assert "penwidth=2.5" in placed
    assert "rankdir" not in placed


def test_guards_as_the_paper_writes_them() -> None:
    assert guard_text(()) == ""
    assert guard_text((*exactly("x", Fraction(2)), *exactly("x", Fraction(2)))) == "x=2"
    between = (
        Constraint("x", Relation.AT_LEAST, Fraction(1)),
        Constraint("x", Relation.AT_MOST, Fraction(2)),
    )
    assert guard_text(between) == "x>=1 ∧ x<=2"


def test_a_tree_hangs_from_its_root() -> None:
    dot = tree_dot(Tree("&", (Tree("U", (Tree("A"), Tree("B"))), Tree("C"))), "phi")
    assert set(re.findall(r"n(\d) -> n(\d)", dot)) == {("0", "1"), ("1", "2"), ("1", "3"), ("0", "4")}


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_of_the_paper_is_drawn(name: str) -> None:
    pytest.importorskip("pygraphviz")
    drawn = draw_graph(FIGURES[name]).decode()
    assert drawn.count('class="node"') == len(labels(FIGURES[name]))
    assert drawn.count('class="edge"') == FIGURES[name].count(" -> ")


def test_the_figures_show_what_the_paper_has() -> None:
    assert labels(FIGURES["fig1"]) == [f"{cell}|z<=1" for cell in paper.CELLS]
    assert labels(FIGURES["fig2"]) == ["&", "U", "!", "A", "B", "U", "true", "A"]
    assert labels(FIGURES["fig5"])[4] == "Gen0|* / *|z[0]'=0, z[1]'=0, z[2]'=0, z[3]'=0"
    assert "CHK_3|0 / *|z[2]<=0 ∧ z[4]<2" in labels(FIGURES["fig6"])
    assert labels(FIGURES["fig7"])[-1] == "final"
    assert sum("peripheries=2" in line for line in FIGURES["fig7"].splitlines()) == 4
    assert FIGURES["fig8"].count("ch!") == 2


def test_without_graphviz_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygraphviz", None)
    with pytest.raises(ToolError, match=r"pip install 'mitlplan\[draw\]'"):
        draw_graph("digraph {}")


def test_a_graph_that_is_none_is_refused() -> None:
    pytest.importorskip("pygraphviz")
    with pytest.raises(ToolError, match="does not draw this graph"):
        draw_graph("digraph { a -> ")
