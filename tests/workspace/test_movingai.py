from __future__ import annotations

from pathlib import Path

import pytest

from mitlplan.errors import WorkspaceError
from mitlplan.workspace import movingai
from mitlplan.workspace.movingai import read_terrain

EXAMPLES = Path(__file__).parents[2] / "examples" / "maps"


def write(folder: Path, text: str | bytes) -> Path:
    file = folder / "some.map"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


def a_map(*rows: str, end: str = "\n") -> str:
    return end.join(["type octile", f"height {len(rows)}", f"width {len(rows[0])}", "map", *rows, ""])


@pytest.mark.parametrize(
    ("name", "cells"),
    [("warehouse-10-20-10-2-1", 5_699), ("random-32-32-20", 819), ("Berlin_1_256", 47_540)],
)
def test_the_examples_have_the_free_cells_they_are_known_for(name: str, cells: int) -> None:
    assert movingai(EXAMPLES / f"{name}.map").cell_count == cells


def test_rows_come_first_and_count_from_the_top() -> None:
    # 161 wide and 63 high: row and column cannot be confused.
    workspace = movingai(EXAMPLES / "warehouse-10-20-10-2-1.map", regions={"bay": [[31, 157]]})
    assert workspace.index_of("r31c157") is not None
    assert workspace.index_of("r157c31") is None
    assert [cell for cell in range(workspace.cell_count) if workspace.holds(cell)] == [
        workspace.index_of("r31c157")
    ]


def test_terrain_letters(tmp_path: Path) -> None:
    workspace = movingai(write(tmp_path, a_map(".GS", "@OT", "WW.")))
    assert list(workspace.names) == ["r0c0", "r0c1", "r0c2", "r2c0", "r2c1", "r2c2"]
    moves = {
        (workspace.names[source], workspace.names[target])
        for source, target in zip(workspace.source.tolist(), workspace.target.tolist(), strict=True)
    }
    # Swamp is entered from ground; water only from water, and it is not left for land.
    assert moves == {
        ("r0c0", "r0c1"),
        ("r0c1", "r0c0"),
        ("r0c1", "r0c2"),
        ("r0c2", "r0c1"),
        ("r2c0", "r2c1"),
        ("r2c1", "r2c0"),
    }


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("rest", ["", "\n\n"])
def test_ends_of_lines(tmp_path: Path, end: str, rest: str) -> None:
    assert read_terrain(write(tmp_path, a_map("..", ".@", end=end) + rest)).tolist() == [[1, 1], [1, 0]]


def test_the_last_line_needs_no_end(tmp_path: Path) -> None:
    assert read_terrain(write(tmp_path, a_map("..", ".@").rstrip())).tolist() == [[1, 1], [1, 0]]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "line 1: this is no MovingAI map, which begins with 'type octile'"),
        (
            "type hex\nheight 1\nwidth 1\nmap\n.\n",
            "line 1: this is no MovingAI map, which begins with 'type octile'",
        ),
        ("type octile\nwidth 1\nheight 1\nmap\n.\n", "line 2: 'height N' is expected here, N a whole number"),
        ("type octile\nheight 1\nwidth x\nmap\n.\n", "line 3: 'width N' is expected here, N a whole number"),
        (
            "type octile\nheight -1\nwidth 1\nmap\n.\n",
            "line 2: 'height N' is expected here, N a whole number",
        ),
        ("type octile\nheight 1\nwidth 1\n.\n.\n", "line 4: 'map' is expected here"),
        ("type octile\nheight 2\nwidth 2\nmap\n..\n", "line 5: the map ends after 1 of 2 rows"),
        ("type octile\nheight 1\nwidth 2\nmap\n...\n", "line 5: this row has 3 cells where the width is 2"),
        ("type octile\nheight 1\nwidth 2\nmap\n..\n..\n", "line 6: there is more after the last of 1 rows"),
        (
            "type octile\nheight 2\nwidth 2\nmap\n..\n.x\n",
            "line 6: 'x' in column 1 is no terrain; the letters are . G S W @ O T",
        ),
    ],
)
def test_what_is_no_map(tmp_path: Path, text: str, problem: str) -> None:
    file = write(tmp_path, text)
    with pytest.raises(WorkspaceError) as caught:
        movingai(file)
    assert str(caught.value) == f"{file}, {problem}"
    assert caught.value.where == ("file",)


def test_a_map_that_claims_to_be_huge(tmp_path: Path) -> None:
    file = write(tmp_path, "type octile\nheight 9999999\nwidth 9999999\nmap\n.\n")
    with pytest.raises(WorkspaceError, match="is too large; at most 4000000 cells are read"):
        movingai(file)


def test_a_file_that_is_huge(tmp_path: Path) -> None:
    file = tmp_path / "huge.map"
    with file.open("wb") as stream:
        stream.truncate(2**30)
    with pytest.raises(WorkspaceError, match=r"huge\.map is too large; at most 4000000 cells are read"):
        movingai(file)


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(WorkspaceError) as caught:
        movingai(tmp_path)
    assert str(caught.value) == f"cannot read the map {tmp_path}: Is a directory"
