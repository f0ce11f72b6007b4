"""Every refusal of a mission file, whole: the sentence is the interface."""

from __future__ import annotations

from pathlib import Path

import pytest

from mitlplan.errors import MissionError
from mitlplan.mission import mission_from_mapping, read

HEAD = "mitlplan: 1\n"
GRID = "workspace: {grid: {rows: 3, columns: 4, regions: {A: [[2, 0]], B: [[0, 3]]}, blocked: [[1, 1]]}}\n"
GRAPH = "workspace:\n  graph:\n    cells: {dock: [A], hall: []}\n"
ROBOT = "robot: {start: r0c0}\n"
SPEC = "spec: F A\n"


def on_grid(key: str) -> str:
    return f"{HEAD}workspace:\n  grid:\n    rows: 3\n    columns: 4\n    {key}\n{ROBOT}{SPEC}"


def with_region(region: str) -> str:
    return on_grid(f"regions:\n      A: {region}\n    blocked: [[1, 1]]")


def with_workspace(workspace: str) -> str:
    return f"{HEAD}workspace: {workspace}\n{ROBOT}{SPEC}"


def with_move(move: str) -> str:
    return f"{HEAD}{GRAPH}    moves:\n      - {move}\nrobot: {{start: dock}}\n{SPEC}"


SHAPE = {
    "": "1:1: the file is empty",
    "- 1\n": "1:1: keys with values are expected, such as mitlplan: ..., workspace: ...",
    "just text": "1:1: keys with values are expected, such as mitlplan: ..., workspace: ...",
    HEAD: "1:1: the key 'workspace' is missing",
    HEAD + GRID + ROBOT: "1:1: the key 'spec' is missing",
    HEAD + GRID + SPEC: "1:1: the key 'robot' is missing",
    GRID + ROBOT + SPEC: "1:1: the key 'mitlplan' is missing",
    "mitlplan: 2\n" + GRID + ROBOT + SPEC: "1:11: mitlplan: version 1 of the format is read here, not '2'",
    HEAD + GRID + ROBOT + SPEC + "horizn: finite\n": "5:1: unknown key 'horizn'; did you mean 'horizon'?",
    HEAD + GRID + ROBOT + SPEC + "foo: 1\n": (
        "5:1: unknown key 'foo'; the keys here are mitlplan, workspace, robot, spec, horizon, until, epsilon"
    ),
    HEAD + GRID + ROBOT + SPEC + '"\\e[31m": 1\n': (
        "5:1: unknown key '\\x1b[31m'; the keys here are mitlplan, workspace, robot, spec, horizon, until, "
        "epsilon"
    ),
    HEAD + GRID + ROBOT + SPEC + "horizon: never\n": (
        "5:10: horizon: 'infinite' or 'finite' is expected, not 'never'"
    ),
    HEAD + GRID + ROBOT + SPEC + "until: open\n": (
        "5:8: until: 'standard' or 'closed' is expected, not 'open'"
    ),
    HEAD + GRID + ROBOT + SPEC + "epsilon: 0\n": (
        "5:10: epsilon: a positive number is expected, such as 1/1000"
    ),
    HEAD + GRID + ROBOT + SPEC + "epsilon: -1\n": (
        "5:10: epsilon: -1 is negative; write 0 or a positive number"
    ),
}

KINDS = {
    with_workspace(""): "3:1: workspace: keys with values are expected, such as graph: ..., grid: ...",
    with_workspace(
        "{}"
    ): "2:12: workspace: exactly one kind of workspace is expected: graph, grid or movingai",
    with_workspace("{grid: {rows: 1, columns: 1}, graph: {cells: {a: []}}}"): (
        "2:12: workspace: exactly one kind of workspace is expected: graph, grid or movingai, not 2 "
        "(grid, graph)"
    ),
    with_workspace("{gird: {rows: 1}}"): "2:13: workspace: unknown key 'gird'; did you mean 'grid'?",
    with_workspace("{movingai: {}}"): "2:23: workspace.movingai: the key 'file' is missing",
    **{
        with_workspace(f"{{{kind}: {{file: a}}}}"): (
            f"2:13: workspace: '{kind}' is not yet supported; use graph, grid or movingai"
        )
        for kind in ("occupancy", "route_graph", "polygons")
    },
}

