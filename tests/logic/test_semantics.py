"""The judge against the definitions, tried region by region, and against what the design says by hand."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from time import perf_counter
from typing import Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.logic.signal_strategies import continuations, ending_signals, formulas, looping_signals
from tests.oracles.brute_truth import brute_truth

from mitlplan.logic import formula as f
from mitlplan.logic import semantics
from mitlplan.logic.interval import Interval
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies, truth
from mitlplan.logic.signal import Segment, Signal

untils: st.SearchStrategy[Literal["standard", "closed"]] = st.sampled_from(("standard", "closed"))
horizons: st.SearchStrategy[Literal["infinite", "finite"]] = st.sampled_from(("infinite", "finite"))


def many(cases: int) -> settings:
    """At least so many cases, and all that a profile for fuzzing asks for."""
    return settings(max_examples=max(cases, settings().max_examples))


@many(1500)
@given(formulas(), looping_signals(), untils)
def test_on_a_signal_that_repeats_the_judge_agrees_with_the_definitions(formula, signal, until) -> None:
    judged = truth(formula, signal, until=until)
    for instant, expected in brute_truth(formula, signal, until=until).items():
        assert (instant in judged) == expected, instant


@many(1500)
@given(formulas(), ending_signals(), untils, horizons)
def test_on_a_signal_that_ends_the_judge_agrees_with_kleenes_definitions(formula, signal, until, horizon) -> None:
    with pytest.MonkeyPatch.context() as patch:
        # Without what is known of every label: Kleene's logic does not know that `a | !a` holds.
        patch.setattr(semantics, "_MOST_ATOMS", -1)
        judged = truth(formula, signal, until=until, horizon=horizon)
    for instant, expected in brute_truth(formula, signal, until=until, horizon=horizon).items():
        assert (instant in judged) == expected, instant
