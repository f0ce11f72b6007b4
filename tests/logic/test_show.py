"""Formulas are written with as few parentheses as precedence allows, and read back as they were."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given

from mitlplan.logic.formula import And, Atom, Formula, Implies, Not, Or, Until
from mitlplan.logic.interval import Interval
from mitlplan.logic.parse import parse
from mitlplan.logic.show import show
from tests.strategies import formulas

A, B, C = Atom("A"), Atom("B"), Atom("C")


@pytest.mark.parametrize(
    "text",
    [
        "true",
        "!A",
        "!!A",
        "!(A & B)",
        "A & B & C",
        "(A & B) & C",
        "A & (B & C)",
        "A | B & C",
        "(A | B) & C",
        "A -> B -> C",
        "(A -> B) -> C",
        "A <-> B <-> C",
        "A <-> (B <-> C)",
        "A -> B <-> C | A",
        "A U B U C",
        "(A U B) U C",
        "A U[0,2] B R(1,3) C W A",
        "!A U F B",
        "F[0,2] A",
        "F[0,5/2] G A",
        "F(A & B)",
        "G[1/3,inf)(A -> F(0,2) B)",
        "X X A",
        "F A U B",
        "F(A U B)",
    ],
)
def test_what_is_written_canonically_is_kept(text: str) -> None:
    assert show(parse(text)) == text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("(!A U B) & F A", "!A U B & F A"),
        ("((A)) && ((B) or ~C)", "A & (B | !C)"),
        ("[]_[0,2](A→<>B)", "G[0,2](A -> F B)"),
        ("A V_[0.5,2.50] (B)", "A R[1/2,5/2] B"),
        ("A -> (B -> C)", "A -> B -> C"),
        ("F[0,inf) A", "F A"),
    ],
)
def test_spellings_become_one(text: str, shown: str) -> None:
    assert show(parse(text)) == shown


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        (And((And((A, B)), C)), "(A & B) & C"),
        (Or((A, And((B, C)))), "A | B & C"),
        (And((A, Or((B, C)))), "A & (B | C)"),
        (Implies(Implies(A, B), C), "(A -> B) -> C"),
        (Not(Until(A, B)), "!(A U B)"),
        (Until(Until(A, B), C, Interval(Fraction(1, 3), Fraction(2), lower_open=True)), "(A U B) U(1/3,2] C"),
    ],
)
def test_parentheses_follow_the_tree(formula: Formula, text: str) -> None:
    assert show(formula) == text


@given(formulas(atoms=("A", "B", "dock.3"), depth=4, punctual=True))
def test_reading_back_gives_the_same_formula(formula: Formula) -> None:
    assert parse(show(formula)) == formula
