from __future__ import annotations

import math
import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan.errors import TrajectoryError, WorkspaceError
from mitlplan.formats.trajectory_csv import trajectory_to_csv
from mitlplan.plan import Loop, Plan, Step
from mitlplan.trajectory.follow import Waiting, follow
from mitlplan.trajectory.leg import Weights
from mitlplan.trajectory.motion import Style
from mitlplan.trajectory.passage import choose
from mitlplan.trajectory.profile import Profile
from mitlplan.trajectory.robot import Driving, Robot
from mitlplan.trajectory.trajectory import Trajectory
from mitlplan.workspace import Move, Workspace, graph, grid
from tests.trajectory.oracles import clearance, crosses_at_doors, integrated, strays
from tests.trajectory.strategies import plan_of, plans

ONE, HALF = Fraction(1), Fraction(1, 2)


def walk(*cells: str, stay: Fraction = ONE) -> Plan:
    return plan_of(list(cells), [stay] * (len(cells) - 1))


def lands(trajectory: Trajectory) -> bool:
    """Whether the controls, integrated from the first pose, lead to the last."""
    jumps = [0.0]
    for piece in trajectory.pieces:
        begin, duration = float(piece.begin), float(piece.duration)
        even = piece.motion.profile is Profile.EVEN
        parts = [[leg.duration for leg in stroke] for stroke in piece.motion.strokes]
        shares = np.cumsum([part for stroke in parts for part in (stroke if even else [sum(stroke)])])
        jumps += [*(begin + duration * shares[:-1]).tolist(), begin + duration]

    def controls(time: float) -> tuple[float, float]:
        course = trajectory.sample_at(np.array([time])).course
        return float(course.u[0]), float(course.w[0])

    first, last = trajectory.pieces[0].pose, trajectory.last_pose
    end = integrated((first.x, first.y, first.heading), controls, jumps)
    return end == pytest.approx((last.x, last.y, last.heading), abs=1e-8)


drivings = st.sampled_from(
    [
        Driving(),
        Driving(reverse=True),
        Driving(Weights(0.2, 3.0)),
        Driving(turn=Style.ARC, u_turn=Style.FORWARD_ONLY),
        Driving(turn=Style.SPOT, u_turn=Style.SPOT, profile=Profile.CUBIC),
        Driving(turn=Style.FORWARD_ONLY, profile=Profile.QUINTIC),
    ]
)


@given(plans(), drivings, st.sampled_from(Waiting))
@settings(max_examples=60)
def test_the_robot_is_where_the_plan_says(
    case: tuple[Workspace, Plan], driving: Driving, waiting: Waiting
) -> None:
    workspace, plan = case
    trajectory = follow(plan, workspace, driving=driving, waiting=waiting)
    assert [visit.cell for visit in trajectory.visits] == [step.cell for step in plan.steps]
    assert [visit.enter for visit in trajectory.visits] == [step.enter for step in plan.steps]
    assert crosses_at_doors(trajectory)
    assert strays(trajectory, Fraction(1, 50)) <= 1e-9
    last = trajectory.visits[-1].ground
    assert (trajectory.last_pose.x, trajectory.last_pose.y) == pytest.approx((last.x, last.y), abs=1e-9)
    assert trajectory.end >= plan.makespan


@given(plans(loops=True), drivings)
@settings(max_examples=30)
def test_loops_close(case: tuple[Workspace, Plan], driving: Driving) -> None:
    workspace, plan = case
    trajectory = follow(plan, workspace, driving=driving)
    assert plan.loop is not None
    assert trajectory.repeat_from is not None
    assert trajectory.end - trajectory.repeat_from == plan.loop.period
    assert strays(trajectory, Fraction(1, 50)) <= 1e-9
    assert crosses_at_doors(trajectory)
    times = np.linspace(0.0, 3 * float(trajectory.end), 500)
    course = trajectory.sample_at(times).course
    end = trajectory.sample_at(np.array([float(trajectory.end)])).course
    begin = trajectory.sample_at(np.array([float(trajectory.repeat_from)])).course
    assert (end.x, end.y) == (pytest.approx(begin.x, abs=1e-9), pytest.approx(begin.y, abs=1e-9))
    # The heading goes on without a jump, however often the robot goes round.
    assert np.abs(np.diff(course.heading)).max() <= np.abs(course.w).max() * (times[1] - times[0]) * 3 + 1e-9


