"""The identities of the design (docs: translation), each row held against the judge.

Some rows are valid on all signals: formulas stand for p, q and r, whose times may be isolated instants and
have ends of every kind. Some are valid on right-continuous signals only: there p, q and r are atoms. What is
not valid comes with a signal on which the two sides of the row differ.

A side that begins with ``closed:`` is read with the closed until. The strict until ``p & (p Us_I q)`` of the
design is written ``p U_(I without 0) q``, which means the same.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.logic import formula as f
from mitlplan.logic.interval_set import IntervalSet
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import truth
from mitlplan.logic.signal import Signal
from tests.logic.signal_strategies import looping, looping_signals

UntilKind = Literal["standard", "closed"]

VALID = [
    "p U[0,2] q = (p U q) & F[0,2] q",
    "closed: p U[0,2] q = closed: (p U q) & F[0,2] q",
    "closed: p U[0,2] q = p U[0,2] (p & q)",
    "closed: p U[1,3] q = p U[1,3] (p & q)",
    "p U[1,3] q = G[0,1) p & G[0,1] (p U q) & F[1,3] q",
    "closed: p U[1,3] q = closed: G[0,1] (p U q) & F[1,3] q",
    "p U[2,inf) q = G[0,2) p & G[0,2] (p U q)",
    "closed: p U[2,inf) q = closed: G[0,2] (p U q)",
    "p U(1,3] q = G[0,1] (p U(0,inf) q) & F(1,3] q",
    "p U[1,3] q = G[0,1) p & F[1,1] (p U[0,2] q)",
    "!(p U[1,3] q) = !p R[1,3] !q",
    "!(p U(1,3) q) = !p R(1,3) !q",
    "closed: !(p U[1,3] q) = closed: !p R[1,3] !q",
    "!F[1,3] p = G[1,3] !p",
    "!G[1,3) p = F[1,3) !p",
    "p R[1,3] q = F[0,1) p | F[0,1] (p R q) | G[1,3] q",
    "closed: p R[1,3] q = closed: F[0,1] (p R q) | G[1,3] q",
    "F[1,3) (p | q) = F[1,3) p | F[1,3) q",
    "G[1,3) (p & q) = G[1,3) p & G[1,3) q",
    "(p & q) U[1,3] r = (p U[1,3] r) & (q U[1,3] r)",
    "p U(1,3] (q | r) = p U(1,3] q | p U(1,3] r",
    "F[1,2] F[0,3] p = F[1,5] p",
    "G[1,2] G[0,3] p = G[1,5] p",
    "F(0,1) F[0,2] p = F(0,3) p",
    "p U[0,2] (p U[0,1] q) = p U[0,3] q",
    "p U[1,2] (p U[0,1] q) = p U[1,3] q",
    "F[0,3] p = F[0,1] p | F[1,3] p",
    "F[0,3] p = F[0,1) p | F[1,3] p",
    "G[0,3] p = G[0,1] p & G[1,3] p",
    "G[0,3] p = G[0,1) p & G[1,3] p",
    "p U[0,2] q = p U[0,1) q | p U[1,2] q",
    "F[1,3] p = F[1,1] F[0,2] p",
    "G[1,3] p = F[1,1] G[0,2] p",
    "F[1,1] p = G[1,1] p",
    "G F[1,3] p = G[1,inf) F[0,2] p",
    "p U q = q | p U(0,inf) q",
    "p U[0,2] q = q | p U(0,2] q",
    "p U[1,2] q = p & p U[1,2] q",
    "F[0,2] G[0,1] p -> G[0,1] F[0,2] p = true",
    "p U (p U q) = p U q",
    "(p U q) U q = p U q",
    "p U[0,0] q = q",
    "closed: p U[0,0] q = p & q",
    "F[0,0] p = p",
    "p & G (p -> G[0,1] p) -> G p = true",
    "p & G (p -> F[1,2] p) -> G F[0,2] p = true",
    "G[0,2] p & G[0,2] (p -> G[0,1] p) -> G[0,3] p = true",
    "F[0,2] p & G[0,2] q -> F[0,2] (p & q) = true",
    "F[1,2] p -> F(0,2] p = true",
    "G[0,2] p -> G(0,2) p = true",
    "p U[1,2] q -> p U(0,3) q = true",
    "(!p U q) & F[0,3] p -> F[0,3] q = true",
    "p W q = G p | (p U q)",
    "X p = F[1,1] p",
]

ONLY_ON_RIGHT_CONTINUOUS_SIGNALS = [
    # A signal of x and y, and formulas of these for p and q, on which the sides differ.
    ("closed: p R q = q W p", looping("- 1, x 1", 1), {"p": "F[0,1) x", "q": "!F[0,1) x"}),
    ("p R q = q W (p & q)", looping("x 1, y 1"), {"p": "F[0,1) y", "q": "G[0,1) x"}),
    (
        "p R[0,2] q = q U[0,2] (p & q) | G[0,2] q",
        looping("x 1, y 1"),
        {"p": "F[0,1) x", "q": "!F[0,1) x"},
    ),
    ("F[1,2] p = F(1,2] p", looping("y 1, x 1"), {"p": "G[0,1) x"}),
    ("G[1,2] p = G(1,2] p", looping("- 1, y 1"), {"p": "F[0,1) y"}),
    ("G F[0,2] p = G F(0,2] p", looping("x 1, - 2"), {"p": "F[0,1) G[0,1) x"}),
    ("F p = p | !p U p", looping("y 1, - 1"), {"p": "F[0,1) y"}),
    ("F[0,2] p = !p U[0,2] p", looping("- 1, x 1"), {"p": "F(0,1) x"}),
    ("F p & !p -> !p U p = true", looping("- 1, x 1", 1), {"p": "F(0,1) x"}),
    # An isolated instant, which a right-continuous signal does not have.
    ("F (p & G(0,1) !p) = false", looping("x 1, - 1"), {"p": "G[0,1) x & F[0,1] !x"}),
    ("G (p -> G(0,1] !p) & F p = false", looping("x 1, - 1", 1), {"p": "G[0,1) x & F[0,1] !x"}),
    ("F[2,4] p & G(2,4] !p = false", looping("x 1, - 2"), {"p": "!F[0,1) !x"}),
]

NOT_VALID = [
    # A signal of p and q on which the sides differ.
    ("p U[1,3] q = G[0,1] (p U q) & F[1,3] q", looping("q 1")),
    ("F[0,2] p = F[0,2) p", looping("p 1, - 2")),
    ("G[0,2] p = G[0,2) p", looping("p 2, - 1", 2)),
    ("F[1,3] p = !p U[1,3] p", looping("p 1")),
    ("G[0,1] F[0,2] p -> F[0,2] G[0,1] p = true", looping("p 1, - 1")),
    ("p & G (p -> F[1,2] p) -> G F[1,2] p = true", looping("p 1/2, - 3/2")),
]

# Formulas of a right-continuous signal whose times end in every way; they mean the same under both untils.
MEANINGS = [
    parse(text)
    for text in (
        "x",
        "y",
        "x & !y",
        "F[0,1) x",
        "G[0,1) x",
        "!F[0,1) x",
        "F[0,1) G[0,1) x",
        "F(0,1) y",
        "G[0,1) x & F[0,1] !x",
        "F[0,1] !y -> F[0,1) !y",
        "x & F[1,2) y",
        "G(0,1) (x | y)",
        "F(1,3) (x & y)",
        "true",
        "false",
    )
]


def refuted(rows: list[str], signal: Signal, meaning: dict[str, f.Formula]) -> list[str]:
    """The rows whose sides differ at some time."""
    return [row for row in rows if len(set(truths(row, signal, meaning))) > 1]


@cache
def sides(row: str) -> list[tuple[f.Formula, UntilKind]]:
    """The two formulas of a row, each with the until it is read with."""
    found: list[tuple[f.Formula, UntilKind]] = []
    for side in row.split(" = "):
        text = side.removeprefix("closed:")
        found.append((parse(text), "standard" if text == side else "closed"))
    return found


def replaced(node: f.Formula, meaning: dict[str, f.Formula]) -> f.Formula:
    """The formula with what `meaning` says in place of atoms."""
    match node:
        case f.Atom(name):
            return meaning.get(name, node)
        case f.And(operands) | f.Or(operands):
            return type(node)(tuple(replaced(operand, meaning) for operand in operands))
        case _:
            sides = {
                name: replaced(getattr(node, name), meaning)
                for name in ("operand", "left", "right")
                if hasattr(node, name)
            }
            # mypy knows no replace for a union of dataclasses.
            return replace(node, **sides)  # type: ignore[arg-type]


def truths(row: str, signal: Signal, meaning: dict[str, f.Formula]) -> list[IntervalSet]:
    """When each side of a row holds, on one axis."""
    (left, one), (right, other) = sides(row)
    left, right = replaced(left, meaning), replaced(right, meaning)
    # With the bounds of both sides in both formulas, the two sets have the same axis.
    neither = f.And((f.Constant(value=False), left, right))
    return [
        truth(f.Or((left, neither)), signal, until=one),
        truth(f.Or((right, neither)), signal, until=other),
    ]


@given(looping_signals(("x", "y")), st.tuples(*[st.sampled_from(MEANINGS)] * 3))
def test_valid_on_all_signals(signal: Signal, meaning: tuple[f.Formula, ...]) -> None:
    assert refuted(VALID, signal, dict(zip("pqr", meaning, strict=True))) == []


@given(looping_signals(("p", "q", "r")))
def test_valid_on_right_continuous_signals(signal: Signal) -> None:
    assert refuted([row for row, _, _ in ONLY_ON_RIGHT_CONTINUOUS_SIGNALS], signal, {}) == []


@pytest.mark.parametrize(("row", "signal", "meaning"), ONLY_ON_RIGHT_CONTINUOUS_SIGNALS)
def test_fails_where_instants_are_isolated(row: str, signal: Signal, meaning: dict[str, str]) -> None:
    left, right = truths(row, signal, {name: parse(text) for name, text in meaning.items()})
    assert left != right


@pytest.mark.parametrize(("row", "signal"), NOT_VALID)
def test_fails_on_a_right_continuous_signal(row: str, signal: Signal) -> None:
    left, right = truths(row, signal, {})
    assert left != right
