"""A large map with few cells that matter, as a small one.

Where the robot may wait, a way through cells that look alike is worth no more than the least time it takes.
So only *key* cells are kept: those that do not look like most, and the starts. Whatever else the robot does
between two of them becomes a stay in one cell, the *corridor* behind the key cell that it left. The shortest
ways are found breadth-first, hence every move must take the same least time.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from mitlplan.workspace.names import ListedNames
from mitlplan.workspace.workspace import UNLIMITED, Workspace

MOST_MOVES = 200_000
"""Of the small workspace."""

MOST_CELL_VISITS = 20_000_000
"""Key cells times cells: each key cell is the goal of a search through all plain cells."""

UNREACHED = -1

PlannedStay = tuple[int, Fraction]
"""A cell, and how long the robot stays in it, in seconds."""


@dataclass(frozen=True, eq=False)
class Compressed:
    """A small workspace that stands for a large one.

    Parameters
    ----------
    workspace
        The key cells in their order, then the corridors.
    starts
        The cells of `workspace` in which the robot may start.
    """

    workspace: Workspace
    starts: tuple[int, ...]
    _plain_ways: _PlainWays

    def expand(self, stays: Sequence[PlannedStay], then: int | None = None) -> list[PlannedStay]:
        """The stays in cells of the large workspace that show the same for as long.

        A corridor becomes a shortest way to the key cell after it; the time to spare is waited in the first
        cell of the way, so that ways to the same key cell end alike. To stay in a corridor is to stay in a
        first cell.

        Parameters
        ----------
        stays
            As a robot in the small workspace may go.
        then
            The cell that follows the last stay; ``None`` if none does.
        """
        following = [*(cell for cell, _ in stays), then][1:]
        return [
            stay
            for (cell, duration), after in zip(stays, following, strict=True)
            for stay in self._plain_ways.expand(cell, duration, after)
        ]


@dataclass(frozen=True, eq=False)
class _PlainWays:
    """The ways through plain cells.

    Parameters
    ----------
    keys
        The key cells.
    owners
        The key cells from which a plain cell can be entered; each has a corridor, in this order.
    entries
        For each owner the plain cells next to it.
    backwards
        From the target of each move out of a plain cell to that cell.
    move_time
        What each move takes at least, in seconds.
    known
        The ways through a corridor to a key cell that were looked for before.
    """

    keys: NDArray[np.intp]
    owners: NDArray[np.intp]
    entries: tuple[NDArray[np.int32], ...]
    backwards: csr_array
    move_time: Fraction
    known: dict[tuple[int, int], list[int]] = field(default_factory=dict)

    def expand(self, cell: int, duration: Fraction, after: int | None) -> Iterator[PlannedStay]:
        if cell < len(self.keys):
            yield int(self.keys[cell]), duration
            return
        corridor = cell - len(self.keys)
        if after is None:
            way = [int(self.entries[corridor][0])]
        elif (corridor, after) in self.known:
            way = self.known[corridor, after]
        else:
            way = self.known[corridor, after] = self.way(corridor, int(self.keys[after]))
        for later, through in enumerate(way):
            yield through, self.move_time if later else duration - (len(way) - 1) * self.move_time

    def way(self, corridor: int, goal: int) -> list[int]:
        """The plain cells of a shortest way to a key cell."""
        entries = self.entries[corridor]
        moves, towards = self.to(goal)
        reached = entries[moves[entries] != UNREACHED]
        at = int(reached[np.argmin(moves[reached])])
        way = []
        while at != goal:
            way.append(at)
            at = int(towards[at])
        return way

    def to(self, goal: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The number of moves from each plain cell through plain cells to `goal`, and the first of them."""
        backwards: Any = self.backwards  # the stubs of some releases do not know that it is two-dimensional
        order, towards = breadth_first_order(backwards, goal)
        place = np.empty(len(towards), dtype=np.int64)
        place[order] = np.arange(len(order))
        parents = place[towards[order[1:]]]
        moves = np.full(len(towards), UNREACHED, dtype=np.int32)
        # The cells of one distance stand together, and their children behind them.
        begin, end, distance = 0, 1, 0
        while begin < end:
            moves[order[begin:end]] = distance
            begin, end = end, int(np.searchsorted(parents, end)) + 1
            distance += 1
        return moves, towards


def compress(
    workspace: Workspace, label_class: NDArray[np.integer], starts: Sequence[int]
) -> Compressed | None:
    """A small workspace in which the robot can show the same at the same times, if it pays to make one.

    Exact: the least stay in a corridor is the least time through plain cells alone, from any of those next to
    its key cell to the next key cell. So every walk of the robot, its plain cells put together, is a walk of
    the small workspace, with the same key cells at the same times. The expansion of a small walk in turn is a
    walk of the robot, for what it stays longer than the least time it may wait. In between, both show the
    plain label. Only for a loop through plain cells alone there is none in the small workspace: there the
    robot may park.

    Parameters
    ----------
    workspace
        Waiting must be allowed, and all moves take the same least time.
    label_class
        Shape (cells,): cells of the same class need not be told apart.
    starts
        Cells that are kept whatever they look like.

    Examples
    --------
    >>> from mitlplan.workspace import grid
    >>> large = grid(9, 9, waiting=True, regions={"A": [(0, 0)], "B": [(8, 8)]})
    >>> small = compress(large, large.label_of, [0])
    >>> small.workspace.cell_count, small.workspace.durations
    (4, (Fraction(1, 1), Fraction(15, 1)))
    """
    move_time = _move_time(workspace)
    if move_time is None:
        return None
    plain = label_class == np.argmax(np.bincount(label_class))
    plain[list(starts)] = False
    keys = np.flatnonzero(~plain)
    if len(keys) * workspace.cell_count > MOST_CELL_VISITS or not plain.any():
        return None
    ways = _ways(workspace, plain, keys, move_time)
    if len(keys) + len(ways.owners) >= workspace.cell_count:
        return None
    number = np.full(workspace.cell_count, UNREACHED)
    number[keys] = np.arange(len(keys))
    moves = _small_moves(workspace, ways, number)
    if moves is None:
        return None
    label_of = np.append(
        workspace.label_of[keys], np.full(len(ways.owners), workspace.label_of[np.argmax(plain)])
    )
    small = _small_workspace(workspace, ways, label_of, moves)
    return Compressed(small, tuple(int(number[start]) for start in starts), ways)


