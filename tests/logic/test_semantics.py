"""The judge against the definitions, tried region by region, and against what the design says by hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from fractions import Fraction
from itertools import product
from time import perf_counter
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.logic import formula as f
from mitlplan.logic import semantics
from mitlplan.logic.interval import Interval
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies, truth
from mitlplan.logic.signal import Segment, Signal
from tests.logic.signal_strategies import (
    continuations,
    ending,
    ending_signals,
    formulas,
    looping,
    looping_signals,
)
from tests.oracles.brute_truth import brute_truth
from tests.strategies import as_many

UntilKind = Literal["standard", "closed"]
Horizon = Literal["infinite", "finite"]

untils: st.SearchStrategy[UntilKind] = st.sampled_from(("standard", "closed"))
horizons: st.SearchStrategy[Horizon] = st.sampled_from(("infinite", "finite"))


# --- against the definitions


@as_many(15)
@given(formulas(), looping_signals(), untils)
def test_agrees_with_the_definitions_on_signals_that_repeat(
    formula: f.Formula, signal: Signal, until: UntilKind
) -> None:
    judged = truth(formula, signal, until=until)
    for instant, expected in brute_truth(formula, signal, until=until).items():
        assert (instant in judged) == expected, instant


@as_many(15)
@given(formulas(), ending_signals(), untils, horizons)
def test_agrees_with_kleenes_definitions_on_signals_that_end(
    formula: f.Formula, signal: Signal, until: UntilKind, horizon: Horizon
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        # Kleene's logic does not know that `a | !a` holds of every label.
        patch.setattr(semantics, "_MOST_ATOMS", -1)
        judged = truth(formula, signal, until=until, horizon=horizon)
    for instant, expected in brute_truth(formula, signal, until=until, horizon=horizon).items():
        assert (instant in judged) == expected, instant


@as_many(5)
@given(st.data(), formulas(), ending_signals(), untils)
def test_what_holds_on_a_signal_that_ends_holds_whatever_follows(
    data: st.DataObject, formula: f.Formula, signal: Signal, until: UntilKind
) -> None:
    judged = truth(formula, signal, until=until)
    for instant, sure in brute_truth(formula, signal, until=until).items():
        assert instant in judged or not sure, instant
    longer = data.draw(continuations(signal))
    known = [instant for instant in brute_truth(formula, signal) if instant in judged]
    later = truth(formula, longer, until=until)
    assert [instant for instant in known if instant not in later] == []


@given(formulas(), st.one_of(looping_signals(), ending_signals()), untils)
def test_a_finer_grid_changes_no_definition(formula: f.Formula, signal: Signal, until: UntilKind) -> None:
    coarse = brute_truth(formula, signal, until=until)
    fine = brute_truth(formula, signal, until=until, resolution=2)
    for instant, value in fine.items():
        if instant <= signal.end:
            whole = instant.numerator // instant.denominator
            assert value == coarse[instant if instant == whole else Fraction(2 * whole + 1, 2)], instant


@given(formulas(), looping_signals(), st.fractions(Fraction(1, 1000), 1000), st.fractions(0, 30))
def test_the_unit_of_time_does_not_matter(
    formula: f.Formula, signal: Signal, factor: Fraction, instant: Fraction
) -> None:
    slower = Signal(
        tuple(Segment(segment.start * factor, segment.holds) for segment in signal.segments),
        signal.end * factor,
        None if signal.repeat_from is None else signal.repeat_from * factor,
    )
    assert (instant in truth(formula, signal)) == (instant * factor in truth(scaled(formula, factor), slower))


def scaled(node: f.Formula, factor: Fraction) -> f.Formula:
    """The formula with all its times multiplied."""
    match node:
        case f.Constant() | f.Atom():
            return node
        case f.Next(operand):
            return f.Eventually(scaled(operand, factor), Interval(factor, factor))
        case f.And(operands) | f.Or(operands):
            return type(node)(tuple(scaled(operand, factor) for operand in operands))
        case _:
            changed = {field.name: stretched(getattr(node, field.name), factor) for field in fields(node)}
            # mypy knows no replace for a union of dataclasses.
            return replace(node, **changed)  # type: ignore[arg-type]


def stretched(value: Interval | f.Formula, factor: Fraction) -> Interval | f.Formula:
    if not isinstance(value, Interval):
        return scaled(value, factor)
    upper = None if value.upper is None else value.upper * factor
    return replace(value, lower=value.lower * factor, upper=upper)


# --- the design, by hand

# The ring of the paper's 2x2 map, from the start on: pos0, pos1 with B, pos2, pos3 with A.
RING = ({"s"}, {"B"}, set[str](), {"A"})


def walks(moves: int) -> Iterator[list[int]]:
    """All walks around the ring with so many moves, each of which takes 1."""
    for steps in product((1, -1), repeat=moves):
        yield [sum(steps[:count]) % 4 for count in range(moves + 1)]


def walked(walk: list[int], end: Fraction, repeat_from: int | None = None) -> Signal:
    starts = [Segment(Fraction(time), frozenset(RING[cell])) for time, cell in enumerate(walk)]
    return Signal(tuple(starts), end, None if repeat_from is None else Fraction(repeat_from))


def finite_plans(doubled: int) -> Iterator[Signal]:
    """The signals of all plans that end at ``doubled / 2``: on arrival or in the midst of a stay."""
    for walk in walks(doubled // 2):
        yield walked(walk, Fraction(doubled, 2))


def looping_plans(doubled: int) -> Iterator[Signal]:
    """The signals of all plans whose first loop ends at ``doubled / 2``."""
    for walk in walks(doubled // 2) if doubled % 2 == 0 and doubled > 0 else ():
        for repeat_from in range(len(walk) - 1):
            if walk[repeat_from] == walk[-1]:
                yield walked(walk[:-1], Fraction(doubled, 2), repeat_from)


@pytest.mark.parametrize(
    ("text", "makespan"),
    [
        ("(!A U B) & F A", 3),
        ("F[0,4] A & F[0,4] B", 3),
        ("F[2,4] A & F[0,2] B", 3),
        ("F[0,1] A & F[0,1] B", None),
        ("G[0,3] !A & F B", 3),
        ("F (A & F[2,2] A)", 3),
        ("!B U A", 1),
        ("s U A", 1),
    ],
)
def test_the_least_makespan_of_a_finite_plan(text: str, makespan: int | None) -> None:
    lengths = [
        length for length in range(11) if any(satisfies(parse(text), plan) for plan in finite_plans(length))
    ]
    assert (Fraction(lengths[0], 2) if lengths else None) == makespan


@pytest.mark.parametrize(
    ("text", "makespan"), [("G F[0,2] A", 2), ("G F[0,3] A & G F[0,3] B", 4), ("G !B & F A", 2)]
)
def test_the_least_makespan_of_a_looping_plan(text: str, makespan: int) -> None:
    lengths = [
        length for length in range(11) if any(satisfies(parse(text), plan) for plan in looping_plans(length))
    ]
    assert lengths[0] == 2 * makespan
    assert not any(satisfies(parse(text), plan) for length in range(11) for plan in finite_plans(length))


def test_the_closed_until_needs_an_overlap() -> None:
    plans = [plan for length in range(9) for plan in finite_plans(length)]
    assert not any(satisfies(parse("s U A"), plan, until="closed") for plan in plans)
    assert satisfies(parse("s U A"), ending("s 1, A 0"))
    assert satisfies(parse("s U A"), ending("s 1, As 0"), until="closed")
    assert not satisfies(parse("s R A"), ending("A 1, s 0"))
    assert satisfies(parse("s R A"), ending("A 1, s 0"), until="closed")
    assert satisfies(parse("s W A"), looping("s 1, A 1, - 1"))
    assert not satisfies(parse("s W A"), looping("s 1, A 1, - 1"), until="closed")


HOLDS, FAILS = True, False


@pytest.mark.parametrize(
    ("text", "signal", "expected"),
    [
        # Waiting, as in the table.
        ("F[2,4] A", ending("- 1, A 1"), HOLDS),
        ("F[2,4] A", ending("- 2, A 0"), HOLDS),
        ("F[2,4] A", ending("- 1, A 1/2"), FAILS),
        ("G !B & F A", looping("- 1, A 1", 1), HOLDS),
        # What is claimed at an instant counts at its very end.
        ("G[0,2] p", ending("p 2"), HOLDS),
        ("G[0,2] p", ending("p 199/100"), FAILS),
        ("G[0,2) p", ending("p 2, - 0"), HOLDS),
        ("F[0,3] A", ending("- 3, A 0"), HOLDS),
        ("F[0,3) A", ending("- 3, A 0"), FAILS),
        ("G[0,3] A", ending("A 3, - 1"), FAILS),
        ("F[2,4] A", looping("- 1, A 1, - 4"), FAILS),
        ("F[2,4] A", looping("- 1, A 101/100, - 4"), HOLDS),
        # The label entered at the end is known at that instant only.
        ("G[2,4] (F[1,3] A | C)", ending("- 4, A 0"), FAILS),
        ("G[2,4] (F[1,3] A | C)", ending("- 4, A 9/10"), FAILS),
        ("G[2,4] (F[1,3] A | C)", ending("- 4, A 1"), HOLDS),
        # Handing over at one instant.
        ("C U A", looping("C 1, A 1"), HOLDS),
        ("C U[1,3] A", looping("C 1, A 1"), HOLDS),
        ("G[0,1/2] (C U[1,3] A)", looping("C 1, A 1"), FAILS),
        ("G[0,1/2] (C U[1/2,3] A)", looping("C 1, A 1"), HOLDS),
        # A gap of exactly the bound.
        ("G F[0,2] p & F G[0,2) !p", looping("p 1, - 2"), HOLDS),
        ("F G[0,2] !p", looping("p 1, - 2"), FAILS),
        ("G F[0,2) p", looping("p 1, - 2"), FAILS),
        ("G F(0,2] p", looping("p 1, - 2"), HOLDS),
        # Far apart.
        ("F[100000,100001] p & G F[99999,100000] p", looping("p 1, - 1"), HOLDS),
        ("G F[99999,99999] p | G F[99999,99999] !p", looping("p 1, - 1"), FAILS),
    ],
)
def test_by_hand(text: str, signal: Signal, expected: bool) -> None:
    formula = f.And((f.Constant(value=True), parse_any(text)))
    assert satisfies(formula, signal) is expected


def parse_any(text: str) -> f.Formula:
    """The formula, also with ``G F[99999,99999]``, which the planner refuses and the judge does not."""
    if "G F[99999,99999]" not in text:
        return parse(text)
    formula = parse(text.replace("G F[99999,99999]", "F[99999,99999]"))
    assert isinstance(formula, f.Or)
    return f.Or(tuple(f.Always(operand) for operand in formula.operands))


@pytest.mark.parametrize(
    ("text", "signal", "expected"),
    [
        ("G p", ending("p 3"), HOLDS),
        ("G p", ending("p 3, - 0"), FAILS),
        ("!F p", ending("- 3"), HOLDS),
        ("!(true U p)", ending("- 3"), HOLDS),
        ("!(p U q)", ending("p 3"), HOLDS),
        ("p U q", ending("p 3"), FAILS),
        ("p W q", ending("p 3"), HOLDS),
        ("!(p W q)", ending("p 3"), FAILS),
        ("q R p", ending("p 3"), HOLDS),
        ("q R p", ending("p 3, - 0"), FAILS),
        ("G[0,5] p", ending("p 3"), FAILS),
        ("G[1,3] p", ending("p 3"), HOLDS),
        ("G[5,inf) p", ending("- 3"), HOLDS),
        ("F p | G !p", ending("- 3"), HOLDS),
        # Whatever holds for ever from some time on must hold at the end; a promise must be kept by then.
        ("F G p", ending("- 1, p 0"), HOLDS),
        ("F G p", ending("p 1, - 0"), FAILS),
        ("F[5,5] G p", ending("p 3"), FAILS),
        ("G F[0,2] p", ending("- 1, p 0"), HOLDS),
        ("G F[0,2] p", ending("p 1, - 0"), FAILS),
        ("G (q -> F[0,2] p)", ending("q 1, - 0"), FAILS),
        ("G (q -> F[0,2] p)", ending("q 1, p 0"), HOLDS),
    ],
)
def test_a_finite_horizon_by_hand(text: str, signal: Signal, expected: bool) -> None:
    assert satisfies(parse(text), signal, horizon="finite") is expected


@pytest.mark.parametrize(
    "text",
    [
        "F[2,2] (a | !a)",
        "F[2,2] (a -> a)",
        "F[2,2] (a <-> a)",
        "F[2,2] (!(a <-> !a) & (b | !b))",
        "F[2,2] !(a & b & (a -> !b))",
        "F[2,2] (a | (F b | (b -> !a)))",
        "F[2,2] !(a & (!a & G b))",
        "G (a & b | a & !b | !a)",
    ],
)
def test_what_is_true_of_every_label_is_known_after_the_end(text: str) -> None:
    assert satisfies(parse(text), ending("- 0"))
    assert not satisfies(f.Not(parse(text)), ending("- 0"))


def test_what_the_closed_operators_ask_of_every_label_is_known_after_the_end() -> None:
    for text in ("b R !b", "!(!b U b)", "F[2,2] ((a & b) R (!a | !b))"):
        assert satisfies(parse(text), ending("- 0"), until="closed")
        assert not satisfies(parse(text), ending("b 0"))


@pytest.mark.parametrize("text", ["F[2,2] (a | !b)", "F[2,2] (a | b)", "F[2,2] (a <-> b)", "F a | G !a"])
def test_what_depends_on_the_label_is_not_known_after_the_end(text: str) -> None:
    assert not satisfies(parse(text), ending("- 0"))
    assert not satisfies(f.Not(parse(text)), ending("- 0"))


def test_a_set_of_times_is_shown_in_words() -> None:
    signal = looping("- 1, a 1, - 2", 1)
    assert str(truth(parse("a"), signal)) == "[1,2), and again every 3 from 1 on"
    assert str(truth(parse("F a"), signal)) == "[0,inf)"
    assert str(truth(parse("F(0,1) a"), signal)) == "(0,2) (3,4), and again every 3 from 1 on"
    assert str(truth(parse("G[0,1) a & F[0,1] !a"), signal)) == "{1}, and again every 3 from 1 on"
    assert str(truth(parse("a & !a"), signal)) == "never"
    assert str(truth(parse("a"), ending("a 1, - 1"))) == "[0,1)"


# --- the rest


def test_options_that_do_not_exist_are_refused() -> None:
    signal = looping("a 1")
    with pytest.raises(ValueError, match=r"^the until is standard or closed, not 'strict'$"):
        satisfies(f.Atom("a"), signal, until="strict")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"^the horizon is infinite or finite, not '5'$"):
        satisfies(f.Atom("a"), signal, horizon="5")  # type: ignore[arg-type]
    problem = r"^a signal that repeats has no end to which a finite horizon could refer$"
    with pytest.raises(ValueError, match=problem):
        satisfies(f.Atom("a"), signal, horizon="finite")


def test_no_depth_of_nesting_overflows_the_stack() -> None:
    formula: f.Formula = f.Atom("a")
    for _ in range(3000):
        formula = f.Next(f.Not(formula))
    assert satisfies(formula, looping("a 1"))


def test_a_long_signal_is_judged_at_once() -> None:
    labels = ("a 1/3", "bc 2", "- 1/2", "ad 3", "c 1", "bd 5/7", "a 1")
    signal = looping(", ".join(labels[(index * index) % 7] for index in range(1000)), 500)
    formula = parse(
        "G F[0,300] a & G (a -> F[0,100] b) & (a U[2,5000] d) & G (b -> (a | c) U[0,40] d)"
        " & F G[1,7/3) !a & G (d R[3,30] (a | b)) & G F(5,100000] c"
    )
    began = perf_counter()
    truth(formula, signal)
    assert perf_counter() - began < 0.5
