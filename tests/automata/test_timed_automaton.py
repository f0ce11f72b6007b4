"""Networks are complete when they are made."""

from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Expression,
    Location,
    Network,
    Number,
    Synchronisation,
    Test,
    Variable,
    exactly,
    holds,
    ticks_per_second,
    value_of,
)
from mitlplan.automata.transducer import Constraint, Relation

A, B = Location("A"), Location("B")
BOUND = (Constraint("x", Relation.AT_MOST, Fraction(1)),)


def one(*edges: Edge, location: Location = A) -> Automaton:
    return Automaton("a", (location, B), edges)


def test_edges_join_locations_with_names_of_their_own() -> None:
    with pytest.raises(ValueError, match="points outside the 2 locations"):
        one(Edge(0, 2))
    with pytest.raises(ValueError, match="two locations have the same name"):
        one(location=B)
    with pytest.raises(KeyError):
        one().index("C")
    assert one().index("B") == 1


@pytest.mark.parametrize(
    ("automaton", "missing"),
    [
        (one(Edge(0, 1, BOUND)), "the clock x"),
        (one(Edge(0, 1, resets=frozenset({"x"}))), "the clock x"),
        (one(location=Location("A", BOUND)), "the clock x"),
        (one(location=Location("A", stopped=frozenset({"x"}))), "the clock x"),
        (one(Edge(0, 1, synchronisation=Synchronisation("c", sends=True))), "the channel c"),
        (one(Edge(0, 1, tests=(Test(Variable("n"), "<", Number(1)),))), "the variable n"),
        (one(Edge(0, 1, tests=(Test(Number(1), "<", Variable("n")),))), "the variable n"),
        (one(Edge(0, 1, assignments=(Assignment("n", Number(1)),))), "the variable n"),
    ],
)
def test_what_is_used_is_declared(automaton: Automaton, missing: str) -> None:
    with pytest.raises(ValueError, match=f"a uses {missing}, which is not declared"):
        Network((automaton,))
    declared = Network((automaton,), ("x",), (Channel("c"),), (BoundedInteger("n"),))
    assert declared.automaton("a") == 0
    with pytest.raises(KeyError):
        declared.automaton("b")


@pytest.mark.parametrize(
    "network",
    [
        {"automata": (one(), one())},
        {"automata": (one(),), "clocks": ("x", "x")},
        {"automata": (one(),), "channels": (Channel("c"), Channel("c", broadcast=True))},
        {"automata": (one(),), "variables": (BoundedInteger("n"), BoundedInteger("n", 0, 2))},
    ],
)
def test_names_are_declared_once(network: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="the network declares one"):
        Network(**network)  # type: ignore[arg-type]


def test_integers_begin_in_their_range() -> None:
    with pytest.raises(ValueError, match=r"n begins with 0, outside \[1,2\]"):
        BoundedInteger("n", 1, 2)


def test_operators_and_comparisons_are_those_there_are() -> None:
    with pytest.raises(ValueError, match="/ is no operator"):
        Arithmetic("/", Number(1), Number(2))
    with pytest.raises(ValueError, match="= is no comparison"):
        Test(Number(1), "=", Number(2))


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        (Arithmetic("+", Variable("n"), Number(2)), 5),
        (Arithmetic("-", Variable("n"), Number(2)), 1),
        (Arithmetic("*", Variable("n"), Arithmetic("-", Number(0), Number(2))), -6),
    ],
)
def test_values_of_expressions(expression: Expression, value: int) -> None:
    assert value_of(expression, {"n": 3}) == value


@pytest.mark.parametrize(
    ("comparison", "truths"),
    [
        ("==", (False, True, False)),
        ("!=", (True, False, True)),
        ("<", (True, False, False)),
        ("<=", (True, True, False)),
        (">", (False, False, True)),
        (">=", (False, True, True)),
    ],
)
def test_comparisons(comparison: str, truths: tuple[bool, ...]) -> None:
    found = tuple(holds(Test(Variable("n"), comparison, Number(2)), {"n": value}) for value in (1, 2, 3))
    assert found == truths


def test_the_factor_that_makes_every_constant_whole() -> None:
    guard = exactly("x", Fraction(5, 6))
    late = Location("A", (Constraint("x", Relation.AT_MOST, Fraction(1, 4)),))
    assert ticks_per_second(Network((one(Edge(0, 1, guard), location=late),), ("x",))) == 12
    assert ticks_per_second(Network((one(),))) == 1
    assert [str(each) for each in guard] == ["x>=5/6", "x<=5/6"]
    assert str(Synchronisation("c", sends=False)) == "c?"
