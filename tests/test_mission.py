from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.errors import MissionError
from mitlplan.logic.formula import Atom, Eventually
from mitlplan.logic.normalize import warnings
from mitlplan.logic.parse import parse
from mitlplan.mission import Mission, mission_from_mapping, read, schema
from mitlplan_fuzz.missions import SmallMission, random_mission

EXAMPLES = Path(__file__).parents[1] / "examples"

PHI1 = """\
mitlplan: 1
workspace:
  graph:
    cells: {pos0: [], pos1: [B], pos2: [], pos3: [A]}
    moves:
      - {from: pos0, to: pos1, time: 1, both: true}
      - {from: pos1, to: pos2, time: 0.1}
    waiting: false
robot: {start: pos1}
spec: {order: "!A U B", visit: "F A"}
horizon: finite
until: closed
epsilon: 1/7
"""


def write(folder: Path, text: str, name: str = "mission.yaml") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def test_a_mission_whole(tmp_path: Path) -> None:
    file = write(tmp_path, PHI1)
    mission = read(file)
    assert list(mission.workspace.names) == ["pos0", "pos1", "pos2", "pos3"]
    assert mission.start == 1
    assert [(one.name, one.text, one.formula) for one in mission.spec] == [
        ("order", "!A U B", parse("!A U B")),
        ("visit", "F A", Eventually(Atom("A"))),
    ]
    assert (mission.horizon, mission.until, mission.epsilon) == ("finite", "closed", Fraction(1, 7))
    assert mission.source == file
    assert mission.workspace.durations == (Fraction(1, 10), Fraction(1))
    assert not mission.workspace.waiting


def test_what_is_left_out(tmp_path: Path) -> None:
    text = "mitlplan: 1\nworkspace: {grid: {rows: 1, columns: 2}}\nrobot: {start: r0c1}\nspec: F true\n"
    mission = read(write(tmp_path, text))
    assert (mission.horizon, mission.until, mission.epsilon) == ("infinite", "standard", Fraction(1, 1000))
    assert [one.name for one in mission.spec] == ["spec"]
    assert mission.workspace.durations == (1,)
    assert not mission.workspace.waiting


def test_what_is_given_beside_the_file_comes_first(tmp_path: Path) -> None:
    mission = read(write(tmp_path, PHI1), horizon="infinite", until="standard", epsilon=Fraction(1, 9))
    assert (mission.horizon, mission.until, mission.epsilon) == ("infinite", "standard", Fraction(1, 9))


def test_an_until_that_can_never_hold_is_warned_of(tmp_path: Path) -> None:
    file = write(tmp_path, PHI1.replace("!A U B", "!B U B"))
    (sentence,) = warnings(parse("!B U B"), "closed")
    assert read(file).warnings == (f"the requirement order: {sentence}",)
    assert read(file, until="standard").warnings == ()


def test_json_says_the_same(tmp_path: Path) -> None:
    data = {
        "mitlplan": 1,
        "workspace": {
            "graph": {
                "cells": {"pos0": [], "pos1": ["B"]},
                "moves": [{"from": "pos0", "to": "pos1", "time": 0.1, "both": True}],
            }
        },
        "robot": {"start": "pos0"},
        "spec": "F B",
    }
    mission = read(write(tmp_path, json.dumps(data), "mission.json"))
    assert mission.workspace.durations == (Fraction(1, 10),)
    assert mission.workspace.move_count == 2


@pytest.mark.parametrize(
    ("written", "least", "most"),
    [
        ("0.1", Fraction(1, 10), Fraction(1, 10)),
        ("7/2", Fraction(7, 2), Fraction(7, 2)),
        ("'7/2'", Fraction(7, 2), Fraction(7, 2)),
        ("1e-3", Fraction(1, 1000), Fraction(1, 1000)),
        ("0.1000000000000000055511151231257827", None, None),
        ("[0.1, 1/3]", Fraction(1, 10), Fraction(1, 3)),
        ("0", Fraction(0), None),
        ("[0, 2]", Fraction(0), Fraction(2)),
    ],
)
def test_numbers_are_exact(
    tmp_path: Path, written: str, least: Fraction | None, most: Fraction | None
) -> None:
    text = (
        f"mitlplan: 1\nworkspace: {{grid: {{rows: 1, columns: 2, move_time: {written}}}}}\n"
        "robot: {start: r0c0}\nspec: F true\n"
    )
    if least is None:
        with pytest.raises(MissionError, match="is out of range"):
            read(write(tmp_path, text))
        return
    workspace = read(write(tmp_path, text)).workspace
    assert (workspace.least_time(0), workspace.most_time(0)) == (least, most)


def test_a_grid_whole(tmp_path: Path) -> None:
    text = """\
mitlplan: 1
workspace:
  grid:
    rows: 3
    columns: 4
    move_time: [1, 2]
    waiting: true
    blocked: [[1, 1], {rows: [2, 2], columns: [0, 1]}]
    neighbours: 8
    diagonal_time: 1.5
    propositions: [C]
    regions:
      A: [[2, 2], {rows: [0, 1], columns: [3, 3]}]
      B: {rows: [0, 2], columns: [0, 3]}
robot: {start: [0, 3]}
spec: F (A & C)
"""
    workspace = (mission := read(write(tmp_path, text))).workspace
    assert workspace.names[mission.start] == "r0c3"
    carrying = {workspace.names[cell] for cell in range(workspace.cell_count) if "A" in workspace.holds(cell)}
    assert carrying == {"r2c2", "r0c3", "r1c3"}
    assert all("B" in workspace.holds(cell) for cell in range(workspace.cell_count))
    assert workspace.cell_count == 9
    assert workspace.durations == (1, Fraction(3, 2), 2)


