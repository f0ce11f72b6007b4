"""Truth tables in one integer, against trying every label."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given

from mitlplan.logic.core import (
    Conjunction,
    Core,
    Disjunction,
    Literal,
    Truth,
    disjunction,
    eventually,
    negate,
    propositional,
)
from mitlplan.logic.labels import MOST_ATOMS, certain, possible
from tests.strategies import core_formulas

NAMES = ("A", "B", "C")


def _true_of(core: Core, label: dict[str, bool]) -> bool:
    match core:
        case Truth(value):
            return value
        case Literal(name, positive):
            return label[name] is positive
        case Conjunction(operands):
            return all(_true_of(operand, label) for operand in operands)
        case Disjunction(operands):
            return any(_true_of(operand, label) for operand in operands)
        case _:
            pytest.fail("no label decides a temporal operator")


@given(core_formulas(atoms=NAMES, depth=4).filter(propositional))
def test_the_table_agrees_with_every_label(core: Core) -> None:
    labels = [dict(zip(NAMES, row, strict=True)) for row in product((False, True), repeat=len(NAMES))]
    truths = [_true_of(core, label) for label in labels]
    assert possible(core) is any(truths)
    assert certain(core) is all(truths)


@given(core_formulas())
def test_a_formula_and_its_negation_leave_nothing_between_them(core: Core) -> None:
    assert certain(Disjunction((core, negate(core))))
    assert not possible(Conjunction((core, negate(core))))


def test_temporal_operators_are_true_or_false_as_they_like() -> None:
    soon = eventually(Literal("A"))
    assert possible(Conjunction((soon, Literal("A", positive=False))))
    assert not certain(Disjunction((soon, Literal("A", positive=False))))


def test_too_many_atoms_are_left_open() -> None:
    many = [Literal(f"cell{index}") for index in range(MOST_ATOMS + 1)]
    neither = Conjunction((disjunction(*many), *(negate(atom) for atom in many)))
    assert possible(neither)
    assert not certain(negate(neither))
    assert not possible(Conjunction((disjunction(*many[1:]), *(negate(atom) for atom in many[1:]))))
