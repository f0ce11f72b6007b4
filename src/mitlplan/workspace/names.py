"""The names of cells, and the way back from a name to its index.

A grid of half a million cells has a name for each without half a million strings: a grid's names are computed
when they are asked for. Both kinds find the index of a name without looking through all of them.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import overload

import numpy as np
from numpy.typing import NDArray

_GRID_NAME = re.compile(r"r(0|[1-9]\d{0,8})c(0|[1-9]\d{0,8})", re.ASCII)
_MOST_COMPARED = 5000
_LONGEST_COMPARED = 500


class ListedNames(Sequence[str]):
    """Names that were given one by one.

    Examples
    --------
    >>> ListedNames(["dock", "hall"]).find("hall")
    1
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._index = {name: index for index, name in enumerate(self._names)}

    def __len__(self) -> int:
        return len(self._names)

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[str, ...]: ...
    def __getitem__(self, index: int | slice) -> str | tuple[str, ...]:
        return self._names[index]

    def find(self, name: str) -> int | None:
        """The index of `name`, or ``None`` if no cell is called so."""
        return self._index.get(name)

    def advise(self, name: str) -> str:
        """The closest names, or some of them all."""
        return advise(name, self._names, "cells")


@dataclass(frozen=True, eq=False)
class GridNames(Sequence[str]):
    """Names ``r{row}c{column}`` of the free cells of a grid.

    Parameters
    ----------
    shape
        Rows and columns.
    place
        int64, shape (cells,): ``row * columns + column`` of each free cell, ascending.

    Examples
    --------
    >>> names = GridNames((2, 2), np.array([0, 1, 3]))
    >>> names[2], names.find("r1c1"), names.find("r1c0")
    ('r1c1', 2, None)
    """

    shape: tuple[int, int]
    place: NDArray[np.int64] = field(repr=False)

    def __len__(self) -> int:
        return len(self.place)

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> GridNames: ...
    def __getitem__(self, index: int | slice) -> str | GridNames:
        if isinstance(index, slice):
            return GridNames(self.shape, self.place[index])
        row, column = divmod(int(self.place[index]), self.shape[1])
        return f"r{row}c{column}"

    def find(self, name: str) -> int | None:
        """The index of `name`, or ``None`` if no free cell is called so."""
        match = _GRID_NAME.fullmatch(name)
        return None if match is None else self.at(int(match[1]), int(match[2]))

    def at(self, row: int, column: int) -> int | None:
        """The index of the cell at `row` and `column`, or ``None`` if it is blocked or outside the map."""
        rows, columns = self.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return None
        place = row * columns + column
        index = int(self.place.searchsorted(place))
        return index if index < len(self.place) and self.place[index] == place else None

    def advise(self, name: str) -> str:
        """What the names of this grid look like, and whether `name` is a blocked cell."""
        rows, columns = self.shape
        match = _GRID_NAME.fullmatch(name)
        if match is not None and int(match[1]) < rows and int(match[2]) < columns:
            return "that cell is blocked"
        return f"cells are r0c0 to r{rows - 1}c{columns - 1}, row first, counted from the top left"


def advise(name: str, known: Sequence[str], kind: str) -> str:
    """A suggestion for somebody who wrote `name` where one of `known` was meant.

    Examples
    --------
    >>> advise("dok", ["dock", "hall"], "cells")
    'did you mean dock?'
    >>> advise("x", ["dock", "hall"], "cells")
    'the cells are dock, hall'
    """
    # With a name of megabytes, comparing takes minutes and gigabytes.
    compared = known[:_MOST_COMPARED] if len(name) <= _LONGEST_COMPARED else ()
    close = difflib.get_close_matches(name[:_LONGEST_COMPARED], compared, n=3, cutoff=0.6)
    if close:
        return f"did you mean {' or '.join(close)}?"
    if not known:
        return f"there are no {kind}"
    more = f" and {len(known) - 10} more" if len(known) > 10 else ""
    return f"the {kind} are {', '.join(known[:10])}{more}"