GRIDS = {
    with_workspace("{grid: {rows: 1}}"): "2:19: workspace.grid: the key 'columns' is missing",
    with_workspace("{grid: {rows: 1.5, columns: 2}}"): (
        "2:26: workspace.grid.rows: a whole number from 0 is expected, not '1.5'"
    ),
    with_workspace("{grid: {rows: -1, columns: 2}}"): (
        "2:26: workspace.grid.rows: a whole number from 0 is expected, not '-1'"
    ),
    with_workspace("{grid: {rows: 0, columns: 2}}"): (
        "2:19: workspace.grid: a map of 0 rows and 2 columns has no cell"
    ),
    with_workspace("{grid: {rows: 100000, columns: 20000}}"): (
        "2:19: workspace.grid: a map of 100000 rows and 20000 columns is too large; at most 4000000 cells "
        "are read"
    ),
    on_grid("movetime: 1"): "6:5: workspace.grid: unknown key 'movetime'; did you mean 'move_time'?",
    on_grid("waiting: yes"): "6:14: workspace.grid.waiting: true or false is expected, not 'yes'",
    on_grid("waiting:"): "7:1: workspace.grid.waiting: true or false is expected, not ''",
    on_grid("neighbours: 8"): (
        "6:17: workspace.grid.neighbours: neighbours: 8 needs a diagonal_time, for example 1.414 with a "
        "move_time of 1"
    ),
    on_grid("neighbours: 5"): "6:17: workspace.grid.neighbours: neighbours is 4 or 8, not 5",
    on_grid("diagonal_time: 2"): (
        "6:20: workspace.grid.diagonal_time: diagonal_time needs neighbours: 8; with 4 there is no diagonal "
        "move"
    ),
    on_grid("blocked: [[9, 9]]"): (
        "6:15: workspace.grid.blocked[0]: blocked: row 9 is outside the map, whose rows are 0 to 2"
    ),
    on_grid("blocked: [{rows: [0, 2], columns: [0, 3]}]"): (
        "4:5: workspace.grid: every cell of the map is blocked"
    ),
    on_grid("blocked: 3"): "6:14: workspace.grid.blocked: a list is expected, not '3'",
}

TIMES = {
    "1e400": "the time of a move: 1e400 is out of range; numbers and their denominators go up to 1e18",
    "nan": "the time of a move: 'nan' is not a number; write one such as 5, 2.5 or 7/2",
    ".inf": "the time of a move: '.inf' is not a number; write one such as 5, 2.5 or 7/2",
    "-1": "the time of a move: -1 is negative; write 0 or a positive number",
    "one": "the time of a move: 'one' is not a number; write one such as 5, 2.5 or 7/2",
    "''": "the time of a move: '' is not a number; write one such as 5, 2.5 or 7/2",
    "{a: 1}": "the time of a move: {'a': '1'} is not a number; write one such as 5, 2.5 or 7/2",
    "1/0": "the time of a move: 1/0 divides by zero",
    "[2, 1]": "the range of time [2, 1] has its least above its most; swap them",
    "[0, 0]": "the range of time [0, 0] holds no positive time; write 0 for any positive stay",
    "[1, 2, 3]": "a range of time is [least, most], two numbers, not 3",
    "[1, x]": "the time of a move: 'x' is not a number; write one such as 5, 2.5 or 7/2",
}

