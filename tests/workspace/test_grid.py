from __future__ import annotations

import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.errors import WorkspaceError
from mitlplan.workspace import Box, Workspace, grid
from mitlplan.workspace.grid import on_terrain

Moves = set[tuple[str, str, Fraction]]


def moves_of(workspace: Workspace) -> Moves:
    return {
        (
            workspace.names[int(workspace.source[move])],
            workspace.names[int(workspace.target[move])],
            workspace.least_time(move),
        )
        for move in range(workspace.move_count)
    }


def slow_moves(terrain: list[list[int]], neighbours: int) -> Moves:
    """The moves by the rule, cell by cell: 1 for a straight one, 7/5 for a diagonal that cuts no corner."""

    def at(row: int, column: int) -> int:
        inside = 0 <= row < len(terrain) and 0 <= column < len(terrain[0])
        return terrain[row][column] if inside else 0

    found = set()
    for row in range(len(terrain)):
        for column in range(len(terrain[0])):
            for down in (-1, 0, 1):
                for right in (-1, 0, 1):
                    diagonal = down != 0 and right != 0
                    passed = [at(row + down, column + right)]
                    passed += [at(row + down, column), at(row, column + right)] if diagonal else []
                    free = terrain[row][column] != 0 and set(passed) == {terrain[row][column]}
                    if (down, right) != (0, 0) and free and (not diagonal or neighbours == 8):
                        target = f"r{row + down}c{column + right}"
                        found.add((f"r{row}c{column}", target, Fraction(7, 5) if diagonal else Fraction(1)))
    return found


@given(
    st.integers(1, 6).flatmap(
        lambda columns: st.lists(
            st.lists(st.integers(0, 2), min_size=columns, max_size=columns), min_size=1, max_size=6
        )
    ),
    st.sampled_from([4, 8]),
)
def test_moves_are_those_of_the_rule(terrain: list[list[int]], neighbours: int) -> None:
    if not any(map(any, terrain)):
        return
    workspace = on_terrain(
        np.array(terrain, dtype=np.uint8),
        neighbours=neighbours,
        diagonal_time="1.4" if neighbours == 8 else None,
    )
    assert moves_of(workspace) == slow_moves(terrain, neighbours)
    assert len(moves_of(workspace)) == workspace.move_count
    order = list(zip(workspace.source.tolist(), workspace.target.tolist(), strict=True))
    assert order == sorted(order)
    for array in (workspace.source, workspace.target, workspace.least, workspace.most, workspace.label_of):
        assert array.dtype == np.int32


def test_a_small_grid_whole() -> None:
    workspace = grid(2, 3, move_time="1/2", waiting=True, blocked=[[0, 1]], regions={"A": [[1, 2]]})
    assert list(workspace.names) == ["r0c0", "r0c2", "r1c0", "r1c1", "r1c2"]
    assert [workspace.names[cell] for cell in range(5) if workspace.holds(cell)] == ["r1c2"]
    assert moves_of(workspace) == {
        (origin, target, Fraction(1, 2))
        for one, other in [("r0c0", "r1c0"), ("r0c2", "r1c2"), ("r1c0", "r1c1"), ("r1c1", "r1c2")]
        for origin, target in [(one, other), (other, one)]
    }
    assert workspace.waiting


def test_positions_have_x_to_the_right_and_y_up() -> None:
    workspace = grid(2, 3, blocked=[[0, 0]])
    assert workspace.positions is not None
    assert workspace.sizes is not None
    assert workspace.names[0] == "r0c1"
    assert workspace.positions[0].tolist() == [1.5, 1.5]
    assert workspace.positions[workspace.index_of("r1c0")].tolist() == [0.5, 0.5]
    assert workspace.sizes.tolist() == [[1.0, 1.0]] * 5


def test_a_range_of_time_and_any_time() -> None:
    ranged = grid(1, 2, move_time=["1", "3/2"])
    assert (ranged.least_time(0), ranged.most_time(0)) == (Fraction(1), Fraction(3, 2))
    free = grid(1, 2, move_time=0)
    assert (free.least_time(0), free.most_time(0)) == (Fraction(0), None)


