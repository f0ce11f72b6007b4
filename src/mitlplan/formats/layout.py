"""Where the locations of an automaton are drawn, and how edges get round each other.

A location that stands for a cell is drawn where the cell is on the map; what the formula does meanwhile puts
it on one of several copies of the map, side by side. Everything else stands in rows below. Units are those of
UPPAAL's editor, y downwards.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from math import ceil, cos, hypot, pi, sin, sqrt
from typing import TypeAlias

from mitlplan.automata.timed_automaton import Automaton
from mitlplan.workspace.workspace import Workspace

Point: TypeAlias = tuple[int, int]
Layout: TypeAlias = Mapping[str, Sequence[Point]]
"""For each automaton, by name, the places of its locations."""

CELL = 272
"""The distance between neighbouring locations."""

BEND = 34
"""How far the nail of a second edge lies beside the first."""

MOST_PAIRS_COMPARED = 2_000_000
"""Beyond this many pairs of edge and location, edges are not led round locations."""


def cell_points(workspace: Workspace) -> list[Point]:
    """The places of the cells: those of the map, or, where it is no geometry, on a circle.

    Examples
    --------
    >>> from mitlplan.workspace import grid
    >>> cell_points(grid(2, 2))
    [(0, 0), (272, 0), (0, 272), (272, 272)]
    """
    if workspace.positions is None:
        return _circle(workspace.cell_count)
    across, up = workspace.positions[:, 0], workspace.positions[:, 1]
    spacing = _least_distance(workspace) or 1.0
    return [
        (round(CELL * float(x) / spacing), round(CELL * float(y) / spacing))
        for x, y in zip(across - across.min(), up.max() - up, strict=True)
    ]


def _least_distance(workspace: Workspace) -> float:
    """The length of the shortest move."""
    if workspace.positions is None or workspace.move_count == 0:
        return 0.0
    difference = workspace.positions[workspace.source] - workspace.positions[workspace.target]
    lengths = [hypot(float(x), float(y)) for x, y in difference]
    return min((length for length in lengths if length > 0), default=0.0)


def _circle(count: int) -> list[Point]:
    """The first top left, then clockwise: four cells make the paper's square."""
    radius = CELL / (2 * sin(pi / count)) if count > 1 else 0.0
    angles = [-3 * pi / 4 + 2 * pi * index / count for index in range(count)]
    points = [(radius * cos(angle), radius * sin(angle)) for angle in angles]
    left, top = min(x for x, _ in points), min(y for _, y in points)
    return [(round(x - left), round(y - top)) for x, y in points]


def copies_of_map(
    cells: Sequence[int | None], layers: Sequence[int], points: Sequence[Point]
) -> tuple[Point, ...]:
    """Places for the locations of a product: each layer is a copy of the map, side by side.

    Parameters
    ----------
    cells
        For each location its cell; those without one are put below.
    layers
        For each location the number of its copy.
    points
        The places of the cells.
    """
    width = max(x for x, _ in points) + CELL
    below = max(y for _, y in points) + 2 * CELL
    placed: list[Point] = []
    others = 0
    for cell, layer in zip(cells, layers, strict=True):
        if cell is None:
            placed.append((others * CELL, below))
            others += 1
        else:
            x, y = points[cell]
            placed.append((x + layer * width, y))
    return tuple(placed)


def rows(count: int) -> tuple[Point, ...]:
    """Places for `count` locations in rows about as long as there are rows.

    Examples
    --------
    >>> rows(3)
    ((0, 0), (272, 0), (0, 272))
    """
    length = ceil(sqrt(count))
    return tuple((CELL * (index % length), CELL * (index // length)) for index in range(count))


def nails(automaton: Automaton, points: Sequence[Point]) -> list[tuple[Point, ...]]:
    """For each edge the points through which it is drawn: none if nothing lies between or beside."""
    between: dict[frozenset[int], list[int]] = defaultdict(list)
    for index, edge in enumerate(automaton.edges):
        between[frozenset((edge.source, edge.target))].append(index)
    result: list[tuple[Point, ...]] = [()] * len(automaton.edges)
    compare = len(between) * len(points) <= MOST_PAIRS_COMPARED
    for ends, edges in between.items():
        places = sorted(ends)
        blocked = compare and len(places) == 2 and _passes_another(points, *places)
        for rank, index in enumerate(edges):
            if len(places) == 1:
                result[index] = _loop(points[places[0]], rank)
            elif len(edges) > 1 or blocked:
                aside = (rank + 1 if blocked else 0) + rank - (len(edges) - 1) / 2
                result[index] = (_beside(points[places[0]], points[places[1]], aside),)
    return result


def _loop(point: Point, rank: int) -> tuple[Point, ...]:
    x, y = point
    height = BEND * (rank + 2)
    return ((x - BEND, y - height), (x + BEND, y - height))


def _beside(one: Point, other: Point, aside: float) -> Point:
    dx, dy = other[0] - one[0], other[1] - one[1]
    shift = BEND * aside / (hypot(dx, dy) or 1.0)
    return round((one[0] + other[0]) / 2 - dy * shift), round((one[1] + other[1]) / 2 + dx * shift)


def _passes_another(points: Sequence[Point], one: int, other: int) -> bool:
    """Whether a third location lies on the straight line between two."""
    (x0, y0), (x1, y1) = points[one], points[other]
    dx, dy = x1 - x0, y1 - y0
    square = dx * dx + dy * dy
    for index, (x, y) in enumerate(points):
        if index in (one, other) or square == 0:
            continue
        along = (x - x0) * dx + (y - y0) * dy
        if 0 < along < square and abs((x - x0) * dy - (y - y0) * dx) < BEND / 2 * sqrt(square):
            return True
    return False
