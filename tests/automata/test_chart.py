"""The map automaton as a plain timed automaton."""

from __future__ import annotations

from mitlplan.automata.chart import chart, labels
from mitlplan.workspace import Move, graph
from mitlplan.workspace.abstract import abstract
from tests.translation.seed.paper import ring

CELLS = {"a": [], "b": ["B"]}


def test_the_papers_map() -> None:
    plain = chart(ring(), ["pos0", "pos1", "pos2", "pos3"])
    assert [location.name for location in plain.locations] == ["pos0", "pos1", "pos2", "pos3"]
    assert {str(bound) for location in plain.locations for bound in location.invariant} == {"z<=1"}
    assert {tuple(map(str, edge.guard)) for edge in plain.edges} == {("z>=1",)}
    assert len(plain.edges) == 8
    assert all(edge.resets == {"z"} for edge in plain.edges)
    assert labels(ring()) == [frozenset(), frozenset({"B"}), frozenset(), frozenset({"A"})]


def test_a_range_of_times_and_waiting() -> None:
    moves = [Move("a", "b", ["1", "2"]), Move("a", "a", 3), Move("b", "a", 0)]
    hurried = chart(abstract(graph(CELLS, moves), 0), ["a", "b"], clock="r")
    assert [tuple(map(str, location.invariant)) for location in hurried.locations] == [("r<=3",), ()]
    guards = {(edge.source, edge.target): tuple(map(str, edge.guard)) for edge in hurried.edges}
    assert guards == {(0, 0): ("r>=3",), (0, 1): ("r>=1", "r<=2"), (1, 0): ("r>0",)}
    patient = chart(abstract(graph(CELLS, moves, waiting=True), 1), ["a", "b"])
    assert patient.initial == 1
    assert all(location.invariant == () for location in patient.locations)
    assert {tuple(map(str, edge.guard)) for edge in patient.edges} == {("z>=3",), ("z>=1",), ("z>0",)}
