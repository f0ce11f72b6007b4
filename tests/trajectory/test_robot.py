from __future__ import annotations

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan.errors import TrajectoryError, WorkspaceError
from mitlplan.plan import Plan
from mitlplan.trajectory.follow import follow
from mitlplan.trajectory.leg import Weights
from mitlplan.trajectory.motion import Style
from mitlplan.trajectory.passage import INSIDE, choose, passage
from mitlplan.trajectory.pose import Pose
from mitlplan.trajectory.profile import Profile
from mitlplan.trajectory.robot import DrivenTimes, Driving, Robot, least_time
from mitlplan.workspace import Workspace, graph, grid
from mitlplan.workspace.motion import Door, Rectangle, with_headings, with_travel_times
from tests.trajectory.strategies import lattice, plan_of

CELL = Rectangle(0.0, 0.0, 1.0, 1.0)
WEST, EAST = Door(-0.5, 0.0, 0.0, 1.0), Door(0.5, 0.0, 0.0, 1.0)
NORTH, BACK = Door(0.0, 0.5, math.pi / 2, 1.0), Door(-0.5, 0.0, math.pi, 1.0)
ENTRY = Pose(-0.5, 0.0, 0.0)
ROBOT = Robot(speed=Fraction(1, 2), turn_rate=Fraction(1))


def goal(door: Door) -> Pose:
    return Pose(door.x, door.y, door.heading)


# --------------------------------------------------------------------------------------------- passages


def test_what_a_motion_asks_of_the_robot() -> None:
    straight = choose(passage(CELL, ENTRY, goal(EAST), (WEST, EAST)), Style.FREE, Weights(), Profile.EVEN)
    assert straight is not None
    assert (straight.speed, straight.turn_rate, straight.clearance) == (
        pytest.approx(1.0),
        0.0,
        pytest.approx(0.5),
    )
    assert math.isinf(straight.acceleration)
    smooth = choose(passage(CELL, ENTRY, goal(EAST), (WEST, EAST)), Style.FREE, Weights(), Profile.CUBIC)
    assert smooth is not None
    # s = 3 t^2 - 2 t^3: s' is 1.5 at the most and s'' 6.
    assert (smooth.speed, smooth.acceleration) == (pytest.approx(1.5), pytest.approx(6.0))
    assert least_time(smooth, Robot(acceleration=Fraction(3, 2))) == pytest.approx(2.0)
    assert least_time(smooth, Robot(speed=Fraction(1, 2), acceleration=Fraction(6))) == pytest.approx(3.0)


def test_peaks_are_those_of_dense_samples() -> None:
    moments = np.linspace(0.0, 1.0, 20001)
    for door, style in product((NORTH, BACK), Style):
        for profile in Profile:
            choice = choose(passage(CELL, ENTRY, goal(door), (WEST, door)), style, Weights(), profile)
            if choice is not None:
                course = choice.motion.course(moments)
                assert choice.speed == pytest.approx(np.abs(course.u).max(), abs=1e-6)
                assert choice.turn_rate == pytest.approx(np.abs(course.w).max(), abs=1e-6)


def test_equal_passages_are_one_whatever_their_direction() -> None:
    for turns in range(4):
        frame = Pose(3.0, -7.0, turns * math.pi / 2)
        cell = Rectangle(3.0, -7.0, 1.0, 1.0)
        begin, end = frame.then(ENTRY), frame.then(goal(NORTH))
        doors = tuple(
            Door(place.x, place.y, place.heading, 1.0)
            for place in (frame.then(ENTRY), frame.then(goal(NORTH)))
        )
        assert passage(cell, begin, end, doors) == passage(CELL, ENTRY, goal(NORTH), (WEST, NORTH))


def test_a_narrow_door_is_nearer_than_the_walls() -> None:
    narrow = Door(-0.5, 0.0, 0.0, 0.4)
    straight = choose(passage(CELL, ENTRY, goal(EAST), (narrow, EAST)), Style.FREE, Weights(), Profile.EVEN)
    assert straight is not None
    assert straight.clearance == pytest.approx(0.2)


@pytest.mark.parametrize("style", [Style.FREE, Style.FORWARD_ONLY, Style.ARC, Style.SPOT])
@pytest.mark.parametrize("height", [1.0, 2.0, 4.0])
def test_what_leaves_the_cell_is_no_choice(style: Style, height: float) -> None:
    """In a cell twice as high as wide the free quarter turn would cross its edge before it ends on it."""
    cell = Rectangle(0.0, 0.0, 1.0, height)
    north = Door(0.0, height / 2, math.pi / 2, 1.0)
    choice = choose(passage(cell, ENTRY, goal(north), (WEST, north)), style, Weights(), Profile.EVEN)
    assert (choice is None) == (style is Style.FREE and height > 1.0)
    if choice is not None:
        course = choice.motion.course(np.linspace(0.0, 1.0, 5000)).placed(ENTRY)
        assert np.abs(course.x).max() <= 0.5 + INSIDE
        assert np.abs(course.y).max() <= height / 2 + INSIDE


# ----------------------------------------------------------------------------------------- travel times


def test_travel_times() -> None:
    times = DrivenTimes(ROBOT)
    assert times.through(CELL, WEST, EAST) == 2
    assert times.out_of(CELL, None, EAST) == 1
    turn, back = times.through(CELL, WEST, NORTH), times.through(CELL, WEST, BACK)
    assert 1 < turn < back
    assert turn == Fraction(1721, 1000)  # u is 0.860435 m/s at the most when it takes a second
    assert times.out_of(CELL, math.pi, EAST) > 1


