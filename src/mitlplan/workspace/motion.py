"""What the robot's own motion makes of a workspace: where it crosses, and how long a move takes.

A robot on rectangular cells goes from one to the next through the middle of the edge they share (or, on a
diagonal move, through the corner), square to it. How long that takes depends on the robot, which is not known
here: somebody who knows it gives the times (:class:`TravelTimes`). Without headings a move is as slow as the
worst way of coming to it; with headings a cell becomes one location for each way of having entered it, and a
move is as slow as its own turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Protocol, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from mitlplan.errors import WorkspaceError
from mitlplan.workspace.names import ListedNames
from mitlplan.workspace.workspace import Workspace

Array: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int32]

_TOUCHING = 1e-9
_DIGITS = 9
COMPASS = ("east", "northeast", "north", "northwest", "west", "southwest", "south", "southeast")
"""The headings of moves: an eighth of a turn to the left from one to the next."""


def heading_of(text: str) -> float:
    """The heading that a text names, in radians.

    Raises
    ------
    ValueError
        If it is neither a number nor one of :data:`COMPASS`.

    Examples
    --------
    >>> heading_of("west") == math.pi, heading_of("-1.57")
    (True, -1.57)
    """
    if text in COMPASS:
        return COMPASS.index(text) * math.pi / 4
    try:
        heading = float(text)
    except ValueError:
        heading = math.nan
    if not math.isfinite(heading):
        raise ValueError(f"a heading is a number of radians or one of {', '.join(COMPASS)}, not {text}")
    return heading


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A cell's ground: its centre and its size, in metres.

    Examples
    --------
    >>> Rectangle(0.5, 0.5, 1.0, 1.0).contains(1.0, 0.2)
    True
    """

    x: float
    y: float
    width: float
    height: float

    def contains(self, x: float, y: float, tolerance: float = 0.0) -> bool:
        """Whether the point is inside or on the border, give or take `tolerance` metres."""
        return (
            abs(x - self.x) <= self.width / 2 + tolerance and abs(y - self.y) <= self.height / 2 + tolerance
        )


@dataclass(frozen=True, slots=True)
class Door:
    """Where a move crosses from one cell to the next.

    Parameters
    ----------
    x, y
        The middle of the shared edge, or the shared corner, in metres.
    heading
        Of a robot that goes through it, square to the edge, in radians.
    opening
        The length of the shared edge; 0 at a corner.
    """

    x: float
    y: float
    heading: float
    opening: float


class TravelTimes(Protocol):
    """How long a robot takes, in seconds."""

    def through(self, cell: Rectangle, entry: Door, leave: Door) -> Fraction:
        """From one door of `cell` to another, or back to the same."""

    def out_of(self, cell: Rectangle, heading: float | None, leave: Door) -> Fraction:
        """From the centre of `cell`, facing `heading` (``None``: facing as it likes), to a door."""


@dataclass(frozen=True, eq=False)
class HeadedWorkspace:
    """A workspace whose locations are cells together with the way they were entered.

    Parameters
    ----------
    workspace
        The locations, called ``cell@heading``, and their moves.
    cell_of
        int32, shape (locations,): the cell of the workspace it was made from.
    start
        The location in which the robot starts.
    """

    workspace: Workspace
    cell_of: Indices
    start: int


def rectangle_of(workspace: Workspace, cell: int) -> Rectangle:
    """The ground of `cell`.

    Raises
    ------
    WorkspaceError
        If the map has no geometry.
    """
    positions, sizes = _geometry(workspace)
    x, y = positions[cell].tolist()
    width, height = sizes[cell].tolist()
    return Rectangle(x, y, width, height)


def doors(workspace: Workspace, source: Indices, target: Indices) -> list[Door]:
    """The doors from each cell of `source` to the cell of `target` in the same place.

    Raises
    ------
    WorkspaceError
        If the map has no geometry, or two of the cells do not touch.

    Examples
    --------
    >>> from mitlplan.workspace import grid
    >>> doors(grid(1, 2), np.array([0]), np.array([1]))
    [Door(x=1.0, y=0.5, heading=0.0, opening=1.0)]
    """
    return [Door(*row) for row in _door_rows(workspace, source, target).tolist()]