@given(st.one_of(plans(), plans(loops=True)), drivings, st.sampled_from(Waiting))
@settings(max_examples=8)
def test_the_controls_lead_to_the_end(
    case: tuple[Workspace, Plan], driving: Driving, waiting: Waiting
) -> None:
    workspace, plan = case
    assert lands(follow(plan, workspace, driving=driving, waiting=waiting))


@given(
    st.one_of(plans(), plans(loops=True)),
    drivings,
    st.sampled_from(Waiting),
    st.sampled_from([Fraction(1, 10), Fraction(1, 5), Fraction(6, 25)]),
)
@settings(max_examples=40)
def test_a_robot_with_a_size_touches_no_wall(
    case: tuple[Workspace, Plan], driving: Driving, waiting: Waiting, radius: Fraction
) -> None:
    """The narrowest cells are half a metre wide, so there is always a way for these."""
    workspace, plan = case
    trajectory = follow(plan, workspace, robot=Robot(radius=radius), driving=driving, waiting=waiting)
    assert clearance(trajectory, Fraction(1, 50)) >= float(radius) - 1e-9
    assert strays(trajectory, Fraction(1, 50)) <= 1e-9
    assert crosses_at_doors(trajectory)


def test_the_paper_walks() -> None:
    """phi1: pos0 pos1 pos2 pos3, or by way of a U-turn at pos1."""
    square = grid(2, 2)
    round_the_square = follow(walk("r0c0", "r0c1", "r1c1", "r1c0"), square)
    assert round_the_square.cost == pytest.approx(0.25 + 2 * 3.0771054975 + 0.5, abs=1e-9)
    back_and_forth = follow(walk("r0c0", "r0c1", "r0c0", "r1c0"), square)
    assert back_and_forth.cost == pytest.approx(0.25 + 12.0567588 + 3.0771055 + 0.5, abs=1e-6)


def test_a_thousand_cells_take_less_than_a_second() -> None:
    turns = np.random.default_rng(1).integers(-1, 2, size=999).cumsum() % 4
    steps = np.array([(0, 1), (1, 0), (0, -1), (-1, 0)])[turns]
    rows, columns = (np.vstack([(0, 0), steps]).cumsum(axis=0)).T
    rows, columns = rows - rows.min(), columns - columns.min()
    plan = walk(*(f"r{row}c{column}" for row, column in zip(rows, columns, strict=True)))
    world = grid(int(rows.max()) + 1, int(columns.max()) + 1)
    choose.cache_clear()
    begin = time.process_time()
    table = trajectory_to_csv(follow(plan, world), Fraction(1, 20))
    assert time.process_time() - begin < 1.0
    assert len(table.splitlines()) > 1000 / 20


def test_driving_backwards_saves_a_u_turn() -> None:
    plan = walk("r0c0", "r0c1", "r0c0", "r1c0")
    trajectory = follow(plan, grid(2, 2), driving=Driving(reverse=True))
    assert trajectory.cost == pytest.approx(0.25 + 1.0 + 3.0771054975 + 0.5, abs=1e-9)
    assert trajectory.sample(Fraction(1, 10)).course.u.min() < 0


def test_time_scaling() -> None:
    fast, slow = (
        follow(walk("r0c0", "r0c1", "r1c1", stay=stay), grid(2, 2), stop_time=stay / 2)
        for stay in (ONE, 3 * ONE)
    )
    # The workspace's moves take a second, so a stay of three has a wait of two unless it is driven slowly.
    assert slow.cost < fast.cost
    slow = follow(
        walk("r0c0", "r0c1", "r1c1", stay=3 * ONE), grid(2, 2), waiting=Waiting.SLOW, stop_time=3 * HALF
    )
    assert slow.cost == pytest.approx(fast.cost / 3, rel=1e-12)


@pytest.mark.parametrize(("waiting", "place"), [(Waiting.ENTRY, (1.0, 0.5)), (Waiting.CENTRE, (1.5, 0.5))])
def test_where_the_robot_waits(waiting: Waiting, place: tuple[float, float]) -> None:
    plan = plan_of(["r0c0", "r0c1", "r0c2"], [ONE, 5 * ONE])
    trajectory = follow(plan, grid(1, 3, waiting=True), waiting=waiting)
    samples = trajectory.sample(Fraction(1, 100))
    still = (samples.course.u == 0) & (samples.course.w == 0) & (samples.time < 6)
    assert still.sum() == pytest.approx(400, abs=2)
    assert samples.course.x[still] == pytest.approx(place[0], abs=1e-9)
    assert samples.course.y[still] == pytest.approx(place[1], abs=1e-9)


