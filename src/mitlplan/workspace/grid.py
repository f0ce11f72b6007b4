"""Grids: square cells in rows and columns, some of them blocked.

Cells are called ``r{row}c{column}``, row 0 at the top; a blocked cell is no cell of the workspace at all, but
the others keep their names. A grid is a matrix of terrain: moves join neighbours of the same terrain, so that
one construction serves plain grids and maps with water. Everything is done on whole arrays at once, for maps
of hundreds of thousands of cells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from mitlplan.errors import WorkspaceError
from mitlplan.workspace.move_time import MoveTime, stay_bounds
from mitlplan.workspace.names import GridNames
from mitlplan.workspace.regions import Part, Region, cover, label_cells
from mitlplan.workspace.workspace import UNLIMITED, Workspace

BLOCKED = 0
"""The terrain of a cell that nobody enters."""

MOST_CELLS = 4_000_000
"""Larger maps are refused before anything is allocated for them."""

# Row and column steps in the order of the cell they lead to, so that the moves come out sorted.
_STRAIGHT = ((-1, 0), (0, -1), (0, 1), (1, 0))
_ALL_AROUND = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))


def grid(
    rows: int,
    columns: int,
    *,
    move_time: MoveTime = 1,
    waiting: bool = False,
    blocked: Sequence[Part] = (),
    regions: Mapping[str, Region] | None = None,
    neighbours: int = 4,
    diagonal_time: MoveTime | None = None,
) -> Workspace:
    """A grid of square cells.

    Parameters
    ----------
    rows, columns
        The size of the grid.
    move_time
        Seconds that a move to a neighbour takes: exact, or ``[least, most]``; 0 is any positive stay.
    waiting
        Whether the robot may stay in a cell longer than its next move needs.
    blocked
        Cells ``[row, column]`` and boxes that nobody enters.
    regions
        For each proposition the cells and boxes that carry it.
    neighbours
        4, or 8 for diagonal moves as well; these take `diagonal_time` and do not cut corners: both cells
        beside the move must be free.
    diagonal_time
        As `move_time`; must be given with 8 neighbours, since no rational number is the square root of 2.

    Raises
    ------
    WorkspaceError
        If something lies outside the grid, a region has no free cell, or a time is no time.

    Examples
    --------
    >>> workspace = grid(2, 2, regions={"A": [(1, 0)], "B": [(0, 1)]})
    >>> list(workspace.names), workspace.move_count
    (['r0c0', 'r0c1', 'r1c0', 'r1c1'], 8)
    """
    check_size(rows, columns)
    terrain = np.ones((rows, columns), dtype=np.uint8)
    for place, part in enumerate(blocked):
        try:
            terrain[cover(part, (rows, columns))] = BLOCKED
        except WorkspaceError as error:
            raise WorkspaceError(f"blocked: {error}", where=("blocked", place)) from None
    return on_terrain(
        terrain,
        move_time=move_time,
        waiting=waiting,
        regions=regions,
        neighbours=neighbours,
        diagonal_time=diagonal_time,
    )


def check_size(rows: int, columns: int) -> None:
    """Refuse a map without cells, or with more than :data:`MOST_CELLS`.

    Raises
    ------
    WorkspaceError
        With the size in the sentence.
    """
    if rows < 1 or columns < 1:
        raise WorkspaceError(f"a map of {rows} rows and {columns} columns has no cell")
    if rows * columns > MOST_CELLS:
        raise WorkspaceError(
            f"a map of {rows} rows and {columns} columns is too large; at most {MOST_CELLS} cells are read"
        )


def on_terrain(
    terrain: NDArray[np.uint8],
    *,
    move_time: MoveTime = 1,
    waiting: bool = False,
    regions: Mapping[str, Region] | None = None,
    neighbours: int = 4,
    diagonal_time: MoveTime | None = None,
) -> Workspace:
    """The workspace of a matrix of terrain: moves join neighbours of the same terrain.

    Parameters
    ----------
    terrain
        uint8, shape (rows, columns): 0 where blocked, and any other number for a terrain of its own.
    move_time, waiting, regions, neighbours, diagonal_time
        As in :func:`grid`.

    Raises
    ------
    WorkspaceError
        As :func:`grid`.

    Examples
    --------
    >>> on_terrain(np.array([[1, 1, 2]], dtype=np.uint8)).move_count
    2
    """
    place = np.flatnonzero(terrain)
    if len(place) == 0:
        raise WorkspaceError("every cell of the map is blocked")
    number = np.full(terrain.shape, -1, dtype=np.int32)
    number.ravel()[place] = np.arange(len(place), dtype=np.int32)
    steps, step_kind, stays = _steps(move_time, neighbours, diagonal_time)
    allowed = np.stack([_allowed(terrain, step).ravel()[place] for step in steps], axis=1)
    source, direction = np.nonzero(allowed)
    offsets = np.array([down * terrain.shape[1] + right for down, right in steps])
    durations, least, most = _indexed(stays)
    kind = step_kind[direction]
    label_sets, label_of = label_cells(regions or {}, number)
    return Workspace(
        names=GridNames((terrain.shape[0], terrain.shape[1]), place),
        label_sets=label_sets,
        label_of=label_of,
        source=source.astype(np.int32),
        target=number.ravel()[place[source] + offsets[direction]],
        durations=durations,
        least=least[kind],
        most=most[kind],
        waiting=waiting,
        positions=_centres(place, terrain.shape),
        sizes=np.ones((len(place), 2)),
    )


_Stays = tuple[Fraction, Fraction | None]


def _steps(
    move_time: MoveTime, neighbours: int, diagonal_time: MoveTime | None
) -> tuple[tuple[tuple[int, int], ...], NDArray[np.int32], list[_Stays]]:
    """The directions, for each whether it is diagonal (0 or 1), and the stays of both kinds."""
    stays = [_stays(move_time, "move_time")]
    if neighbours == 4:
        if diagonal_time is not None:
            raise WorkspaceError(
                "diagonal_time needs neighbours: 8; with 4 there is no diagonal move",
                where=("diagonal_time",),
            )
        return _STRAIGHT, np.zeros(4, dtype=np.int32), stays
    if neighbours != 8:
        raise WorkspaceError(f"neighbours is 4 or 8, not {neighbours}", where=("neighbours",))
    if diagonal_time is None:
        raise WorkspaceError(
            "neighbours: 8 needs a diagonal_time, for example 1.414 with a move_time of 1",
            where=("neighbours",),
        )
    stays.append(_stays(diagonal_time, "diagonal_time"))
    diagonal = np.array([int(down != 0 and right != 0) for down, right in _ALL_AROUND], dtype=np.int32)
    return _ALL_AROUND, diagonal, stays


def _stays(time: MoveTime, key: str) -> _Stays:
    try:
        return stay_bounds(time)
    except WorkspaceError as error:
        raise WorkspaceError(str(error), where=(key,)) from None


def _indexed(stays: list[_Stays]) -> tuple[tuple[Fraction, ...], NDArray[np.int32], NDArray[np.int32]]:
    """The distinct times, and the indices of each kind's least and most among them."""
    times = {time for bounds in stays for time in bounds if time is not None}
    durations = tuple(sorted(times))
    least = [durations.index(low) for low, _ in stays]
    most = [UNLIMITED if high is None else durations.index(high) for _, high in stays]
    return durations, np.array(least, dtype=np.int32), np.array(most, dtype=np.int32)


def _allowed(terrain: NDArray[np.uint8], step: tuple[int, int]) -> NDArray[np.bool_]:
    """Where the step may be made: from free cells to the same terrain, past no corner."""
    down, right = step
    passed = [step] if down == 0 or right == 0 else [step, (down, 0), (0, right)]
    allowed: NDArray[np.bool_] = terrain != BLOCKED
    for offset in passed:
        allowed &= terrain == _shifted(terrain, offset)
    return allowed


def _shifted(terrain: NDArray[np.uint8], step: tuple[int, int]) -> NDArray[np.uint8]:
    """For each cell the terrain one step away; blocked beyond the border."""
    rows, columns = terrain.shape
    padded = np.pad(terrain, 1, constant_values=BLOCKED)
    return padded[1 + step[0] : 1 + step[0] + rows, 1 + step[1] : 1 + step[1] + columns]


def _centres(place: NDArray[np.int64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    row, column = np.divmod(place, shape[1])
    return np.stack([column + 0.5, shape[0] - row - 0.5], axis=1)