def with_travel_times(
    workspace: Workspace, times: TravelTimes, start: int, heading: float | None = None
) -> Workspace:
    """The same cells, each move as slow as the slowest way of coming to it, so that every plan can be driven.

    Parameters
    ----------
    workspace
        With positions and sizes; the times of its moves are replaced.
    times
        Of the robot.
    start, heading
        Where the robot starts, at the centre of the cell, and how it faces; ``None``: as it likes.

    Raises
    ------
    WorkspaceError
        If the map has no geometry.
    """
    turns = _turns(workspace, times)
    slowest = np.full(workspace.move_count, -1, dtype=np.int64)
    np.maximum.at(slowest, turns.onward, turns.time)
    seconds = [turns.times[index] if index >= 0 else None for index in slowest.tolist()]
    leaving = workspace.moves_from(start)
    for move, first in zip(leaving, _departures(workspace, times, start, heading), strict=True):
        before = seconds[move]
        seconds[move] = first if before is None else max(before, first)
    # A move that nobody can come to keeps the time it had.
    known = [workspace.least_time(move) if time is None else time for move, time in enumerate(seconds)]
    return replace(workspace, **_timetable(known))


def with_headings(
    workspace: Workspace, times: TravelTimes, start: int, heading: float | None = None
) -> HeadedWorkspace:
    """A location for each way of entering a cell, and moves as slow as their own turn.

    Parameters
    ----------
    workspace
        With positions and sizes; the times of its moves are replaced.
    times
        Of the robot.
    start, heading
        Where the robot starts, at the centre of the cell, and how it faces; ``None``: as it likes.

    Raises
    ------
    WorkspaceError
        If the map has no geometry.
    """
    turns = _turns(workspace, times)
    first = np.array(workspace.moves_from(start), dtype=np.int32)
    departures = _departures(workspace, times, start, heading)
    # Location 0 is the start; location m + 1 is the cell that move m has led to.
    cell_of = np.concatenate([[start], workspace.target]).astype(np.int32)
    positions, sizes = _geometry(workspace)
    seconds = [*departures, *(turns.times[index] for index in turns.time.tolist())]
    headed = Workspace(
        names=_headed_names(workspace, cell_of),
        label_sets=workspace.label_sets,
        label_of=workspace.label_of[cell_of],
        source=np.concatenate([np.zeros(len(first)), turns.into + 1]).astype(np.int32),
        target=np.concatenate([first + 1, turns.onward + 1]).astype(np.int32),
        waiting=workspace.waiting,
        positions=positions[cell_of],
        sizes=sizes[cell_of],
        **_timetable(seconds),
    )
    return HeadedWorkspace(headed, cell_of, 0)


# ------------------------------------------------------------------------------------------------- the
# geometry


def _geometry(workspace: Workspace) -> tuple[Array, Array]:
    if workspace.positions is None or workspace.sizes is None:
        raise WorkspaceError(
            "this map says nothing of where its cells lie, so no robot can be sent across it; "
            "use a grid or another map with a geometry"
        )
    return workspace.positions, workspace.sizes


def _door_rows(workspace: Workspace, source: Indices, target: Indices) -> Array:
    """For each pair of cells the x, y, heading and opening of its door."""
    positions, sizes = _geometry(workspace)
    offset = positions[target] - positions[source]
    tolerance = _TOUCHING * (sizes[source] + sizes[target])
    gap = np.abs(offset) - (sizes[source] + sizes[target]) / 2
    touching = np.abs(gap) <= tolerance
    apart = (gap > tolerance).any(axis=1) | ~touching.any(axis=1)
    if apart.any():
        pair = int(np.argmax(apart))
        names = workspace.names[int(source[pair])], workspace.names[int(target[pair])]
        raise WorkspaceError(f"the cells {names[0]} and {names[1]} do not touch: there is no way across")
    low = np.maximum((positions - sizes / 2)[source], (positions - sizes / 2)[target])
    high = np.minimum((positions + sizes / 2)[source], (positions + sizes / 2)[target])
    side = np.where(touching, np.sign(offset), 0.0)
    heading = np.arctan2(side[:, 1], side[:, 0]) % (2 * math.pi)
    opening = np.maximum((high - low).max(axis=1), 0.0) * (touching.sum(axis=1) == 1)
    return np.column_stack([(low + high) / 2, heading, opening])