def test_a_wait_that_is_driven_slowly_costs_least() -> None:
    plan = plan_of(["r0c0", "r0c1", "r1c1", "r1c0"], [ONE, 5 * ONE, 2 * ONE])
    costs = [follow(plan, grid(2, 2, waiting=True), waiting=waiting).cost for waiting in Waiting]
    assert costs.index(min(costs)) == list(Waiting).index(Waiting.SLOW)


def test_parking_ends_at_the_centre() -> None:
    steps = (Step("r0c0", Fraction(0), ONE), Step("r1c0", ONE, None))
    trajectory = follow(Plan(steps, ONE, loop=Loop(1, None)), grid(2, 2, waiting=True))
    assert trajectory.end == Fraction(3, 2)
    later = trajectory.sample_at(np.array([1.5, 99.0])).course
    assert later.y.tolist() == [0.5, 0.5]
    assert later.u.tolist() == [0.0, 0.0]


def test_a_plan_of_one_cell_stands_still() -> None:
    trajectory = follow(Plan((Step("r0c0", Fraction(0), 3 * ONE),), 3 * ONE), grid(1, 1), heading=0.5)
    assert trajectory.end == 3
    assert trajectory.cost == 0
    assert trajectory.last_pose.heading == 0.5


@pytest.mark.parametrize("heading", [0.0, 0.7, math.pi / 2, 3.0, -2.5])
def test_a_given_heading_at_the_start(heading: float) -> None:
    trajectory = follow(walk("r0c0", "r0c1"), grid(1, 2), heading=heading)
    assert trajectory.pieces[0].pose.heading == heading
    assert strays(trajectory, Fraction(1, 200)) <= 1e-9
    assert trajectory.cost >= follow(walk("r0c0", "r0c1"), grid(1, 2)).cost
    assert lands(trajectory)


def test_a_given_place_at_the_start() -> None:
    trajectory = follow(walk("r0c0", "r0c1"), grid(1, 2), start=(0.2, 0.9))
    assert (trajectory.pieces[0].pose.x, trajectory.pieces[0].pose.y) == (0.2, 0.9)
    assert strays(trajectory, Fraction(1, 200)) <= 1e-9
    with pytest.raises(TrajectoryError, match=r"starts at \(1.2, 0.9\), which is not in r0c0"):
        follow(walk("r0c0", "r0c1"), grid(1, 2), start=(1.2, 0.9))


def test_diagonal_moves_go_through_the_corner() -> None:
    world = grid(3, 3, neighbours=8, diagonal_time="1.5")
    plan = plan_of(["r2c0", "r1c1", "r0c2", "r0c1"], [Fraction(3, 2), Fraction(3, 2), ONE])
    trajectory = follow(plan, world)
    assert strays(trajectory, Fraction(1, 200)) <= 1e-9
    assert lands(trajectory)


def test_headings_are_continuous() -> None:
    plan = walk("r0c0", "r0c1", "r1c1", "r1c0", "r0c0", "r0c1", "r1c1", "r1c0", "r0c0", "r0c1")
    samples = follow(plan, grid(2, 2)).sample(Fraction(1, 100))
    assert np.abs(np.diff(samples.course.heading)).max() < 0.05
    assert samples.course.heading[-1] == pytest.approx(-4 * math.pi)


# ------------------------------------------------------------------------------------------------ no way


def test_speed_limit_names_the_cell() -> None:
    with pytest.raises(TrajectoryError) as error:
        follow(walk("r0c0", "r0c1", "r0c2"), grid(1, 3), robot=Robot(speed=Fraction(4, 5)))
    assert str(error.value) == (
        "r0c1, entered at 1: the straight way takes 1.25 s because of the speed limit of 0.8 m/s, but has 1 s"
    )


def test_turn_rate_limit_names_the_cell() -> None:
    with pytest.raises(TrajectoryError, match=r"r0c1, entered at 1: .* turn rate limit of 1 rad/s"):
        follow(walk("r0c0", "r0c1", "r1c1"), grid(2, 2), robot=Robot(turn_rate=ONE))


