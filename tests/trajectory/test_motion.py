from __future__ import annotations

import math

import numpy as np
import pytest

from mitlplan.trajectory.leg import Steady, Weights
from mitlplan.trajectory.motion import (
    Motion,
    Style,
    passing,
    standing,
    straight,
    turn_left,
    turn_right,
    u_turn,
)
from mitlplan.trajectory.pose import QUARTER, Pose
from mitlplan.trajectory.profile import Profile
from tests.trajectory.oracles import integrated

EQUAL = Weights()
UNEVEN = Weights(2.0, 0.5)
U_TURNS = (Style.THREE_POINT, Style.FORWARD_ONLY, Style.SPOT)
TURNS = (Style.FREE, Style.FORWARD_ONLY, Style.ARC, Style.SPOT)


def every_motion() -> list[Motion]:
    found: list[Motion | None] = [straight(1.0, EQUAL), straight(-0.5, UNEVEN)]
    for style in TURNS:
        found += [turn_left(0.5, 0.5, EQUAL, style), turn_right(0.5, 1.5, UNEVEN, style)]
        found += [turn_left(1.5, 0.5, EQUAL, style)]
    for style in U_TURNS:
        found += [u_turn(0.5, EQUAL, style), u_turn(0.8, UNEVEN, style)]
    found += [passing(Pose(0.0, 0.0, 0.0), Pose(0.5, 0.0, 0.0), EQUAL, Style.SPOT)]
    found += [passing(Pose(-0.5, 0.5, QUARTER), Pose(-0.5, 0.0, 0.0), EQUAL, Style.FREE)]
    return [motion for motion in found if motion is not None]


def cost_of(motion: Motion | None) -> float:
    assert motion is not None
    return motion.cost


def test_costs_in_the_unit_cell() -> None:
    assert straight(1.0, EQUAL).cost == pytest.approx(1.0, abs=1e-14)
    assert straight(0.5, EQUAL).cost == pytest.approx(0.25, abs=1e-14)
    assert cost_of(turn_left(0.5, 0.5, EQUAL)) == pytest.approx(3.0771054975, abs=1e-10)
    assert cost_of(turn_left(0.5, 0.5, EQUAL, Style.ARC)) == pytest.approx(
        math.pi**2 / 16 + math.pi**2 / 4, abs=1e-12
    )
    assert cost_of(u_turn(0.5, EQUAL, Style.THREE_POINT)) == pytest.approx(12.0567588, abs=1e-7)
    assert cost_of(u_turn(0.5, EQUAL, Style.FORWARD_ONLY)) == pytest.approx(15.88706, abs=1e-5)
    assert cost_of(u_turn(0.5, EQUAL, Style.SPOT)) == pytest.approx((1 + math.pi) ** 2, abs=1e-12)


def test_there_are_many_motions() -> None:
    assert len(every_motion()) == 22


def lands(motion: Motion, jumps: list[float]) -> bool:
    def controls(time: float) -> tuple[float, float]:
        course = motion.course(np.array([time]))
        return float(course.u[0]), float(course.w[0])

    end = integrated((0.0, 0.0, 0.0), controls, jumps)
    return end == pytest.approx((motion.end.x, motion.end.y, motion.end.heading), abs=1e-8)


@pytest.mark.parametrize("motion", every_motion(), ids=lambda motion: motion.name)
def test_the_controls_lead_to_the_end(motion: Motion) -> None:
    durations = [leg.duration for stroke in motion.strokes for leg in stroke]
    assert lands(motion, [*np.cumsum([0.0, *durations[:-1]]).tolist(), 1.0])


@pytest.mark.parametrize("profile", [Profile.CUBIC, Profile.QUINTIC])
def test_smooth_controls_lead_to_the_end(profile: Profile) -> None:
    motion = u_turn(0.5, EQUAL)
    assert motion is not None
    durations = [sum(leg.duration for leg in stroke) for stroke in motion.strokes]
    assert lands(motion.smoothed(profile), [0.0, durations[0], 1.0])


@pytest.mark.parametrize("motion", every_motion(), ids=lambda motion: motion.name)
@pytest.mark.parametrize("profile", Profile)
def test_the_cost_is_the_integral(motion: Motion, profile: Profile) -> None:
    weights = UNEVEN if motion.cost_in(1.0) in {m.cost for m in uneven_motions()} else EQUAL
    smooth = motion.smoothed(profile)
    total = 0.0
    begin = 0.0
    points, shares = np.polynomial.legendre.leggauss(40)
    for stroke in motion.strokes:
        seconds = sum(leg.duration for leg in stroke)
        course = smooth.course(begin + seconds * (points + 1) / 2)
        total += float((weights.linear * course.u**2 + weights.angular * course.w**2) @ shares) * seconds / 2
        begin += seconds
    assert total == pytest.approx(smooth.cost, rel=1e-9)


def uneven_motions() -> list[Motion]:
    found = [straight(-0.5, UNEVEN), *(turn_right(0.5, 1.5, UNEVEN, style) for style in TURNS)]
    found += [u_turn(0.8, UNEVEN, style) for style in U_TURNS]
    return [motion for motion in found if motion is not None]