def test_the_speed_is_needed() -> None:
    with pytest.raises(TrajectoryError, match="need the robot's speed"):
        DrivenTimes(Robot())


def test_a_cell_that_is_too_small() -> None:
    times = DrivenTimes(Robot(speed=Fraction(1), radius=Fraction(3, 5)))
    with pytest.raises(
        TrajectoryError, match=r"a cell of 1 m by 1 m cannot be crossed: a robot of radius 0\.6 m"
    ):
        times.through(CELL, WEST, EAST)


@pytest.mark.parametrize("name", ["speed", "turn_rate", "acceleration", "turn_acceleration"])
def test_limits_are_positive(name: str) -> None:
    with pytest.raises(TrajectoryError, match=f"{name} is 0; a limit is a positive number"):
        Robot(**{name: Fraction(0)})
    with pytest.raises(TrajectoryError, match="radius is -1"):
        Robot(radius=Fraction(-1))


def test_styles_that_make_no_sense() -> None:
    with pytest.raises(TrajectoryError, match="a three-point turn is a U-turn"):
        Driving(turn=Style.THREE_POINT)
    with pytest.raises(TrajectoryError, match="others never enter the cell"):
        Driving(u_turn=Style.FREE)


def test_without_headings_a_move_is_as_slow_as_its_worst_turn() -> None:
    world = with_travel_times(grid(2, 3), DrivenTimes(ROBOT), start=0)
    u_turn = DrivenTimes(ROBOT).through(CELL, WEST, BACK)
    # Whoever is in a cell may have come from where he goes to.
    assert {world.least_time(move) for move in range(world.move_count)} == {u_turn}
    assert world.names is not None
    assert not world.waiting


def test_a_one_way_street_needs_no_u_turn() -> None:
    street = grid(1, 4)
    onward = street.target > street.source
    one_way = Workspace(
        names=street.names,
        label_sets=street.label_sets,
        label_of=street.label_of,
        source=street.source[onward],
        target=street.target[onward],
        durations=street.durations,
        least=street.least[onward],
        most=street.most[onward],
        waiting=False,
        positions=street.positions,
        sizes=street.sizes,
    )
    world = with_travel_times(one_way, DrivenTimes(ROBOT), start=0)
    # Out of the first cell from its centre, half the way; nobody comes to it.
    assert [world.least_time(move) for move in range(3)] == [1, 2, 2]


def test_with_headings_each_turn_has_its_own_time() -> None:
    times = DrivenTimes(ROBOT)
    headed = with_headings(grid(2, 3, regions={"A": [[0, 2]]}), times, start=0)
    world = headed.workspace
    assert world.cell_count == 1 + grid(2, 3).move_count
    assert world.names[headed.start] == "r0c0@start"
    assert sorted(world.names)[:4] == ["r0c0@north", "r0c0@start", "r0c0@west", "r0c1@east"]
    assert (np.lexsort((world.target, world.source)) == np.arange(world.move_count)).all()
    found = {}
    for move in range(world.move_count):
        names = world.names[int(world.source[move])], world.names[int(world.target[move])]
        found[names] = world.least_time(move)
    assert found["r0c0@start", "r0c1@east"] == 1
    assert found["r0c1@east", "r0c2@east"] == 2
    assert found["r0c1@east", "r1c1@south"] == times.through(CELL, WEST, NORTH)
    assert found["r0c1@east", "r0c0@west"] == times.through(CELL, WEST, BACK)
    there = world.index_of("r0c2@east")
    assert there is not None
    assert world.holds(there) == {"A"}
    assert world.positions is not None
    assert world.positions[there].tolist() == [2.5, 1.5]


sizes = st.lists(st.sampled_from([0.5, 1.0, 2.5]), min_size=2, max_size=2)


@given(sizes, sizes, st.integers(0, 10**6), st.booleans())
@settings(max_examples=6)
def test_every_plan_on_travel_times_can_be_driven(
    widths: list[float], heights: list[float], seed: int, headings: bool
) -> None:
    random = np.random.default_rng(seed)
    robot = Robot(speed=Fraction(2, 5), turn_rate=Fraction(4, 5), radius=Fraction(1, 10))
    world, driving = lattice(widths, heights), Driving()
    times = DrivenTimes(robot, driving)
    cell_of = np.arange(world.cell_count)
    timed = with_travel_times(world, times, start=0)
    place = 0
    if headings:
        headed = with_headings(world, times, start=0)
        timed, cell_of, place = headed.workspace, headed.cell_of, headed.start
    cells, stays = [place], []
    for _ in range(6):
        move = int(random.choice(list(timed.moves_from(cells[-1]))))
        stays.append(timed.least_time(move))
        cells.append(int(timed.target[move]))
    plan: Plan = plan_of([world.names[int(cell_of[cell])] for cell in cells], stays)
    samples = follow(plan, world, robot=robot, driving=driving).sample(Fraction(1, 100))
    assert np.abs(samples.course.u).max() <= 0.4 * (1 + 1e-6)
    assert np.abs(samples.course.w).max() <= 0.8 * (1 + 1e-6)
    headed_plan = plan_of([timed.names[cell] for cell in cells], stays)
    again = follow(headed_plan, timed, robot=robot, driving=driving)
    assert again.last_pose == follow(plan, world, robot=robot, driving=driving).last_pose


def test_a_map_without_geometry() -> None:
    with pytest.raises(WorkspaceError, match="says nothing of where its cells lie"):
        with_headings(graph({"a": []}, []), DrivenTimes(ROBOT), start=0)


def test_a_large_map_is_headed_in_little_time() -> None:
    headed = with_headings(grid(120, 120), DrivenTimes(ROBOT), start=0)
    assert headed.workspace.move_count > 200_000