def test_a_robot_that_is_too_large() -> None:
    with pytest.raises(TrajectoryError, match=r"a robot of radius 0\.6 m does not fit"):
        follow(walk("r0c0", "r0c1", "r0c2"), grid(1, 3), robot=Robot(radius=Fraction(3, 5)))


def test_a_large_robot_turns_otherwise() -> None:
    """The three-point turn comes as near as 0.35 m to a wall of the unit cell."""
    plan = walk("r0c0", "r0c1", "r0c0")
    names = []
    for radius in (0, Fraction(1, 3), Fraction(2, 5)):
        trajectory = follow(plan, grid(1, 2), robot=Robot(radius=Fraction(radius)))
        names.append(trajectory.pieces[1].motion.name)
    assert names == ["three-point U-turn", "three-point U-turn", "forward-only U-turn"]


def test_acceleration_needs_a_smooth_profile() -> None:
    plan, robot = walk("r0c0", "r0c1", "r1c1", stay=4 * ONE), Robot(acceleration=HALF)
    world = grid(2, 2, move_time=4)
    with pytest.raises(TrajectoryError, match="ask for a profile from rest to rest"):
        follow(plan, world, robot=robot)
    smooth = Driving(profile=Profile.QUINTIC)
    samples = follow(plan, world, robot=robot, driving=smooth).sample(Fraction(1, 1000))
    assert np.abs(np.diff(samples.course.u)).max() * 1000 <= 0.5
    with pytest.raises(TrajectoryError, match="acceleration limit of 0.05"):
        follow(plan, world, robot=Robot(acceleration=Fraction(1, 20)), driving=smooth)


def test_the_limits_are_kept() -> None:
    robot = Robot(speed=Fraction(3, 5), turn_rate=Fraction(4, 5), radius=Fraction(1, 5))
    plan = walk("r0c0", "r0c1", "r1c1", "r1c0", "r1c1", stay=5 * ONE)
    samples = follow(plan, grid(2, 2, move_time=5), robot=robot).sample(Fraction(1, 500))
    assert np.abs(samples.course.u).max() <= 0.6 + 1e-9
    assert np.abs(samples.course.w).max() <= 0.8 + 1e-9


def test_a_stay_is_used_where_the_move_alone_is_too_short() -> None:
    plan = plan_of(["r0c0", "r0c1", "r0c2"], [2 * ONE, 2 * ONE])
    robot = Robot(speed=Fraction(4, 5))
    samples = follow(plan, grid(1, 3, waiting=True), robot=robot).sample(Fraction(1, 100))
    assert samples.course.u.max() <= 0.8 + 1e-9


def test_a_loop_that_only_a_robot_in_reverse_can_drive() -> None:
    plan = plan_of(["r0c0", "r0c1"], [2 * ONE] * 2, loop=0)
    world, robot = grid(1, 2, move_time=2), Robot(speed=Fraction(3, 5))
    with pytest.raises(TrajectoryError, match="the three-point U-turn takes"):
        follow(plan, world, robot=robot)
    trajectory = follow(plan, world, robot=robot, driving=Driving(reverse=True))
    assert trajectory.cost == pytest.approx(0.125 + 2 * 0.5)


def test_what_is_no_walk() -> None:
    with pytest.raises(TrajectoryError, match="leaves r0c0 at 0, when it enters; a stay takes time"):
        follow(walk("r0c0", "r0c1", stay=0 * ONE), grid(1, 2))
    with pytest.raises(TrajectoryError, match="leaves r0c0 at -1, before it enters at 0"):
        follow(Plan((Step("r0c0", 0 * ONE, -ONE),), ONE), grid(1, 2))
    with pytest.raises(TrajectoryError, match="no cell is called r9c9; cells are r0c0 to r0c1"):
        follow(walk("r0c0", "r9c9"), grid(1, 2))
    moves = grid(1, 2)
    back = slice(1, None)
    only_back = replace(
        moves,
        source=moves.source[back],
        target=moves.target[back],
        least=moves.least[back],
        most=moves.most[back],
    )
    with pytest.raises(TrajectoryError, match="from r0c0 to r0c1, but no move leads there"):
        follow(walk("r0c0", "r0c1"), only_back)
    with pytest.raises(WorkspaceError, match="r0c0 and r0c2 do not touch"):
        follow(walk("r0c0", "r0c2"), grid(1, 3))
    with pytest.raises(WorkspaceError, match="says nothing of where its cells lie"):
        follow(walk("a", "b"), graph({"a": [], "b": []}, [Move("a", "b")]))
