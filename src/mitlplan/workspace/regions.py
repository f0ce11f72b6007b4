"""Regions of grid-like maps: which cells carry which propositions.

A region is a list of cells and boxes. A cell that is named must be on the map and free, since a blocked one
is surely a slip (often row and column swapped); a box may cover blocked cells: only its free cells count.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan.errors import WorkspaceError


@dataclass(frozen=True, slots=True)
class Box:
    """The cells of the given rows and columns, both ends included.

    Examples
    --------
    >>> Box(rows=(0, 3), columns=(2, 2))
    Box(rows=(0, 3), columns=(2, 2))
    """

    rows: tuple[int, int]
    columns: tuple[int, int]


Part: TypeAlias = Box | Sequence[int]
"""A box, or a cell as ``[row, column]``."""

Region: TypeAlias = Box | Sequence[Part]
"""A box, or a list of cells and boxes."""


def parts_of(region: Region) -> Sequence[Part]:
    """The cells and boxes of `region`."""
    return (region,) if isinstance(region, Box) else region


def cover(part: Part, shape: tuple[int, int]) -> tuple[slice, slice]:
    """The rows and columns that `part` covers.

    Raises
    ------
    WorkspaceError
        If it is not wholly on a map of this shape, or is no cell and no box.

    Examples
    --------
    >>> cover(Box(rows=(0, 1), columns=(2, 2)), (3, 3))
    (slice(0, 2, None), slice(2, 3, None))
    """
    if isinstance(part, Box):
        return _stretch(part.rows, shape[0], "row"), _stretch(part.columns, shape[1], "column")
    if len(part) != 2:
        raise WorkspaceError(f"a cell is [row, column], two numbers, not {len(part)}")
    row, column = part
    return _stretch((row, row), shape[0], "row"), _stretch((column, column), shape[1], "column")


def _stretch(ends: tuple[int, int], size: int, kind: str) -> slice:
    first, last = ends
    if last < first:
        raise WorkspaceError(f"the {kind}s [{first}, {last}] hold nothing; write the lower one first")
    for end in ends:
        if not 0 <= end < size:
            raise WorkspaceError(f"{kind} {end} is outside the map, whose {kind}s are 0 to {size - 1}")
    return slice(first, last + 1)


def label_cells(
    regions: Mapping[str, Region], number: NDArray[np.int32]
) -> tuple[tuple[frozenset[str], ...], NDArray[np.int32]]:
    """The distinct sets of propositions that occur, and the index of each cell's set.

    Parameters
    ----------
    regions
        A region for each proposition.
    number
        int32, shape (rows, columns): the index of each free cell, -1 where blocked.

    Raises
    ------
    WorkspaceError
        If a region leaves the map, names a blocked cell or has no free cell.

    Examples
    --------
    >>> label_cells({"A": [[0, 1]]}, np.array([[0, 1]], dtype=np.int32))
    ((frozenset(), frozenset({'A'})), array([0, 1], dtype=int32))
    """
    indices: dict[frozenset[str], int] = {frozenset(): 0}
    label_of = np.zeros(int(number.max()) + 1, dtype=np.int32)
    for name, region in regions.items():
        cells = _cells(name, region, number)
        labels = label_of[cells]
        known = list(indices)
        for old in np.unique(labels):
            new = indices.setdefault(known[old] | {name}, len(indices))
            label_of[cells[labels == old]] = new
    used = np.flatnonzero(np.bincount(label_of, minlength=len(indices)))
    sets = list(indices)
    renumbered = np.zeros(len(sets), dtype=np.int32)
    renumbered[used] = np.arange(len(used))
    return tuple(sets[index] for index in used), renumbered[label_of]


def _cells(name: str, region: Region, number: NDArray[np.int32]) -> NDArray[np.int32]:
    found: list[NDArray[np.int32]] = [np.zeros(0, dtype=np.int32)]
    parts = parts_of(region)
    for place, part in enumerate(parts):
        where = ("regions", name) if isinstance(region, Box) else ("regions", name, place)
        try:
            rows, columns = cover(part, (number.shape[0], number.shape[1]))
        except WorkspaceError as error:
            raise WorkspaceError(f"the region {name}: {error}", where=where) from None
        covered = number[rows, columns].ravel()
        if not isinstance(part, Box) and covered[0] < 0:
            raise WorkspaceError(
                f"the region {name}: the cell {list(part)} is blocked; cells are [row, column]", where=where
            )
        found.append(covered[covered >= 0])
    cells = np.concatenate(found)
    if len(cells) == 0:
        raise WorkspaceError(f"the region {name} has no free cell", where=("regions", name))
    return cells