REGIONS = {
    "[2, 0]": (
        "7:11: workspace.grid.regions.A[0]: a cell [row, column] is expected, not '2'; a list of one cell is "
        "[[row, column]]"
    ),
    "[[1, 2, 3]]": (
        "7:11: workspace.grid.regions.A[0]: a cell [row, column] is expected, not ['1', '2', '3']; a list of "
        "one cell is [[row, column]]"
    ),
    "[[a, b]]": "7:11: workspace.grid.regions.A[0]: a whole number from 0 is expected, not 'a'",
    "here": "7:10: workspace.grid.regions.A: a list is expected, not 'here'",
    "[[0, 0], [3, 0]]": (
        "7:19: workspace.grid.regions.A[1]: the region A: row 3 is outside the map, whose rows are 0 to 2"
    ),
    "[[1, 1]]": (
        "7:11: workspace.grid.regions.A[0]: the region A: the cell [1, 1] is blocked; cells are [row, column]"
    ),
    "[]": "7:10: workspace.grid.regions.A: the region A has no free cell",
    "{rows: [1, 1], columns: [1, 1]}": "7:10: workspace.grid.regions.A: the region A has no free cell",
    "{rows: [0, 5], columns: [0, 0]}": (
        "7:10: workspace.grid.regions.A: the region A: row 5 is outside the map, whose rows are 0 to 2"
    ),
    "{rows: [2, 1], columns: [1, 1]}": (
        "7:10: workspace.grid.regions.A: the region A: the rows [2, 1] hold nothing; write the lower "
        "one first"
    ),
    "{rows: 1, columns: [1, 1]}": (
        "7:17: workspace.grid.regions.A.rows: [first, last] is expected, not '1'; both belong to the box"
    ),
    "{row: [1, 1], columns: [1, 1]}": (
        "7:11: workspace.grid.regions.A: unknown key 'row'; did you mean 'rows'?"
    ),
    "{rows: [1, 1]}": "7:10: workspace.grid.regions.A: the key 'columns' is missing",
}

GRAPHS = {
    with_move("{from: dock, to: hal, time: 1}"): (
        "6:26: workspace.graph.moves[0].to: no cell is called hal; did you mean hall?"
    ),
    with_move("{from: dock, to: hall}"): "6:9: workspace.graph.moves[0]: the key 'time' is missing",
    with_move("{from: dock, to: hall, time: [3, 1]}"): (
        "6:38: workspace.graph.moves[0].time: the range of time [3, 1] has its least above its most; swap "
        "them"
    ),
    with_move("[dock, hall, 1]"): (
        "6:9: workspace.graph.moves[0]: keys with values are expected, such as from: ..., to: ..."
    ),
    with_workspace("{graph: {cells: {dock: A, hall: }}}"): (
        "2:35: workspace.graph.cells.dock: a list is expected, not 'A'"
    ),
    with_workspace("{graph: {cells: [a, b]}}"): (
        "2:28: workspace.graph.cells: names with values are expected, not ['a', 'b']"
    ),
    with_workspace("{graph: {cells: {}}}"): "2:20: workspace.graph: the workspace has no cell",
    with_workspace('{graph: {cells: {"a\\nb": []}}}'): (
        "2:29: workspace.graph.cells: a name is expected, not 'a\\nb'"
    ),
    with_workspace("{graph: {cells: {a: [B, my dock]}}}"): (
        "2:36: workspace.graph.cells.a[1]: the proposition 'my dock' cannot stand in a formula; a name is a "
        "letter followed by letters, digits, _ and ., and is no operator"
    ),
}

NAMES = {
    on_grid("regions: {A: [[0, 0]], F: [[0, 0]]}"): (
        "6:28: workspace.grid.regions: the proposition 'F' cannot stand in a formula; a name is a letter "
        "followed by letters, digits, _ and ., and is no operator"
    ),
    on_grid("propositions: [A, true]"): (
        "6:23: workspace.grid.propositions[1]: the proposition 'true' cannot stand in a formula; a name is a "
        "letter followed by letters, digits, _ and ., and is no operator"
    ),
}