def look_alike(workspace: Workspace, told_apart: Iterable[Collection[int]]) -> NDArray[np.intp]:
    """A class for each cell, the same for cells that none of some sets of labels tells apart.

    Parameters
    ----------
    told_apart
        Each a set of indices into ``workspace.label_sets``.

    Examples
    --------
    >>> from mitlplan.workspace import grid
    >>> hall = grid(1, 3, regions={"A": [(0, 0)], "B": [(0, 1)]})
    >>> look_alike(hall, [{hall.label_of[0]}]).tolist()
    [1, 0, 0]
    """
    labels = range(len(workspace.label_sets))
    rows = [[label in where for label in labels] for where in told_apart]
    _, classes = np.unique(np.array(rows).reshape(-1, len(labels)), axis=1, return_inverse=True)
    looks: NDArray[np.intp] = classes.reshape(-1)[workspace.label_of]
    return looks


def _move_time(workspace: Workspace) -> Fraction | None:
    """The least time of every move, if the robot may wait and it is the same for all and positive."""
    least = workspace.least
    if not workspace.waiting or len(least) == 0 or least.min() != least.max():
        return None
    time = workspace.durations[int(least[0])]
    return time if time > 0 else None


def _ways(
    workspace: Workspace, plain: NDArray[np.bool_], keys: NDArray[np.intp], move_time: Fraction
) -> _PlainWays:
    source, target = workspace.source, workspace.target
    enters = ~plain[source] & plain[target]
    owners, first = np.unique(source[enters], return_index=True)
    leaves = plain[source]
    ends = (np.ones(int(leaves.sum()), dtype=np.int8), (target[leaves], source[leaves]))
    return _PlainWays(
        keys=keys,
        owners=owners.astype(np.intp),
        entries=tuple(np.split(target[enters], first[1:])) if len(owners) else (),
        backwards=csr_array(ends, shape=(workspace.cell_count, workspace.cell_count)),
        move_time=move_time,
    )


def _small_moves(
    workspace: Workspace, ways: _PlainWays, number: NDArray[np.integer]
) -> NDArray[np.int64] | None:
    """Rows of source, target and least number of moves, sorted; ``None`` if there are too many."""
    between = (number[workspace.source] != UNREACHED) & (number[workspace.target] != UNREACHED)
    direct = np.stack([number[workspace.source[between]], number[workspace.target[between]]], axis=1)
    corridors = len(ways.keys) + np.arange(len(ways.owners))
    blocks = [
        np.insert(np.unique(direct, axis=0), 2, 1, axis=1),
        np.stack([number[ways.owners], corridors, np.ones_like(corridors)], axis=1),
    ]
    goals = ways.keys[np.diff(ways.backwards.indptr)[ways.keys] > 0] if len(ways.owners) else ways.keys[:0]
    all_entries = np.concatenate([ways.keys[:0], *ways.entries])
    first = np.cumsum([0, *(len(entries) for entries in ways.entries[:-1])])
    count = sum(map(len, blocks))
    for goal in goals.tolist():
        moves, _ = ways.to(goal)
        # Unreached is -1: as an unsigned number it is larger than every other.
        nearest = np.minimum.reduceat(moves[all_entries].astype(np.uint32), first).astype(np.int32)
        reached = nearest != UNREACHED
        same_goal = np.full(int(reached.sum()), number[goal])
        blocks.append(np.stack([corridors[reached], same_goal, nearest[reached]], axis=1))
        count += len(same_goal)
        if count > MOST_MOVES:
            return None
    rows = np.concatenate(blocks)
    ordered: NDArray[np.int64] = rows[np.lexsort((rows[:, 1], rows[:, 0]))]
    return ordered


def _small_workspace(
    workspace: Workspace, ways: _PlainWays, label_of: NDArray[np.int32], moves: NDArray[np.int64]
) -> Workspace:
    counts, which = np.unique(moves[:, 2], return_inverse=True)
    names = [workspace.names[cell] for cell in ways.keys.tolist()]
    names += [f"behind {workspace.names[cell]}" for cell in ways.owners.tolist()]
    return Workspace(
        names=ListedNames(tuple(names)),
        label_sets=workspace.label_sets,
        label_of=label_of.astype(np.int32),
        source=moves[:, 0].astype(np.int32),
        target=moves[:, 1].astype(np.int32),
        durations=tuple(count * ways.move_time for count in counts.tolist()),
        least=which.reshape(-1).astype(np.int32),
        most=np.full(len(moves), UNLIMITED, dtype=np.int32),
        waiting=True,
    )