def test_regions_mix_cells_and_boxes_and_overlap() -> None:
    workspace = grid(
        3,
        3,
        blocked=[[1, 1]],
        regions={
            "wall": Box((0, 2), (1, 1)),
            "corner": [[0, 0], Box((2, 2), (1, 2))],
            "all": Box((0, 2), (0, 2)),
        },
    )
    held = {workspace.names[cell]: "".join(sorted(n[0] for n in workspace.holds(cell))) for cell in range(8)}
    assert held == {
        "r0c0": "ac",
        "r0c1": "aw",
        "r0c2": "a",
        "r1c0": "a",
        "r1c2": "a",
        "r2c0": "a",
        "r2c1": "acw",
        "r2c2": "ac",
    }
    # Only the sets that occur are kept: the empty one does not.
    assert frozenset() not in workspace.label_sets
    assert len(workspace.label_sets) == 4


def test_many_regions_share_a_cell() -> None:
    names = [f"p{number}" for number in range(200)]
    workspace = grid(1, 2, regions={name: [[0, 1]] for name in names})
    assert workspace.holds(1) == set(names)
    assert workspace.holds(0) == frozenset()


@pytest.mark.parametrize(
    ("arguments", "message", "where"),
    [
        ({"rows": 0}, "a map of 0 rows and 3 columns has no cell", ()),
        (
            {"rows": 2_000_000},
            "a map of 2000000 rows and 3 columns is too large; at most 4000000 cells are read",
            (),
        ),
        ({"blocked": [Box((0, 1), (0, 2))]}, "every cell of the map is blocked", ()),
        (
            {"blocked": [[0, 0], [0, 3]]},
            "blocked: column 3 is outside the map, whose columns are 0 to 2",
            ("blocked", 1),
        ),
        (
            {"regions": {"A": [[0, 0], [2, 0]]}},
            "the region A: row 2 is outside the map, whose rows are 0 to 1",
            ("regions", "A", 1),
        ),
        (
            {"regions": {"A": [[-1, 0]]}},
            "the region A: row -1 is outside the map, whose rows are 0 to 1",
            ("regions", "A", 0),
        ),
        (
            {"regions": {"A": [[0, 1]]}, "blocked": [[0, 1]]},
            "the region A: the cell [0, 1] is blocked; cells are [row, column]",
            ("regions", "A", 0),
        ),
        (
            {"regions": {"A": Box((0, 0), (1, 1))}, "blocked": [[0, 1]]},
            "the region A has no free cell",
            ("regions", "A"),
        ),
        ({"regions": {"A": []}}, "the region A has no free cell", ("regions", "A")),
        (
            {"regions": {"A": Box((0, 0), (2, 1))}},
            "the region A: the columns [2, 1] hold nothing; write the lower one first",
            ("regions", "A"),
        ),
        (
            {"regions": {"A": [[0, 0, 0]]}},
            "the region A: a cell is [row, column], two numbers, not 3",
            ("regions", "A", 0),
        ),
        ({"neighbours": 6}, "neighbours is 4 or 8, not 6", ("neighbours",)),
        (
            {"neighbours": 8},
            "neighbours: 8 needs a diagonal_time, for example 1.414 with a move_time of 1",
            ("neighbours",),
        ),
        (
            {"diagonal_time": 2},
            "diagonal_time needs neighbours: 8; with 4 there is no diagonal move",
            ("diagonal_time",),
        ),
        (
            {"move_time": "fast"},
            "the time of a move: 'fast' is not a number; write one such as 5, 2.5 or 7/2",
            ("move_time",),
        ),
    ],
)
def test_refused(arguments: dict[str, object], message: str, where: tuple[str | int, ...]) -> None:
    with pytest.raises(WorkspaceError) as caught:
        grid(**{"rows": 2, "columns": 3, **arguments})  # type: ignore[arg-type]
    assert str(caught.value) == message
    assert caught.value.where == where


def test_a_large_grid_is_built_at_once() -> None:
    regions = {"A": Box((0, 511), (0, 200)), "B": Box((100, 200), (100, 511)), "C": [[511, 511]]}
    started = time.perf_counter()
    workspace = grid(512, 512, blocked=[[7, 7]], regions=regions)
    seconds = time.perf_counter() - started
    assert workspace.cell_count == 512 * 512 - 1
    assert workspace.move_count == 4 * 512 * 511 - 8
    assert workspace.index_of("r511c511") == 512 * 512 - 2
    assert seconds < 0.5
