"""Tables of general networks: that each word of a test means what it says."""

from __future__ import annotations

import operator
from collections.abc import Callable
from itertools import product

import pytest

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Automaton,
    BoundedInteger,
    Edge,
    Location,
    Network,
    Number,
    Query,
    Target,
    Test,
    Variable,
)
from mitlplan.search.reach import Reached, reach


def passes(edge: Edge, variable: BoundedInteger) -> bool:
    """Whether an automaton with only this edge can take it."""
    walk = Automaton("walk", (Location("here"), Location("there")), (edge,))
    network = Network((walk,), variables=(variable,))
    return isinstance(reach(network, Query((Target({"walk": "there"}),))), Reached)


@pytest.mark.parametrize(
    ("sign", "compare"),
    [
        ("==", operator.eq),
        ("!=", operator.ne),
        ("<", operator.lt),
        ("<=", operator.le),
        (">", operator.gt),
        (">=", operator.ge),
    ],
)
def test_comparisons(sign: str, compare: Callable[[int, int], bool]) -> None:
    for left, right in product(range(-1, 2), repeat=2):
        edge = Edge(0, 1, tests=(Test(Variable("n"), sign, Number(right)),))
        assert passes(edge, BoundedInteger("n", -1, 1, left)) == compare(left, right), (left, right)


@pytest.mark.parametrize(("sign", "compute"), [("+", operator.add), ("-", operator.sub), ("*", operator.mul)])
def test_arithmetic(sign: str, compute: Callable[[int, int], int]) -> None:
    for left, right in product(range(-3, 4), repeat=2):
        value = Arithmetic(sign, Variable("n"), Number(right))
        for expected in (compute(left, right), compute(left, right) + 1):
            edge = Edge(0, 1, tests=(Test(value, "==", Number(expected)),))
            assert passes(edge, BoundedInteger("n", -3, 3, left)) == (expected == compute(left, right))
