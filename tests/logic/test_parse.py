"""The grammar: every spelling, every level of precedence, every bound, and texts of any size."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.errors import FormulaError
from mitlplan.logic.formula import (
    MOST_LEVELS,
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)
from mitlplan.logic.interval import Interval
from mitlplan.logic.parse import parse
from mitlplan.logic.show import show

A, B, C, D = Atom("A"), Atom("B"), Atom("C"), Atom("D")
UP_TO_TWO = Interval(Fraction(0), Fraction(2))


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("true", Constant(value=True)),
        ("false", Constant(value=False)),
        ("A", A),
        ("!A", Not(A)),
        ("~A", Not(A)),
        ("¬A", Not(A)),
        ("not A", Not(A)),
        ("A & B", And((A, B))),
        ("A && B", And((A, B))),
        ("A and B", And((A, B))),
        ("A ∧ B", And((A, B))),
        ("A | B", Or((A, B))),
        ("A || B", Or((A, B))),
        ("A or B", Or((A, B))),
        ("A ∨ B", Or((A, B))),
        ("A -> B", Implies(A, B)),
        ("A → B", Implies(A, B)),
        ("A <-> B", Iff(A, B)),
        ("A ↔ B", Iff(A, B)),
        ("F A", Eventually(A)),
        ("<> A", Eventually(A)),
        ("<>A", Eventually(A)),
        ("◇A", Eventually(A)),
        ("F[0,2] A", Eventually(A, UP_TO_TWO)),
        ("F[0,2]A", Eventually(A, UP_TO_TWO)),
        ("F_[0,2] A", Eventually(A, UP_TO_TWO)),
        ("F_ [0,2] A", Eventually(A, UP_TO_TWO)),
        ("<>[0,2] A", Eventually(A, UP_TO_TWO)),
        ("<>_[0,2] A", Eventually(A, UP_TO_TWO)),
        ("◇_[0,2] A", Eventually(A, UP_TO_TWO)),
        ("F(0,2) A", Eventually(A, Interval(Fraction(0), Fraction(2), lower_open=True, upper_open=True))),
        ("F_(0,2) A", Eventually(A, Interval(Fraction(0), Fraction(2), lower_open=True, upper_open=True))),
        ("G A", Always(A)),
        ("[] A", Always(A)),
        ("[]A", Always(A)),
        ("□A", Always(A)),
        ("G_[0,2] A", Always(A, UP_TO_TWO)),
        ("[][0,2] A", Always(A, UP_TO_TWO)),
        ("[]_[0,2] A", Always(A, UP_TO_TWO)),
        ("□[0,2] A", Always(A, UP_TO_TWO)),
        ("X A", Next(A)),
        ("○A", Next(A)),
        ("A U B", Until(A, B)),
        ("A U[0,2] B", Until(A, B, UP_TO_TWO)),
        ("A U_[0,2] B", Until(A, B, UP_TO_TWO)),
        ("A R B", Release(A, B)),
        ("A V B", Release(A, B)),
        ("A R[0,2] B", Release(A, B, UP_TO_TWO)),
        ("A V_[0,2] B", Release(A, B, UP_TO_TWO)),
        ("A W B", WeakUntil(A, B)),
        ("(A)", A),
        ("((A))", A),
        ("\tA\n&\r\nB ", And((A, B))),
    ],
)
def test_every_spelling(text: str, formula: Formula) -> None:
    assert parse(text) == formula


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("!A & B", And((Not(A), B))),
        ("!A U B", Until(Not(A), B)),
        ("F A U B", Until(Eventually(A), B)),
        ("G A -> B", Implies(Always(A), B)),
        ("X A & B", And((Next(A), B))),
        ("F X ! G A", Eventually(Next(Not(Always(A))))),
        ("A U B & C", And((Until(A, B), C))),
        ("A & B U C", And((A, Until(B, C)))),
        ("A & B | C & D", Or((And((A, B)), And((C, D))))),
        ("A | B -> C", Implies(Or((A, B)), C)),
        ("A -> B <-> C", Iff(Implies(A, B), C)),
        ("A U B U C", Until(A, Until(B, C))),
        ("A U B R C W D", Until(A, Release(B, WeakUntil(C, D)))),
        ("A W B U C", WeakUntil(A, Until(B, C))),
        ("A -> B -> C", Implies(A, Implies(B, C))),
        ("A <-> B <-> C", Iff(Iff(A, B), C)),
        ("A & B & C", And((A, B, C))),
        ("(A & B) & C", And((And((A, B)), C))),
        ("A & (B & C)", And((A, And((B, C))))),
        ("A | B | C", Or((A, B, C))),
        ("A | (B | C)", Or((A, Or((B, C))))),
        ("F[0,2] (A)", Eventually(A, UP_TO_TWO)),
        ("F (A) & B", And((Eventually(A), B))),
        ("(!A U B) & F A", And((Until(Not(A), B), Eventually(A)))),
    ],
)
def test_precedence(text: str, formula: Formula) -> None:
    assert parse(text) == formula


@pytest.mark.parametrize(
    "name",
    [
        *("a", "pos0", "dock.3", "wet_floor", "r7c12", "Ab", "Küche", "z_", "a."),
        *("F1", "F_", "F_x", "G.1", "UU", "Xa", "GF", "inf", "infinity"),
        *("nothing", "order", "android", "truer", "true.1"),
    ],
)
def test_names(name: str) -> None:
    assert parse(name) == Atom(name)
    assert parse(f"F {name}&{name}") == And((Eventually(Atom(name)), Atom(name)))


@pytest.mark.parametrize(
    ("subscript", "interval"),
    [
        ("[0,5]", Interval(Fraction(0), Fraction(5))),
        ("[2.5,7/2]", Interval(Fraction(5, 2), Fraction(7, 2))),
        ("[ 0.1 , 0.25 ]", Interval(Fraction(1, 10), Fraction(1, 4))),
        ("(1,2]", Interval(Fraction(1), Fraction(2), lower_open=True)),
        ("[1,2)", Interval(Fraction(1), Fraction(2), upper_open=True)),
        ("(1,2)", Interval(Fraction(1), Fraction(2), lower_open=True, upper_open=True)),
        ("[3,inf)", Interval(Fraction(3), None)),
        ("(3,inf)", Interval(Fraction(3), None, lower_open=True)),
        ("[0,inf)", Interval()),
        ("[007,8]", Interval(Fraction(7), Fraction(8))),
        ("[0,0]", Interval(Fraction(0), Fraction(0))),
        ("[0,123456789012345678]", Interval(Fraction(0), Fraction(123456789012345678))),
    ],
)
def test_bounds_are_exact(subscript: str, interval: Interval) -> None:
    assert parse(f"F{subscript} A") == Eventually(A, interval)
    assert parse(f"A U{subscript} B") == Until(A, B, interval)


@pytest.mark.parametrize(
    "text",
    [
        "F[2,2] A",
        "G[2,2] A",
        "A U[2,2] B",
        "A R[2,2] B",
        "X A",
        "X X X A",
        "!X X A",
        "F(A & F[2,2] A)",
        "F X A",
        "A U X B",
        "X A R B",
        "!G X A",
        "!(X A U B)",
        "!(A R X B)",
        "G A -> X B",
        "G X A -> B",
        "X A <-> X B",
        "G[2,2] F[1,1] A",
        "G F[0,0] A",
        "A U[0,0] B W C",
        "!G !G[1/2,1/2] A",
    ],
)
def test_an_exact_instant_may_be_asked_for_once(text: str) -> None:
    assert show(parse(text)) == text


@pytest.mark.parametrize(
    "text",
    [
        "G F[2,2] A",
        "G X A",
        "F G X A",
        "X A U B",
        "A R X B",
        "X A W B",
        "A W X B",
        "!F X A",
        "!(A U X B)",
        "!(X A R B)",
        "!(X A W B)",
        "F X A -> B",
        "F X A <-> B",
        "A <-> G X B",
        "G[0,2] X A",
        "F[0,1] X A U B",
        "G !G[1/2,1/2] A",
    ],
)
def test_an_exact_instant_may_not_be_asked_for_again_and_again(text: str) -> None:
    with pytest.raises(FormulaError, match="again and again"):
        parse(text)


@pytest.mark.parametrize(
    "opening", ["!", "F ", "G[0,1] ", "X ", "A & (", "A | (", "A U ", "A -> ", "A R[0,1] ", "A <-> ("]
)
def test_nesting_ends_with_a_sentence(opening: str) -> None:
    def nested(levels: int) -> str:
        text = opening * (levels - 1) + "A"
        return text + ")" * text.count("(")

    deepest = parse(nested(MOST_LEVELS))
    assert parse(show(deepest)) == deepest
    with pytest.raises(FormulaError, match="nested more than 100 levels deep"):
        parse(nested(MOST_LEVELS + 1))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("!" * 100_000, "but the text ends"),
        ("!" * 100_000 + "A", "nested more than 100 levels deep"),
        ("(" * 100_000, "but the text ends"),
        ("A" + ")" * 100_000, "found `\\)`"),
        ("F" * 100_000 + "[", "found `\\[`"),
        ("A->" * 50_000 + "A", "nested more than 100 levels deep"),
        ("F[" + "9" * 100_000 + ",2] A", "more than 18 digits"),
        ("F[1/" + "0" * 100_000 + ",2] A", "more than 18 digits"),
        ("x" * 300_000, "the most that are read is 200000"),
    ],
)
def test_no_text_is_too_much(text: str, problem: str) -> None:
    with pytest.raises(FormulaError, match=problem):
        parse(text)


def test_long_and_deeply_parenthesised_texts_are_read() -> None:
    assert parse("(" * 10_000 + "A" + ")" * 10_000) == A
    assert parse(" & ".join(["A"] * 10_000)) == And((A,) * 10_000)
    assert parse("b" * 100_000) == Atom("b" * 100_000)


def _read_or_refused(text: str) -> Formula | FormulaError:
    try:
        return parse(text)
    except FormulaError as error:
        return error


@given(st.text(alphabet="AB FGUX!&|-><()[],.012/_inftrue", max_size=30) | st.text(max_size=20))
def test_any_text_is_read_or_refused(text: str) -> None:
    match _read_or_refused(text):
        case FormulaError() as error:
            assert 0 <= error.position <= len(text)
            assert str(error).startswith(error.problem)
        case formula:
            assert parse(show(formula)) == formula
            assert show(parse(show(formula))) == show(formula)