ROBOTS = {
    "{start: r1c1}": "3:16: robot.start: no cell is called r1c1; that cell is blocked",
    "{start: here}": (
        "3:16: robot.start: no cell is called here; cells are r0c0 to r2c3, row first, counted from the top "
        "left"
    ),
    "{start: [0, 4]}": (
        "3:16: robot.start: no cell is called r0c4; cells are r0c0 to r2c3, row first, counted from the top "
        "left"
    ),
    "{start: [0]}": (
        "3:16: robot.start: a cell [row, column] is expected, not ['0']; a list of one cell is "
        "[[row, column]]"
    ),
    "{start: }": "3:15: robot.start: a name is expected, not ''",
    "{strat: r0c0}": "3:9: robot: unknown key 'strat'; did you mean 'start'?",
    "{start: r0c0, heading: 0}": (
        "3:22: robot: 'heading' needs the robot's speed, from which the times of moves are computed"
    ),
    "{start: r0c0, headings: true}": (
        "3:22: robot: 'headings' needs the robot's speed, from which the times of moves are computed"
    ),
    "{start: r0c0, deadline: 8}": (
        "3:22: robot: 'deadline' needs retime: true; otherwise a plan keeps its times"
    ),
    "{start: r0c0, retime: true, deadline: soon}": (
        "3:46: robot.deadline: 'soon' is not a number; write one such as 5, 2.5 or 7/2"
    ),
    "{start: r0c0, speed: -1/2}": ("3:29: robot.speed: -1/2 is negative; write 0 or a positive number"),
    "{start: r0c0, speed: 0}": (
        "3:29: robot.speed: a positive number is expected; a limit that the robot does not have is left out"
    ),
    "{start: r0c0, speed: fast}": (
        "3:29: robot.speed: 'fast' is not a number; write one such as 5, 2.5 or 7/2"
    ),
    "{start: r0c0, speed: 1, turn_rate: 0}": (
        "3:43: robot.turn_rate: a positive number is expected; a limit that the robot does not have is left "
        "out"
    ),
    "{start: r0c0, speed: 1, radius: -1}": (
        "3:40: robot.radius: -1 is negative; write 0 or a positive number"
    ),
    "{start: r0c0, speed: 1, heading: up}": (
        "3:41: robot.heading: a heading is a number of radians or one of east, northeast, north, northwest, "
        "west, southwest, south, southeast, not up"
    ),
    "{start: r0c0, speed: 1, headings: 2}": "3:42: robot.headings: true or false is expected, not '2'",
    "{start: r0c0, speed: 1, rest_to_rest: soft}": (
        "3:46: robot.rest_to_rest: true, false, cubic or quintic is expected, not 'soft'"
    ),
    "{start: r0c0, speed: 1, acceleration: 1}": (
        "3:32: robot: 'acceleration' needs rest_to_rest: true; otherwise the controls jump, which no "
        "acceleration allows"
    ),
    "{start: r0c0, speed: 1, radius: 2}": (
        "3:8: robot: a cell of 1 m by 1 m cannot be crossed: a robot of radius 2 m does not fit: "
        "the spot U-turn comes as near as 0.5 m to a wall"
    ),
    "r0c0": "3:8: robot: keys with values are expected, such as start: ..., speed: ...",
}

SPECS = {
    "F C": (
        "4:7: spec: No cell carries the proposition C.\n  F C\n    ^\n"
        "  hint: the propositions are A, B (or give the map propositions: [C])"
    ),
    '{one: F A, two: "F[0,2 B"}': (
        "4:23: spec.two: Expected `]` or `)` to end the interval, but found `B`.\n  F[0,2 B\n        ^\n"
        "  hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)"
    ),
    "{}": "4:7: spec: there is no requirement; write a formula or name: formula",
    "[F A, F B]": (
        "4:7: spec: a formula is expected, not ['F A', 'F B']; several are named, as in {one: F A, two: F B}"
    ),
    "{one: [F A]}": (
        "4:13: spec.one: a formula is expected, not ['F A']; several are named, as in {one: F A, two: F B}"
    ),
    "{one: F A, one: F B}": "4:18: the key 'one' is given twice, first in line 4",
    "{'': F A}": "4:8: spec: a name is expected, not ''",
    "!A U B": "4:7: put this in quotes: YAML takes a text that begins with ! for a tag",
    '"F A \\e[31m"': (
        "4:7: spec: a formula is expected, not 'F A \\x1b[31m'; several are named, as in {one: F A, two: F B}"
    ),
}


