from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from mitlplan.trajectory.timetable import TICK, Apart, Span, Window, cheapest_times

Case = tuple[list[Span], list[Window], list[Apart]]
times = st.fractions(min_value=0, max_value=4, max_denominator=4)


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """Spans and windows around some timetable that keeps them all."""
    spans, moments = [], [Fraction(0)]
    for _ in range(draw(st.integers(1, 7))):
        duration = draw(times.filter(bool))
        least = duration - min(duration, draw(times))
        most = draw(st.one_of(st.none(), times.map(lambda more, duration=duration: duration + more)))
        spans.append(Span(draw(st.sampled_from([0.25, 1.0, 3.0771, 12.057])), least, most))
        moments.append(moments[-1] + duration)
    windows = [(moments[0], moments[0])]
    windows += [(moment - min(moment, draw(times)), moment + draw(times)) for moment in moments[1:]]
    apart = []
    for _ in range(draw(st.integers(0, 4))):
        earlier, later = draw(st.permutations(range(len(moments))))[:2]
        # Some are kept with equality, so that crossings may be left no choice but to move together.
        apart.append(Apart(earlier, later, moments[later] - moments[earlier] - draw(times)))
    return spans, windows, apart


def times_of(spans: list[Span], windows: list[Window], apart: list[Apart] | None = None) -> list[Fraction]:
    found = cheapest_times(spans, windows, apart or [])
    assert found is not None
    return found


def total(spans: list[Span], found: list[Fraction]) -> float:
    return sum(span.cost / float(b - a) for span, (a, b) in zip(spans, pairwise(found), strict=True))


@given(cases())
def test_every_bound_is_kept_exactly(case: Case) -> None:
    spans, windows, apart = case
    found = times_of(spans, windows, apart)
    assert all(found[one.later] - found[one.earlier] >= one.least for one in apart)
    assert all(low <= time <= high for time, (low, high) in zip(found, windows, strict=True))
    for span, (begin, end) in zip(spans, pairwise(found), strict=True):
        assert span.least <= end - begin
        assert span.most is None or end - begin <= span.most


@given(cases())
@settings(max_examples=40)
def test_it_is_as_good_as_a_general_solver(case: Case) -> None:
    spans, windows, apart = case
    costs = np.array([span.cost for span in spans])
    least = np.array([float(span.least) for span in spans])
    most = np.array([np.inf if span.most is None else float(span.most) for span in spans])
    first = np.array([float(low) for low, _ in windows])
    earlier, later = ([getattr(one, name) for one in apart] for name in ("earlier", "later"))
    asked = np.array([float(one.least) for one in apart])
    found = minimize(
        lambda t: float((costs / np.maximum(np.diff(t), 1e-3)).sum()),
        first,
        method="SLSQP",
        bounds=[(float(low), float(high)) for low, high in windows],
        constraints=[
            {"type": "ineq", "fun": lambda t: np.diff(t) - least},
            {"type": "ineq", "fun": lambda t: np.minimum(most, 1e6) - np.diff(t)},
            {"type": "ineq", "fun": lambda t: t[later] - t[earlier] - asked},
        ],
        options={"ftol": 1e-12, "maxiter": 500},
    )
    ours = total(spans, times_of(spans, windows, apart))
    # The solver may stop early or stray from its bounds a little: it is never better than that.
    if found.success:
        assert ours <= float(found.fun) * (1 + 1e-5) + 1e-6


def test_durations_are_in_proportion_to_the_roots_of_the_costs() -> None:
    costs = [1.0, 9.0, 4.0, 0.25]
    end = Fraction(13)
    windows = [(Fraction(0), Fraction(0)), *[(Fraction(0), end)] * 3, (end, end)]
    found = times_of([Span(cost, Fraction(0)) for cost in costs], windows)
    assert [float(b - a) for a, b in pairwise(found)] == pytest.approx([2.0, 6.0, 4.0, 1.0], abs=1e-4)
    assert total([Span(cost, Fraction(0)) for cost in costs], found) == pytest.approx(6.5**2 / 13, rel=1e-9)


def test_no_choice_is_left() -> None:
    second = Fraction(1)
    rigid = [Span(1.0, second, second)] * 3
    fixed = [(Fraction(place), Fraction(place)) for place in range(4)]
    assert cheapest_times(rigid, fixed) == [low for low, _ in fixed]
    wide = [(Fraction(0), Fraction(0)), *[(Fraction(0), Fraction(9))] * 3]
    assert cheapest_times(rigid, wide) == [low for low, _ in fixed]


def test_a_long_chain() -> None:
    count = 1000
    random = np.random.default_rng(0)
    spans = [Span(float(cost), Fraction(1)) for cost in random.choice([1.0, 3.0771, 12.0568], count)]
    latest = [
        (Fraction(place), Fraction(place + int(random.integers(0, 2000)))) for place in range(count + 1)
    ]
    windows = [(Fraction(0), Fraction(0)), *latest[1:]]
    found = times_of(spans, windows)
    assert total(spans, found) < total(spans, [Fraction(place) for place in range(count + 1)])


@given(cases(), st.integers(0, 7), st.integers(0, 7), times)
def test_no_times_are_found_exactly_if_there_are_none(
    case: Case, one: int, other: int, far: Fraction
) -> None:
    """Two crossings asked to be farther apart than the longest way between them allows."""
    spans, windows, apart = case
    earlier, later = sorted((one % len(windows), other % len(windows)))
    longest = sum((span.most or Fraction(99) for span in spans[earlier:later]), Fraction(0))
    found = cheapest_times(spans, windows, [*apart, Apart(earlier, later, longest + far, strict=True)])
    assert found is None
    assert cheapest_times(spans, windows, apart) is not None


def test_what_is_strict_is_kept_by_a_tick() -> None:
    end = Fraction(4)
    windows = [(Fraction(0), Fraction(0)), (Fraction(0), end), (end, end)]
    spans = [Span(1.0, Fraction(0))] * 2
    assert times_of(spans, windows, [Apart(0, 1, Fraction(3))])[1] == 3
    assert times_of(spans, windows, [Apart(0, 1, Fraction(3), strict=True)])[1] == 3 + TICK
    assert Apart(0, 1, Fraction(3), strict=True).broken == Apart(1, 0, Fraction(-3))