def test_profiles_from_rest_to_rest() -> None:
    turn = turn_left(0.5, 0.5, EQUAL)
    assert turn is not None
    assert turn.smoothed(Profile.CUBIC).cost == pytest.approx(1.2 * turn.cost, rel=1e-12)
    assert turn.smoothed(Profile.QUINTIC).cost == pytest.approx(10 / 7 * turn.cost, rel=1e-12)
    assert turn.smoothed(Profile.QUINTIC).smoothed(Profile.EVEN).cost == pytest.approx(turn.cost, rel=1e-12)
    ends = np.array([0.0, 1.0])
    for profile in (Profile.CUBIC, Profile.QUINTIC):
        course = turn.smoothed(profile).course(ends)
        assert np.abs(course.u).max() < 1e-12
        assert np.abs(course.w).max() < 1e-12
    assert np.abs(turn.smoothed(Profile.QUINTIC).slopes(ends)).max() < 1e-10
    assert np.abs(turn.smoothed(Profile.CUBIC).slopes(ends)).max() > 1.0


@pytest.mark.parametrize("profile", [Profile.CUBIC, Profile.QUINTIC])
def test_slopes_are_the_derivatives(profile: Profile) -> None:
    motion = u_turn(0.5, EQUAL)
    assert motion is not None
    smooth, moments, small = motion.smoothed(profile), np.linspace(0.02, 0.98, 41), 1e-6
    before, after = smooth.course(moments - small), smooth.course(moments + small)
    slopes = smooth.slopes(moments)
    assert (after.u - before.u) / (2 * small) == pytest.approx(slopes[0], abs=1e-6)
    assert (after.w - before.w) / (2 * small) == pytest.approx(slopes[1], abs=1e-6)


def test_only_the_ratio_of_length_and_weights_matters() -> None:
    one = cost_of(turn_left(0.5, 0.5, EQUAL))
    assert cost_of(turn_left(1.5, 1.5, Weights(1 / 9, 1.0))) == pytest.approx(one, rel=1e-12)
    assert cost_of(turn_left(1.5, 1.5, Weights(7 / 9, 7.0))) == pytest.approx(7 * one, rel=1e-12)


@pytest.mark.parametrize(("aspect", "backwards"), [(1.0, False), (1.75, False), (1.85, True), (3.0, True)])
def test_in_a_long_cell_the_free_optimum_drives_backwards_and_the_forward_one_does_not(
    aspect: float, backwards: bool
) -> None:
    """A quarter turn from the middle of the short side: the aspect at which that begins is about 1.8."""
    moments = np.linspace(0.0, 1.0, 2001)
    free, forward = (turn_left(aspect / 2, 0.5, EQUAL, style) for style in (Style.FREE, Style.FORWARD_ONLY))
    assert free is not None
    assert forward is not None
    course = free.course(moments)
    assert bool(course.u.min() < 0) is backwards
    assert bool(course.y.max() > 0.5 + 1e-9) is backwards  # it has crossed the edge through which it leaves
    course = forward.course(moments)
    assert course.u.min() >= 0
    assert course.y.max() <= 0.5 + 1e-12
    assert forward.cost >= free.cost - 1e-9
    assert bool(forward.cost > free.cost + 1e-9) is backwards


def test_a_wide_cell_is_a_long_one_the_other_way_round() -> None:
    for style in (Style.FREE, Style.FORWARD_ONLY, Style.ARC):
        assert cost_of(turn_left(0.5, 1.5, EQUAL, style)) == pytest.approx(
            cost_of(turn_left(1.5, 0.5, EQUAL, style)), rel=1e-9
        )


@pytest.mark.parametrize("depth", [0.05, 0.5, 2.0, 8.0])
def test_u_turns_reach_the_middle_and_stay_this_side_of_it(depth: float) -> None:
    moments = np.linspace(0.0, 1.0, 4001)
    costs = []
    for style in U_TURNS:
        motion = u_turn(depth, EQUAL, style)
        assert motion is not None
        turning = sum(leg.duration for leg in motion.strokes[0])
        course = motion.course(np.append(moments, turning if len(motion.strokes) > 1 else 0.5))
        assert course.x.max() == pytest.approx(depth, abs=1e-9)
        assert course.x.max() <= depth + 1e-9
        assert course.x.min() >= -1e-9
        costs.append(motion.cost)
    assert costs == sorted(costs)


@pytest.mark.parametrize("size", [10.0, 40.0, 200.0])
def test_turns_in_very_large_cells(size: float) -> None:
    turn = turn_left(size / 2, size / 2, EQUAL)
    assert turn is not None
    course = turn.course(np.array([1.0]))
    assert (course.x[0], course.y[0], course.heading[0]) == pytest.approx(
        (size / 2, size / 2, QUARTER), abs=1e-9
    )
    diagonal = size / math.sqrt(2)
    assert diagonal**2 < turn.cost < (diagonal + QUARTER) ** 2


def test_styles_that_do_not_exist() -> None:
    assert turn_left(0.5, 0.5, EQUAL, Style.THREE_POINT) is None
    assert u_turn(0.5, EQUAL, Style.FREE) is None
    assert u_turn(0.5, EQUAL, Style.ARC) is None


def test_standing_costs_nothing() -> None:
    assert standing().cost == 0
    assert standing().strokes == ((Steady(0.0, 0.0),),)
