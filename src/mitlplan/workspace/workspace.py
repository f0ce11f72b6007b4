"""The robot's world: cells, the moves between them with their times, and what holds in each cell.

Maps have up to hundreds of thousands of cells, so a workspace is a few flat arrays rather than an object a
cell. Times stay exact: the arrays hold indices into a short tuple of the distinct travel times.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from mitlplan.errors import WorkspaceError
from mitlplan.workspace.names import GridNames, ListedNames, advise

UNLIMITED = -1
"""In ``Workspace.most``: the move may be put off for ever."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """Cells and the directed moves between them.

    A move from c to d with times ``[least, most]`` is made after a stay in c of such a length. A least time
    of 0 asks only for a positive stay. Where `waiting` is allowed a stay may be longer than `most`.

    Parameters
    ----------
    names
        The cells' names, all different, shape (cells,).
    label_sets
        The distinct sets of propositions that occur; ``label_sets[label_of[c]]`` holds in cell c.
    label_of
        int32, shape (cells,).
    source, target
        int32, shape (moves,): the moves, sorted by source and then target.
    durations
        The distinct travel times, in seconds.
    least, most
        int32, shape (moves,): indices into `durations`; `most` may be ``UNLIMITED``.
    waiting
        Whether the robot may stay in a cell longer than its next move needs.
    positions
        float64, shape (cells, 2): centre of each cell as x to the right and y up, in metres (or cells where
        the map has no unit). For pictures and trajectories only. ``None`` where the map is no geometry.
    sizes
        float64, shape (cells, 2): width and height of each cell, as `positions`.
    """

    names: Sequence[str]
    label_sets: tuple[frozenset[str], ...]
    label_of: NDArray[np.int32]
    source: NDArray[np.int32]
    target: NDArray[np.int32]
    durations: tuple[Fraction, ...]
    least: NDArray[np.int32]
    most: NDArray[np.int32]
    waiting: bool
    positions: NDArray[np.float64] | None = None
    sizes: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        if len(self.label_of) != len(self.names):
            raise WorkspaceError("every cell needs a label")
        if len(self.names) == 0:
            raise WorkspaceError("the workspace has no cell")

    @property
    def cell_count(self) -> int:
        """The number of cells."""
        return len(self.names)

    @property
    def move_count(self) -> int:
        """The number of directed moves."""
        return len(self.source)

    @property
    def propositions(self) -> frozenset[str]:
        """Every proposition that holds in some cell."""
        return frozenset().union(*self.label_sets)

    def holds(self, cell: int) -> frozenset[str]:
        """The propositions of `cell`."""
        return self.label_sets[int(self.label_of[cell])]

    def index_of(self, name: str) -> int | None:
        """The index of the cell called `name`, or ``None`` if there is none."""
        match self.names:
            case ListedNames() | GridNames() as names:
                return names.find(name)
            case plain:
                return plain.index(name) if name in plain else None

    def advise(self, name: str) -> str:
        """Which cells there are, for somebody who wrote `name` and meant one of them."""
        match self.names:
            case ListedNames() | GridNames() as names:
                return names.advise(name)
            case plain:
                return advise(name, plain, "cells")

    def moves_from(self, cell: int) -> range:
        """The indices of the moves that leave `cell`."""
        # Of the same type as the sources, lest all of them be converted at every call.
        first, last = self.source.searchsorted(np.array((cell, cell + 1), dtype=self.source.dtype))
        return range(int(first), int(last))

    def moves_along(self, cells: Sequence[int]) -> list[range]:
        """For each cell but the last the indices of the moves to the next one; none from what is no cell."""
        here = np.array(cells[:-1], dtype=self.source.dtype)
        firsts = self.source.searchsorted(here).tolist()
        lasts = self.source.searchsorted(here, side="right").tolist()
        ways = []
        for first, last, onward in zip(firsts, lasts, cells[1:], strict=True):
            targets = self.target[first:last].tolist()
            ways.append(range(first + bisect_left(targets, onward), first + bisect_right(targets, onward)))
        return ways

    def least_time(self, move: int) -> Fraction:
        """The least time that `move` takes, in seconds."""
        return self.durations[int(self.least[move])]

    def most_time(self, move: int) -> Fraction | None:
        """The longest time that `move` may take, waiting aside; ``None`` is unlimited."""
        index = int(self.most[move])
        return None if index == UNLIMITED else self.durations[index]
