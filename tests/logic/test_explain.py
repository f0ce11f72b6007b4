"""What is said about a formula that does not hold, word for word."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mitlplan.logic import formula as f
from mitlplan.logic.explain import _first_within, explain
from mitlplan.logic.interval import Interval
from mitlplan.logic.interval_set import Axis, IntervalSet
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.show import show
from mitlplan.logic.signal import Signal
from tests.logic.signal_strategies import ending, ending_signals, formulas, looping, looping_signals


@pytest.mark.parametrize(
    ("text", "signal", "sentence"),
    [
        ("F A", ending("A 1"), "F A holds."),
        ("F A & F[0,2] B", ending("A 3"), "F[0,2] B does not hold at 0: B never holds in [0,2]."),
        (
            "G (A -> F[0,2] B)",
            looping("- 1, A 1, - 5, B 1"),
            (
                "G(A -> F[0,2] B) does not hold at 0: A holds at 1, but F[0,2] B does not hold at 1: "
                "B never holds in [1,3]."
            ),
        ),
        (
            "G (A -> F[0,2] B)",
            looping("- 1, A 1, B 1, - 2", 4),
            "G(A -> F[0,2] B) holds.",
        ),
        (
            "G F[0,2] A",
            looping("A 9, - 1, A 1, - 3", 9),
            "G F[0,2] A does not hold at 0: F[0,2] A does not hold at 11: A never holds in [11,13].",
        ),
        (
            "G[20,22] !A",
            looping("- 1, A 1, - 2", 1),
            "G[20,22] !A does not hold at 0: !A does not hold at 22.",
        ),
        (
            "!A U B",
            ending("- 1, A 1, B 0"),
            "!A U B does not hold at 0: B holds at 2 first, but !A does not hold at 1.",
        ),
        (
            "A U B",
            ending("A 1, - 0"),
            "A U B does not hold at 0: A does not hold at 1, and B has not held before.",
        ),
        ("A U B", ending("A 1"), "A U B is not decided at 0 by a signal that ends at 1."),
        ("A U[0,3] B", looping("A 5"), "A U[0,3] B does not hold at 0: B never holds in [0,3]."),
        ("G[0,3] A", ending("A 3, - 1"), "G[0,3] A does not hold at 0: A does not hold at 3."),
        ("G[0,3] A", ending("A 2"), "G[0,3] A is not decided at 0 by a signal that ends at 2."),
        ("F A", ending("- 2"), "F A is not decided at 0 by a signal that ends at 2."),
        (
            "G F[0,1) A",
            looping("- 1, A 1"),
            "G F[0,1) A does not hold at 0: F[0,1) A does not hold at 0: A never holds in [0,1).",
        ),
        (
            "G G[0,1) !A",
            ending("- 2, A 1"),
            "G G[0,1) !A does not hold at 0: G[0,1) !A does not hold just after 1.",
        ),
        ("A | B", ending("- 2"), "A | B does not hold at 0."),
    ],
)
def test_one_sentence(text: str, signal: Signal, sentence: str) -> None:
    assert explain(parse(text), signal) == sentence


def test_the_options_count() -> None:
    assert explain(parse("A U B"), ending("A 1, B 0"), until="closed") == (
        "A U B does not hold at 0: A does not hold at 1, and A & B has not held before."
    )
    assert explain(parse("G A"), ending("A 1"), horizon="finite") == "G A holds."
    assert explain(parse("G A & G B"), ending("AB 1, A 1"), horizon="finite") == (
        "G B does not hold at 0: B does not hold at 1."
    )


@given(formulas(), looping_signals() | ending_signals())
def test_says_that_a_formula_holds_exactly_if_it_does(formula: f.Formula, signal: Signal) -> None:
    sentence = explain(formula, signal)
    assert (sentence == f"{show(formula)} holds.") == satisfies(formula, signal)
    assert sentence.endswith(".")


AXIS = Axis(Fraction(1, 2), 3, 7)
"""Half seconds; from 3/2 on everything repeats every 2 seconds."""


@given(
    st.sets(st.sampled_from(range(2 * AXIS.end + 1))),
    st.fractions(0, 9, max_denominator=2),
    st.booleans(),
    st.none() | st.fractions(0, 5, max_denominator=2),
)
def test_the_first_piece_is_found_however_late_one_looks(
    ends: set[int], start: Fraction, start_open: bool, length: Fraction | None
) -> None:
    """Everything happens again within two seconds, so four seconds of quarters show it."""
    cuts = tuple(sorted(ends))[: len(ends) // 2 * 2]
    times = IntervalSet(AXIS, cuts)
    assume(length != 0 or not start_open)
    window = Interval(start, None if length is None else start + length, start_open)
    quarters = [start + Fraction(count, 4) for count in range(17 + 4 * AXIS.end)]
    seen = [instant for instant in quarters if instant in times and instant in window]
    found = _first_within(times, window)
    assert (found is None) == (not seen)
    if found is not None:
        assert seen[0] in found
        assert found.lower == seen[0] or (found.lower_open and found.lower == seen[0] - Fraction(1, 4))