@dataclass(frozen=True, eq=False)
class _Turns:
    """Every way through a cell, from move `into` to move `onward`: it takes ``times[time]``."""

    into: Indices
    onward: Indices
    time: NDArray[np.int64]
    times: list[Fraction]


def _turns(workspace: Workspace, times: TravelTimes) -> _Turns:
    into, onward = _pairs(workspace)
    source, target = workspace.source, workspace.target
    rows = _door_rows(workspace, source, target)
    entries, leaves = (_seen_from_cell(workspace, rows, cells) for cells in (target, source))
    shapes, shape_of = np.unique(np.concatenate([entries, leaves]), axis=0, return_inverse=True)
    entry_of, leave_of = np.split(shape_of.ravel(), 2)
    pairs, pair_of = np.unique(entry_of[into] * len(shapes) + leave_of[onward], return_inverse=True)
    taken = [_time_through(times, shapes[pair // len(shapes)], shapes[pair % len(shapes)]) for pair in pairs]
    distinct = sorted(set(taken))
    place = np.array([distinct.index(time) for time in taken], dtype=np.int64)
    return _Turns(into, onward, place[pair_of.ravel()], distinct)


def _pairs(workspace: Workspace) -> tuple[Indices, Indices]:
    """Each move with each move that may follow it, sorted."""
    first = np.searchsorted(workspace.source, workspace.target, side="left")
    count = np.searchsorted(workspace.source, workspace.target, side="right") - first
    into = np.repeat(np.arange(workspace.move_count), count)
    place = np.arange(len(into)) - np.repeat(np.cumsum(count) - count, count)
    return into.astype(np.int32), (first[into] + place).astype(np.int32)


def _seen_from_cell(workspace: Workspace, rows: Array, cells: Indices) -> Array:
    """Doors relative to the centres of `cells`, with the cells' sizes: equal turns have equal rows."""
    positions, sizes = _geometry(workspace)
    seen = np.column_stack([rows[:, :2] - positions[cells], rows[:, 2:], sizes[cells]])
    # Adding 0.0 makes -0.0 a 0.0.
    return np.asarray(np.round(seen, _DIGITS) + 0.0)


def _time_through(times: TravelTimes, entry: Array, leave: Array) -> Fraction:
    entry_door, leave_door = Door(*entry[:4].tolist()), Door(*leave[:4].tolist())
    return times.through(Rectangle(0.0, 0.0, *entry[4:].tolist()), entry_door, leave_door)


def _departures(
    workspace: Workspace, times: TravelTimes, start: int, heading: float | None
) -> list[Fraction]:
    moves = np.array(workspace.moves_from(start), dtype=np.int32)
    ways_out = doors(workspace, workspace.source[moves], workspace.target[moves])
    cell = rectangle_of(workspace, start)
    return [times.out_of(cell, heading, door) for door in ways_out]


# ------------------------------------------------------------------------------------------------ the
# timetable


class _Timetable(TypedDict):
    durations: tuple[Fraction, ...]
    least: Indices
    most: Indices


def _timetable(seconds: list[Fraction]) -> _Timetable:
    durations = tuple(sorted(set(seconds)))
    place = {time: index for index, time in enumerate(durations)}
    indices = np.array([place[time] for time in seconds], dtype=np.int32)
    return {"durations": durations, "least": indices, "most": indices}


def _headed_names(workspace: Workspace, cell_of: Indices) -> ListedNames:
    """``cell@heading``; the start is ``cell@start``; two doors with the same heading are counted."""
    rows = _door_rows(workspace, workspace.source, workspace.target)
    compass = np.round(rows[:, 2] / (math.pi / 4)).astype(int) % 8
    names = [f"{workspace.names[int(cell_of[0])]}@start"]
    seen: dict[str, int] = {}
    for cell, point in zip(cell_of[1:].tolist(), compass.tolist(), strict=True):
        name = f"{workspace.names[cell]}@{COMPASS[point]}"
        seen[name] = seen.get(name, 0) + 1
        names.append(name if seen[name] == 1 else f"{name}{seen[name]}")
    return ListedNames(names)