def refusal(folder: Path, text: str) -> str:
    file = folder / "mission.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(MissionError) as caught:
        read(file)
    return str(caught.value).removeprefix(f"{file}:")


@pytest.mark.parametrize(
    ("text", "message"),
    [*(SHAPE | KINDS | GRIDS | GRAPHS | NAMES).items()],
    ids=lambda text: repr(text)[-40:],
)
def test_shape_and_map(tmp_path: Path, text: str, message: str) -> None:
    assert refusal(tmp_path, text) == message


@pytest.mark.parametrize(("time", "message"), TIMES.items())
def test_times(tmp_path: Path, time: str, message: str) -> None:
    assert refusal(tmp_path, on_grid(f"move_time: {time}")) == f"6:16: workspace.grid.move_time: {message}"


@pytest.mark.parametrize(("region", "message"), REGIONS.items())
def test_regions(tmp_path: Path, region: str, message: str) -> None:
    assert refusal(tmp_path, with_region(region)) == message


@pytest.mark.parametrize(("robot", "message"), ROBOTS.items())
def test_robots(tmp_path: Path, robot: str, message: str) -> None:
    assert refusal(tmp_path, f"{HEAD}{GRID}robot: {robot}\n{SPEC}") == message


@pytest.mark.parametrize("headings", ["true", "false"])
def test_a_robot_on_a_map_without_geometry(tmp_path: Path, headings: str) -> None:
    text = with_move("{from: dock, to: dock, time: 1}")
    asked = text.replace("{start: dock}", f"{{start: dock, speed: 1, headings: {headings}}}")
    assert asked != text
    found = refusal(tmp_path, asked)
    assert found.endswith(
        "robot: this map says nothing of where its cells lie, so no robot can be sent across it; "
        "use a grid or another map with a geometry"
    )


@pytest.mark.parametrize("key", ["move_time", "diagonal_time"])
def test_a_robot_and_times_of_moves_too(tmp_path: Path, key: str) -> None:
    text = on_grid(f"{key}: 1").replace("{start: r0c0}", "{start: r0c0, speed: 1}")
    assert refusal(tmp_path, text) == (
        f"6:5: workspace.grid: the robot's speed gives the times of moves; leave {key} out, or the speed"
    )


@pytest.mark.parametrize(("spec", "message"), SPECS.items())
def test_specs(tmp_path: Path, spec: str, message: str) -> None:
    assert refusal(tmp_path, f"{HEAD}{GRID}{ROBOT}spec: {spec}\n") == message


def test_a_mistyped_proposition_has_its_neighbour_named(tmp_path: Path) -> None:
    text = on_grid("regions: {base: [[0, 0]], bay: [[0, 1]]}").replace("F A", "G (F bays) & F base")
    assert refusal(tmp_path, text) == (
        "8:7: spec: No cell carries the proposition bays.\n  G (F bays) & F base\n       ^^^^\n"
        "  hint: did you mean bay or base? (or give the map propositions: [bays])"
    )


def test_a_map_that_cannot_be_read(tmp_path: Path) -> None:
    text = with_workspace("{movingai: {file: nowhere.map}}")
    assert refusal(tmp_path, text) == (
        f"2:30: workspace.movingai.file: cannot read the map {tmp_path / 'nowhere.map'}: "
        "No such file or directory"
    )


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    rows = ["a: &a [x, x, x, x, x, x, x, x, x]"]
    rows += [
        f"{two}: &{two} [{', '.join([f'*{one}'] * 9)}]"
        for one, two in zip("abcdefgh", "bcdefghi", strict=True)
    ]
    assert refusal(tmp_path, "\n".join(rows)) == (
        "1:4: anchors (&name) are not read; write the value out where it is needed"
    )


def test_a_mapping_has_no_place() -> None:
    with pytest.raises(MissionError) as caught:
        mission_from_mapping({"mitlplan": 1, "workspace": {}, "robot": {"start": "a"}, "spec": "F A"})
    assert str(caught.value) == (
        "workspace: exactly one kind of workspace is expected: graph, grid or movingai"
    )
