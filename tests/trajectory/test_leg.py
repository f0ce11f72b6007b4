from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mitlplan.trajectory.leg import Leg, Oscillating, Rotating, Steady, Weights, end_of, extremal

scales = st.sampled_from([1e-7, 1e-3, 0.3, 1.0, 4.0])
numbers = st.builds(lambda value, scale: value * scale, st.floats(-1.0, 1.0), scales)
MOMENTS = np.array([0.0, 0.21, 0.5, 0.83])


def pendulum(speed: float, across: float, turn_rate: float) -> tuple[float, float, float]:
    """The end of the extremal, by integrating Pontryagin's equations."""

    def moved(_: float, now: np.ndarray) -> list[float]:
        _, _, heading, w = now
        u = speed * math.cos(heading) + across * math.sin(heading)
        return [
            u * math.cos(heading),
            u * math.sin(heading),
            w,
            u * (speed * math.sin(heading) - across * math.cos(heading)),
        ]

    found = solve_ivp(moved, (0.0, 1.0), [0.0, 0.0, 0.0, turn_rate], method="DOP853", rtol=1e-13, atol=1e-18)
    x, y, heading, _ = found.y[:, -1].tolist()
    return x, y, heading


@given(numbers, numbers, numbers)
def test_extremals_solve_the_equations_of_pontryagin(speed: float, across: float, turn_rate: float) -> None:
    end = end_of(extremal(speed, across, turn_rate, length=1.0))
    assert (end.x, end.y, end.heading) == pytest.approx(pendulum(speed, across, turn_rate), abs=1e-9)


@given(numbers, numbers, numbers)
def test_the_start_is_the_one_asked_for(speed: float, across: float, turn_rate: float) -> None:
    course = extremal(speed, across, turn_rate, length=1.0).course(np.zeros(1))
    assert course.u[0] == pytest.approx(speed, abs=1e-12)
    assert course.w[0] == pytest.approx(turn_rate, abs=1e-12)


LEGS: list[Leg] = [
    Steady(0.7, -0.4, 1.0),
    extremal(0.6, 0.6, 1.6, length=1.0),
    extremal(-0.6, 1.4, -0.9, length=1.0),
    extremal(0.5, -1.5, 0.2, length=0.4),
    extremal(-1.0, 0.3, 2.0, length=2.5),
]


def test_the_examples_are_of_every_kind() -> None:
    assert {type(leg) for leg in LEGS} == {Steady, Rotating, Oscillating}


@pytest.mark.parametrize("leg", LEGS)
def test_the_rate_of_cost_is_constant(leg: Leg) -> None:
    weights = Weights(1 / leg.length**2, 1.0) if not isinstance(leg, Steady) else Weights()
    course = leg.course(MOMENTS)
    rates = weights.linear * course.u**2 + weights.angular * course.w**2
    assert rates == pytest.approx(leg.rate(weights), rel=1e-12)


@pytest.mark.parametrize("leg", LEGS)
def test_poses_and_slopes_are_those_of_the_controls(leg: Leg) -> None:
    small = 1e-6
    before, now, after = (leg.course(MOMENTS + shift) for shift in (-small, 0.0, small))
    assert (after.x - before.x) / (2 * small) == pytest.approx(now.u * np.cos(now.heading), abs=1e-8)
    assert (after.y - before.y) / (2 * small) == pytest.approx(now.u * np.sin(now.heading), abs=1e-8)
    assert (after.heading - before.heading) / (2 * small) == pytest.approx(now.w, abs=1e-8)
    slopes = leg.slopes(MOMENTS)
    assert (after.u - before.u) / (2 * small) == pytest.approx(slopes[0], abs=1e-7)
    assert (after.w - before.w) / (2 * small) == pytest.approx(slopes[1], abs=1e-7)


@pytest.mark.parametrize("leg", LEGS)
def test_mirrored_backward_retraced(leg: Leg) -> None:
    course, end = leg.course(MOMENTS), leg.course(np.array(1.0) - MOMENTS)
    mirrored, backward, retraced = (
        other.course(MOMENTS) for other in (leg.mirrored, leg.backward, leg.retraced)
    )
    assert (mirrored.x, mirrored.y, mirrored.heading, mirrored.u, mirrored.w) == (
        pytest.approx(course.x, abs=1e-12),
        pytest.approx(-course.y, abs=1e-12),
        pytest.approx(-course.heading, abs=1e-12),
        pytest.approx(course.u, abs=1e-12),
        pytest.approx(-course.w, abs=1e-12),
    )
    assert (backward.x, backward.y, backward.heading, backward.u, backward.w) == (
        pytest.approx(-course.x, abs=1e-12),
        pytest.approx(-course.y, abs=1e-12),
        pytest.approx(course.heading, abs=1e-12),
        pytest.approx(-course.u, abs=1e-12),
        pytest.approx(course.w, abs=1e-12),
    )
    assert (retraced.u, retraced.w) == (pytest.approx(end.u, abs=1e-11), pytest.approx(end.w, abs=1e-11))


@pytest.mark.parametrize("leg", LEGS)
def test_scaling_in_time_is_the_papers_lemma(leg: Leg) -> None:
    slow = leg.scaled(3.0)
    fast, same_place = leg.course(MOMENTS), slow.course(3.0 * MOMENTS)
    assert same_place.x == pytest.approx(fast.x, abs=1e-12)
    assert same_place.heading == pytest.approx(fast.heading, abs=1e-12)
    assert same_place.u == pytest.approx(fast.u / 3.0, abs=1e-12)
    assert same_place.w == pytest.approx(fast.w / 3.0, abs=1e-12)
    assert slow.rate(Weights()) * slow.duration == pytest.approx(leg.rate(Weights()) / 3.0, rel=1e-12)


def test_weights_are_positive() -> None:
    with pytest.raises(ValueError, match="positive"):
        Weights(linear=0.0)
