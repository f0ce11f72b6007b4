"""The robot of a mission file gives the times of moves, so that it can drive every plan within its limits."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from mitlplan.check import check
from mitlplan.cli import app
from mitlplan.formats.plan_json import plan_to_json, read_plan
from mitlplan.mission import Mission, mission_from_mapping, read
from mitlplan.plan import Infeasible, Plan
from mitlplan.planner import plan
from mitlplan.trajectory import DrivenTimes, Profile, Robot, Trajectory, follow
from mitlplan.workspace import grid
from mitlplan.workspace.motion import with_headings, with_travel_times
from tests.trajectory.oracles import crosses_at_doors, strays

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "robot.yaml"
KEPT = 1 + 1e-6
STEP = Fraction(1, 50)


def planned(mission: Mission) -> Plan:
    found = plan(mission)
    assert isinstance(found, Plan)
    assert found.checked
    assert check(mission, found) is None
    return found


def driven(mission: Mission, found: Plan) -> Trajectory:
    model = mission.robot
    assert model is not None
    return follow(found, mission.workspace, robot=model.robot, driving=model.driving, heading=model.heading)


def assert_within(trajectory: Trajectory, robot: Robot) -> None:
    course = trajectory.sample(STEP).course
    assert robot.speed is not None
    assert np.abs(course.u).max() <= float(robot.speed) * KEPT
    if robot.turn_rate is not None:
        assert np.abs(course.w).max() <= float(robot.turn_rate) * KEPT
    assert strays(trajectory, STEP) <= 1e-9
    assert crosses_at_doors(trajectory)


def square(spec: str = "(!A U B) & F A", *, kind: dict[str, Any] | None = None, **robot: object) -> Mission:
    regions = {"A": [[1, 0]], "B": [[0, 1]]}
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {"grid": {"rows": 2, "columns": 2, "regions": regions, **(kind or {})}},
            "robot": {"start": [0, 0], **robot},
            "spec": spec,
        }
    )


def test_the_example() -> None:
    mission = read(EXAMPLE)
    found = planned(mission)
    assert found.makespan == Fraction(10221, 500)
    assert [step.cell for step in found.steps[:2]] == ["r0c0@start", "r0c1@east"]
    trajectory = driven(mission, found)
    assert mission.robot is not None
    assert_within(trajectory, mission.robot.robot)
    assert trajectory.sample_at(np.array([0.0])).course.heading[0] == 0.0


def test_the_example_needs_its_headings(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8").replace("headings: true", "headings: false")
    (tmp_path / "mission.yaml").write_text(text, encoding="utf-8")
    assert isinstance(plan(read(tmp_path / "mission.yaml")), Infeasible)


def test_the_times_are_those_of_the_python_functions() -> None:
    robot = Robot(speed=Fraction(1, 2), turn_rate=Fraction(1), radius=Fraction(1, 5))
    said = {"speed": Fraction(1, 2), "turn_rate": 1, "radius": "0.2"}
    bare = grid(2, 2)
    plain, headed = square(**said), square(**said, headings=True)
    slowest = with_travel_times(bare, DrivenTimes(robot), start=0)
    turning = with_headings(bare, DrivenTimes(robot), start=0)
    for found, expected in ((plain.workspace, slowest), (headed.workspace, turning.workspace)):
        assert list(found.names) == list(expected.names)
        assert found.durations == expected.durations
        assert found.least.tolist() == found.most.tolist() == expected.least.tolist()
    assert headed.start == turning.start
    assert planned(plain).makespan == Fraction(3759, 250)
    assert planned(headed).makespan == Fraction(2221, 500)


def test_times_are_multiples_of_a_thousandth() -> None:
    mission = square(speed=Fraction(1, 3), turn_rate=Fraction(5, 7), headings=True)
    assert all((time * 1000).denominator == 1 for time in mission.workspace.durations)


def test_without_the_keys_nothing_changes() -> None:
    mission = square()
    assert mission.robot is None
    assert mission.workspace.durations == (1,)
    assert list(mission.workspace.names) == list(grid(2, 2).names)


@pytest.mark.parametrize(
    ("heading", "angle"), [("east", 0.0), ("north", math.pi / 2), ("-1.5", -1.5), (-1, -1.0), ("3/4", 0.75)]
)
def test_the_heading_at_the_start(heading: str | int, angle: float) -> None:
    mission = square(speed=1, heading=heading, headings=True)
    trajectory = driven(mission, planned(mission))
    assert mission.robot is not None
    assert mission.robot.heading == pytest.approx(angle)
    assert trajectory.sample_at(np.array([0.0])).course.heading[0] == pytest.approx(angle)


def test_from_rest_to_rest_accelerations_are_kept() -> None:
    said = {"speed": 1, "acceleration": Fraction(1, 2), "turn_acceleration": Fraction(1, 2)}
    mission = square(**said, rest_to_rest=True, headings=True)
    assert mission.robot is not None
    assert mission.robot.driving.profile is Profile.CUBIC
    trajectory = driven(mission, planned(mission))
    samples = trajectory.sample(Fraction(1, 1000))
    assert_within(trajectory, mission.robot.robot)
    for control in (samples.course.u, samples.course.w):
        assert np.abs(np.diff(control)).max() <= 0.5 / 1000 * (1 + 1e-3)
    assert square(speed=1, rest_to_rest="quintic").robot.driving.profile is Profile.QUINTIC  # type: ignore[union-attr]


def test_diagonal_moves_need_no_time_of_their_own() -> None:
    mission = square("F C", kind={"neighbours": 8, "regions": {"C": [[1, 1]]}}, speed=1, headings=True)
    found = planned(mission)
    assert [step.cell for step in found.steps] == ["r0c0@start", "r1c1@southeast"]
    assert found.makespan == Fraction(708, 1000)  # half the diagonal of a metre, rounded up


@pytest.mark.parametrize("headings", [True, False])
def test_a_loop_is_driven_round_and_round(headings: bool) -> None:
    mission = square("G F[0,30] A & G F[0,30] B", speed=1, turn_rate=1, headings=headings)
    found = planned(mission)
    assert found.loop is not None
    assert mission.robot is not None
    assert_within(driven(mission, found), mission.robot.robot)


@given(
    st.integers(1, 4),
    st.integers(2, 4),
    st.fractions(Fraction(1, 4), 2, max_denominator=7),
    st.none() | st.fractions(Fraction(1, 4), 2, max_denominator=7),
    st.fractions(0, Fraction(2, 5), max_denominator=10),
    st.tuples(st.booleans(), st.booleans()),
    st.sampled_from([None, "west", "north", 1]),
    st.sampled_from(["false", "cubic", "quintic"]),
    st.sampled_from(["F A & F B", "F[1,inf) A", "F (A & F[3,inf) B)", "!B U A"]),
)
@settings(max_examples=25)
def test_every_plan_can_be_driven(
    rows: int,
    columns: int,
    speed: Fraction,
    turn_rate: Fraction | None,
    radius: Fraction,
    flags: tuple[bool, bool],
    heading: str | int | None,
    profile: str,
    spec: str,
) -> None:
    headings, waiting = flags
    robot: dict[str, object] = {"start": [0, 0], "speed": speed, "radius": radius, "headings": headings}
    robot |= {"rest_to_rest": profile}
    robot |= {} if turn_rate is None else {"turn_rate": turn_rate}
    robot |= {} if heading is None else {"heading": heading}
    regions = {"A": [[rows - 1, 0]], "B": [[0, columns - 1]]}
    kind = {"rows": rows, "columns": columns, "waiting": waiting, "regions": regions}
    mission = mission_from_mapping({"mitlplan": 1, "workspace": {"grid": kind}, "robot": robot, "spec": spec})
    found = plan(mission)
    if isinstance(found, Plan):
        assert mission.robot is not None
        assert_within(driven(mission, found), mission.robot.robot)


@pytest.mark.parametrize(
    ("file", "start", "goal", "cells"),
    [("random-32-32-20", [0, 0], [24, 5], 32), ("Berlin_1_256", [20, 20], [255, 84], 300)],
)
@pytest.mark.parametrize("headings", [None, False, True])
def test_long_plans_on_maps(
    file: str, start: list[int], goal: list[int], cells: int, headings: bool | None
) -> None:
    robot: dict[str, object] = {"start": start}
    if headings is not None:
        robot |= {"speed": 1, "turn_rate": 1, "radius": Fraction(1, 5), "headings": headings}
    workspace = {"movingai": {"file": f"{file}.map", "regions": {"goal": [goal]}}}
    mission = mission_from_mapping(
        {"mitlplan": 1, "workspace": workspace, "robot": robot, "spec": "F goal"},
        folder=ROOT / "examples" / "maps",
    )
    found = planned(mission)
    assert len(found.steps) == cells if not headings else len(found.steps) >= cells
    if mission.robot is None:
        trajectory = follow(found, mission.workspace)
        assert strays(trajectory, STEP) <= 1e-9
        assert crosses_at_doors(trajectory)
    else:
        assert_within(driven(mission, found), mission.robot.robot)


# --------------------------------------------------------------------------------------- the command line


def run(*arguments: str | Path, code: int = 0) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, (result.output, result.exception)
    return result.stdout


def test_plans_with_headings_go_out_and_come_back(tmp_path: Path) -> None:
    file = tmp_path / "plan.json"
    run("plan", EXAMPLE, "--format", "json", "--output", file)
    mission, back = read(EXAMPLE), read_plan(file)
    assert json.loads(plan_to_json(back))["steps"] == json.loads(file.read_text())["steps"]
    assert back.steps[-1].cell == "r3c0@west"
    assert check(mission, back) is None
    run("check", EXAMPLE, file)
    text = file.read_text().replace("r0c1@east", "r0c1@west")
    file.write_text(text)
    run("check", EXAMPLE, file, code=1)


def test_the_commands_know_the_robot_of_the_mission() -> None:
    found = json.loads(run("trajectory", EXAMPLE, "--format", "json"))
    assert found["cells"][1]["cell"] == "r0c1@east"
    rows = [row.split(",") for row in run("trajectory", EXAMPLE).splitlines()[1:]]
    assert max(abs(float(row[4])) for row in rows) <= 0.5 * KEPT
    slower = CliRunner().invoke(app, ["trajectory", str(EXAMPLE), "--robot", "speed=1/4"])
    assert slower.exit_code == 2
    assert "because of the speed limit of 0.25 m/s" in slower.stderr


@pytest.mark.parametrize("shown", ["map", "plan", "trajectory"])
def test_pictures_show_the_map_as_it_was_given(tmp_path: Path, shown: str) -> None:
    run("draw", EXAMPLE, "--show", shown, "--output", tmp_path / "plan.svg")
    assert (tmp_path / "plan.svg").exists()


def test_a_picture_that_moves(tmp_path: Path) -> None:
    run("draw", EXAMPLE, "--output", tmp_path / "plan.gif")
    assert (tmp_path / "plan.gif").read_bytes().startswith(b"GIF8")
