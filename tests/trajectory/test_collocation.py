"""The closed forms against a general solver that knows nothing of extremals, to 1e-6."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mitlplan.trajectory.boundary import connect, cost_of_way, end_of_way
from mitlplan.trajectory.leg import Weights
from mitlplan.trajectory.motion import Style, turn_left, u_turn
from mitlplan.trajectory.pose import Pose
from tests.trajectory.elementary import ELEMENTARY, Elementary, through_the_centre
from tests.trajectory.oracles import collocated

pytest.importorskip("casadi")

EQUAL = Weights()


@pytest.mark.parametrize("motion", ELEMENTARY, ids=lambda one: one.name)
def test_elementary_motions(motion: Elementary) -> None:
    assert motion.collocated() == pytest.approx(motion.cost, abs=1e-6)


def test_the_three_point_turn_reaches_the_line_through_the_centre_and_not_the_centre() -> None:
    """What it costs to reach the line, and what it would cost to go through the centre itself."""
    assert u_turn(0.5, EQUAL).cost == pytest.approx(12.0567588, abs=1e-7)  # type: ignore[union-attr]
    assert through_the_centre() == pytest.approx(13.0033489, abs=1e-6)


@pytest.mark.parametrize(("ahead", "aside", "rho"), [(0.5, 0.5, 9.0), (1.0, 0.5, 1.0), (0.5, 1.0, 0.3)])
def test_quarter_turns(ahead: float, aside: float, rho: float) -> None:
    turn = turn_left(ahead, aside, Weights(rho, 1.0))
    assert turn is not None
    assert collocated([(ahead, aside, math.pi / 2)], rho=rho) == pytest.approx(turn.cost, abs=1e-6)


@pytest.mark.parametrize(("depth", "rho"), [(0.5, 9.0), (0.3, 4.0)])
def test_the_three_point_turn(depth: float, rho: float) -> None:
    """One goal on the line through the centre, its place along the line and its heading free."""
    turn = u_turn(depth, Weights(rho, 1.0))
    assert turn is not None
    found = collocated([(depth, None, None), (0.0, 0.0, math.pi)], rho=rho)
    assert found == pytest.approx(turn.cost, abs=1e-6)


@pytest.mark.parametrize(
    ("phases", "elements"),
    [([(0.0, 0.0, None), (0.5, 1.5, 1.0)], 40), ([(1.5, 0.5, None), (1.5, 0.5, 1.0)], 20)],
)
def test_forward_only_in_rectangles(phases: list[tuple[float, float, float | None]], elements: int) -> None:
    """The turn on the spot, at the beginning or at the end, is a phase of its own."""
    x, y, _ = phases[-1]
    turn = turn_left(x, y, EQUAL, Style.FORWARD_ONLY)
    assert turn is not None
    found = collocated([phases[0], (x, y, math.pi / 2)], forward=True, elements=elements)
    assert found == pytest.approx(turn.cost, abs=1e-6)


@pytest.mark.parametrize("goal", [Pose(0.5, 0.2, -0.7), Pose(-0.4, 0.6, 2.0), Pose(0.1, 0.5, 0.2)])
def test_other_poses(goal: Pose) -> None:
    way = connect(goal, EQUAL.length)
    end = end_of_way(way)
    assert (end.x, end.y, end.heading) == pytest.approx((goal.x, goal.y, goal.heading), abs=1e-9)
    found = min(collocated([(goal.x, goal.y, goal.heading)], seed=seed) for seed in range(3))
    assert found == pytest.approx(cost_of_way(way, EQUAL), abs=1e-6)


def test_stretched_in_time_a_quarter_turn_is_still_the_cheapest() -> None:
    turn = turn_left(0.5, 0.5, EQUAL)
    assert turn is not None
    slow = collocated([(0.5, 0.5, math.pi / 2)], duration=2.5)
    assert slow == pytest.approx(turn.cost_in(2.5), abs=1e-6)
    points, shares = np.polynomial.legendre.leggauss(30)
    course = turn.course((points + 1) / 2)
    driven = (course.u / 2.5) ** 2 + (course.w / 2.5) ** 2
    assert float(driven @ shares) / 2 * 2.5 == pytest.approx(slow, abs=1e-6)
