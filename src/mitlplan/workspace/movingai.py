"""Maps of the MovingAI benchmarks (N. R. Sturtevant, IEEE TCIAIG 4(2), 2012).

The format: ``type octile``, ``height``, ``width``, ``map``, then a letter a cell, the upper left one first.
``.`` and ``G`` are ground, ``S`` swamp, passable from ground, so of the same terrain here; ``@``, ``O`` and
``T`` are blocked. ``W`` is water, which the format calls "traversable, but not passable from terrain": it is
read as a terrain of its own, with moves from water to water and none between water and land either way.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mitlplan.errors import WorkspaceError
from mitlplan.workspace.grid import BLOCKED, MOST_CELLS, check_size, on_terrain
from mitlplan.workspace.move_time import MoveTime
from mitlplan.workspace.regions import Region
from mitlplan.workspace.workspace import Workspace

_GROUND, _WATER, _UNKNOWN = 1, 2, 255
_TERRAIN = np.full(256, _UNKNOWN, dtype=np.uint8)
_TERRAIN[list(b".GS")] = _GROUND
_TERRAIN[list(b"W")] = _WATER
_TERRAIN[list(b"@OT")] = BLOCKED

# A map of the greatest size, each line ended by two characters, and its header.
_MOST_BYTES = 3 * MOST_CELLS + 1000


def movingai(
    file: str | Path,
    *,
    move_time: MoveTime = 1,
    waiting: bool = False,
    regions: Mapping[str, Region] | None = None,
    neighbours: int = 4,
    diagonal_time: MoveTime | None = None,
) -> Workspace:
    """The workspace of a MovingAI ``.map`` file.

    Parameters
    ----------
    file
        Where the map is.
    move_time, waiting, regions, neighbours, diagonal_time
        As in :func:`mitlplan.workspace.grid.grid`; regions are given as ``[row, column]``.

    Raises
    ------
    WorkspaceError
        If the file cannot be read or is no such map, with the line; or as for a grid.
    """
    terrain = read_terrain(Path(file))
    return on_terrain(
        terrain,
        move_time=move_time,
        waiting=waiting,
        regions=regions,
        neighbours=neighbours,
        diagonal_time=diagonal_time,
    )


def read_terrain(file: Path) -> NDArray[np.uint8]:
    """The terrain of each cell of a map file: 0 blocked, 1 ground, 2 water.

    Raises
    ------
    WorkspaceError
        If the file cannot be read or is no MovingAI map, with the line.
    """
    lines = _read(file).splitlines()
    rows, columns = _header(lines, file)
    body = lines[4 : 4 + rows]
    if len(body) < rows:
        raise _fault(file, len(lines), f"the map ends after {len(body)} of {rows} rows")
    for number, line in enumerate(lines[4 + rows :], start=5 + rows):
        if line.strip():
            raise _fault(file, number, f"there is more after the last of {rows} rows")
    for number, line in enumerate(body, start=5):
        if len(line) != columns:
            raise _fault(file, number, f"this row has {len(line)} cells where the width is {columns}")
    letters = np.frombuffer(b"".join(body), dtype=np.uint8).reshape(rows, columns)
    terrain = _TERRAIN[letters]
    for row, column in np.argwhere(terrain == _UNKNOWN)[:1]:
        letter = chr(letters[row, column])
        raise _fault(
            file, row + 5, f"{letter!r} in column {column} is no terrain; the letters are . G S W @ O T"
        )
    return terrain


def _read(file: Path) -> bytes:
    try:
        with file.open("rb") as stream:
            content = stream.read(_MOST_BYTES + 1)
    except OSError as error:
        raise WorkspaceError(f"cannot read the map {file}: {error.strerror}", where=("file",)) from None
    if len(content) > _MOST_BYTES:
        raise WorkspaceError(
            f"the map {file} is too large; at most {MOST_CELLS} cells are read", where=("file",)
        )
    return content


def _header(lines: list[bytes], file: Path) -> tuple[int, int]:
    header = [line.split() for line in lines[:4]]
    if len(header) < 4 or header[0] != [b"type", b"octile"]:
        raise _fault(file, 1, "this is no MovingAI map, which begins with 'type octile'")
    sizes = []
    for number, key in ((1, b"height"), (2, b"width")):
        match header[number]:
            case [found, size] if found == key and size.isdigit() and len(size) < 8:
                sizes.append(int(size))
            case _:
                raise _fault(file, number + 1, f"'{key.decode()} N' is expected here, N a whole number")
    if header[3] != [b"map"]:
        raise _fault(file, 4, "'map' is expected here")
    check_size(sizes[0], sizes[1])
    return sizes[0], sizes[1]


def _fault(file: Path, line: int, problem: str) -> WorkspaceError:
    return WorkspaceError(f"{file}, line {line}: {problem}", where=("file",))
