"""Definition 4 is kept by every value, and composition is what the definition says."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.automata.iota import Iota, IotaEdge, IotaLocation, Letter, along_map, compose
from mitlplan.automata.timed_automaton import Automaton, Edge, Location
from mitlplan.automata.transducer import Constraint, Relation
from mitlplan.translation.seed import exact_transducers as exact

TRUE, FALSE = frozenset({(True,)}), frozenset({(False,)})


def atom(name: str) -> Iota:
    locations = (IotaLocation(name, TRUE, True), IotaLocation(f"!{name}", FALSE, False))
    return Iota((name,), locations, (IotaEdge(0, 1), IotaEdge(1, 0)), frozenset({0, 1}))


def test_a_location_reads_letters_that_fit() -> None:
    with pytest.raises(ValueError, match="p reads no letter"):
        Iota(("p",), (IotaLocation("p", frozenset(), True),), (), frozenset())
    with pytest.raises(ValueError, match="p reads letters that do not fit"):
        Iota(("p", "q"), (IotaLocation("p", TRUE, True),), (), frozenset())


@pytest.mark.parametrize(
    "change",
    [
        {"edges": (IotaEdge(0, 2),)},
        {"initial": frozenset({-1})},
        {"buechi": (frozenset({2}),)},
    ],
)
def test_indices_point_into_the_locations(change: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="points outside the 2 locations"):
        replace(atom("p"), **change)  # type: ignore[arg-type]


def test_clocks_are_declared() -> None:
    guard = (Constraint("x", Relation.AT_MOST, Fraction(1)),)
    for change in (
        {"edges": (IotaEdge(0, 1, guard),)},
        {"edges": (IotaEdge(0, 1, resets=frozenset({"x"})),)},
        {"locations": (replace(atom("p").locations[0], stopped=frozenset({"x"})), atom("p").locations[1])},
    ):
        with pytest.raises(ValueError, match=r"the clocks \['x'\] are not declared"):
            replace(atom("p"), **change)  # type: ignore[arg-type]


def test_two_inputs_are_needed_for_two_children() -> None:
    with pytest.raises(ValueError, match="the parent reads 2 signals, not 1"):
        compose(exact.conjunction(), atom("p"))


def test_children_that_share_a_signal_agree_on_it() -> None:
    both = compose(exact.conjunction(), atom("p"), compose(exact.negation(), atom("p")))
    assert both.inputs == ("p",)
    assert {location.writes for location in both.locations} == {False}
    assert both.size == (2, 2)


def test_what_changes_at_once_changes_in_one_edge() -> None:
    both = compose(exact.conjunction(), atom("p"), atom("q"))
    assert both.size == (4, 12)
    reads: dict[Letter, bool | None] = {}
    for location in both.locations:
        for letter in location.reads:
            reads[letter] = location.writes
    assert reads == {letter: all(letter) for letter in reads}
    assert len(reads) == 4


def test_an_edge_of_the_composition_does_what_all_its_parts_do() -> None:
    first = (Constraint("x", Relation.AT_LEAST, Fraction(1)),)
    second = (Constraint("y", Relation.AT_MOST, Fraction(2)),)
    child = replace(
        atom("p"),
        edges=(IotaEdge(0, 1, first, frozenset({"x"}), frozenset({"heard"})),),
        clocks=("x",),
    )
    parent = replace(exact.negation(), edges=(IotaEdge(0, 1, second, frozenset({"y"})),), clocks=("y",))
    composed = compose(parent, child)
    (edge,) = composed.edges
    assert set(edge.guard) == {*first, *second}
    assert (edge.resets, edge.events) == ({"x", "y"}, {"heard"})
    assert composed.clocks == ("x", "y")


def test_every_buechi_set_is_kept() -> None:
    inner = compose(exact.until(), atom("p"), atom("q"))
    outer = compose(exact.until(), inner, atom("r"))
    assert len(inner.buechi) == 1
    assert len(outer.buechi) == 2
    assert len(set(outer.buechi)) == 2


def test_a_location_that_writes_nothing_is_carried_along() -> None:
    guess = Iota(
        (),
        (
            IotaLocation("start", frozenset({()}), None),
            IotaLocation("low", frozenset({()}), False),
            IotaLocation("high", frozenset({()}), True),
        ),
        (IotaEdge(0, 1), IotaEdge(0, 2), IotaEdge(1, 2), IotaEdge(2, 1)),
        frozenset({0}),
    )
    composed = compose(exact.conjunction(), guess, atom("p"))
    names = [location.name for location in composed.locations]
    assert names[-1] == "start"
    started = {edge.target for edge in composed.edges if edge.source == len(names) - 1}
    assert started == set(range(4))
    assert composed.initial == {len(names) - 1}
    assert composed.locations[-1].reads == {(True,), (False,)}


def test_along_a_map_the_robot_and_the_formula_move_at_once() -> None:
    guard = (Constraint("z", Relation.AT_LEAST, Fraction(1)),)
    chart = Automaton(
        "map",
        (Location("hall", (Constraint("z", Relation.AT_MOST, Fraction(1)),)), Location("dock")),
        (Edge(0, 1, guard, frozenset({"z"})), Edge(1, 0)),
    )
    waits = replace(exact.eventually_within(Fraction(2), "x"), inputs=("A",))
    product = along_map(chart, [frozenset(), frozenset({"A"})], waits)
    names = [location.name for location in product.locations]
    assert names == ["dock x now", "hall x soon", "hall x far", "hall x due"]
    assert {(names[edge.source], names[edge.target]) for edge in product.edges} == {
        ("dock x now", "hall x soon"),
        ("dock x now", "hall x far"),
        ("hall x soon", "dock x now"),
        ("hall x due", "dock x now"),
    }
    arriving = next(edge for edge in product.edges if names[edge.source] == "hall x soon")
    assert {str(each) for each in arriving.guard} == {"z>=1", "x<=2"}
    assert {str(each) for each in product.locations[1].invariant} == {"z<=1", "x<=2"}
    assert product.parts == ((1, 0), (0, 1), (0, 2), (0, 3))