def test_maps_are_beside_the_mission_file(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    write(tmp_path / "maps", "type octile\nheight 1\nwidth 3\nmap\n..@\n", "tiny.map")
    text = (
        "mitlplan: 1\nworkspace: {movingai: {file: maps/tiny.map, regions: {A: [[0, 1]]}}}\n"
        "robot: {start: r0c0}\nspec: F A\n"
    )
    assert list(read(write(tmp_path, text)).workspace.names) == ["r0c0", "r0c1"]


def test_a_mapping_takes_python_numbers() -> None:
    mission = mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {"grid": {"rows": 1, "columns": 3, "move_time": Fraction(1, 3), "waiting": True}},
            "robot": {"start": (0, 2)},
            "spec": {"wait": "F true"},
        }
    )
    assert mission.workspace.durations == (Fraction(1, 3),)
    assert mission.workspace.names[mission.start] == "r0c2"
    assert mission.source is None


def test_a_mapping_takes_no_float() -> None:
    with pytest.raises(MissionError) as caught:
        mission_from_mapping(
            {
                "mitlplan": 1,
                "workspace": {"grid": {"rows": 1, "columns": 3, "move_time": 0.1}},
                "robot": {"start": "r0c0"},
                "spec": "F true",
            }
        )
    assert str(caught.value) == (
        "workspace.grid.move_time: the time of a move: 0.1 is not an exact number; write it as a text or a "
        "Fraction, such as '0.1'"
    )


def test_a_robot_gives_the_times_of_moves() -> None:
    mission = mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {"grid": {"rows": 1, "columns": 3}},
            "robot": {"start": "r0c0", "speed": "0.4", "headings": "true"},
            "spec": "F true",
        }
    )
    world = mission.workspace
    assert world.names[mission.start] == "r0c0@start"
    times = {world.names[int(world.target[move])]: world.least_time(move) for move in world.moves_from(0)}
    assert times == {"r0c1@east": Fraction(5, 4)}
    assert mission.robot is not None
    assert mission.robot.robot.speed == Fraction(2, 5)
    assert list(mission.robot.ground.names) == ["r0c0", "r0c1", "r0c2"]
    assert [mission.robot.ground.names[cell] for cell in mission.robot.cell_of] == [
        name.partition("@")[0] for name in world.names
    ]


@pytest.mark.parametrize("file", sorted(EXAMPLES.rglob("*.yaml")), ids=lambda file: file.stem)
def test_the_examples_are_read(file: Path) -> None:
    mission = read(file)
    assert all(one.name != "spec" for one in mission.spec)
    assert file.read_text(encoding="utf-8").startswith("# ")


@pytest.mark.parametrize("number", range(40))
def test_small_missions_come_back_from_their_files(tmp_path: Path, number: int) -> None:
    small: SmallMission = random_mission(number)
    assert_same(read(write(tmp_path, small.yaml())), small)


def assert_same(mission: Mission, small: SmallMission) -> None:
    workspace, built = mission.workspace, small.workspace()
    assert list(workspace.names) == list(built.names)
    assert [workspace.holds(cell) for cell in range(workspace.cell_count)] == [
        built.holds(cell) for cell in range(built.cell_count)
    ]
    assert workspace.source.tolist() == built.source.tolist()
    assert workspace.target.tolist() == built.target.tolist()
    assert mission.start == small.start_index
    assert (mission.horizon, mission.until) == (small.horizon, small.until)


def test_the_schema_knows_the_keys() -> None:
    published = schema()
    assert set(published["properties"]) == {
        "mitlplan",
        "workspace",
        "robot",
        "spec",
        "horizon",
        "until",
        "epsilon",
    }
    assert published["additionalProperties"] is False
    assert published["required"] == ["mitlplan", "workspace", "robot", "spec"]
    moves = published["$defs"]["MoveKeys"]
    assert list(moves["properties"]) == ["from", "to", "time", "both"]
    assert published["$defs"]["WorkspaceKeys"]["maxProperties"] == 1
    robot = published["$defs"]["RobotKeys"]
    assert robot["required"] == ["start"]
    assert list(robot["properties"]) == [
        "start",
        "speed",
        "turn_rate",
        "acceleration",
        "turn_acceleration",
        "heading",
        "radius",
        "headings",
        "rest_to_rest",
        "retime",
        "deadline",
    ]
    assert robot["properties"]["headings"]["type"] == "boolean"
    assert {"enum": ["cubic", "quintic"]} in robot["properties"]["rest_to_rest"]["anyOf"]


_WORDS = [
    "mitlplan", "workspace", "grid", "graph", "cells", "moves", "rows", "columns", "robot", "start", "spec",
    "1", "0", "-1", "r0c0", "F A", "A", "", "true",
]  # fmt: skip


@given(
    st.recursive(
        st.sampled_from(_WORDS) | st.integers(-2, 3) | st.booleans() | st.none(),
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(_WORDS), inner, max_size=4)
        ),
        max_leaves=12,
    )
)
def test_any_data_is_a_mission_or_refused(data: object) -> None:
    with pytest.raises(MissionError):
        mission_from_mapping(data)  # type: ignore[arg-type]
