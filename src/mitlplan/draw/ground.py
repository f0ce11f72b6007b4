"""The ground of a picture: cells, what is blocked, and the regions of the propositions.

Maps of many cells are drawn as one image, small ones as rectangles with their names. Each proposition has its
colour, from a palette that colour-blind people can tell apart (M. Okabe and K. Ito), and its name beside it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from mitlplan.errors import WorkspaceError
from mitlplan.workspace.workspace import Workspace

Array: TypeAlias = NDArray[np.float64]

PALETTE = ("#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#F0E442", "#0072B2", "#D55E00", "#999999")
INK = "#222222"
FAINT = "#8a8a8a"

_BLOCKED, _FREE = "#4a4f57", "#fbfbf8"
_MOST_NAMED = 64
_MOST_OUTLINED = 1600
_EQUAL = 1e-6
_SMALL_REGION = 0.04


@dataclass(frozen=True, slots=True)
class Geometry:
    """Where the cells lie: float arrays of shape (cells,)."""

    left: Array
    right: Array
    bottom: Array
    top: Array

    @classmethod
    def of(cls, workspace: Workspace) -> Geometry:
        """The geometry of `workspace`.

        Raises
        ------
        WorkspaceError
            If it has none.
        """
        if workspace.positions is None or workspace.sizes is None:
            raise WorkspaceError(
                "this map says nothing of where its cells lie, so it cannot be drawn; "
                "use a grid or another map with a geometry"
            )
        low, high = workspace.positions - workspace.sizes / 2, workspace.positions + workspace.sizes / 2
        return cls(low[:, 0], high[:, 0], low[:, 1], high[:, 1])

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the whole map."""
        return (
            float(self.left.min()),
            float(self.right.max()),
            float(self.bottom.min()),
            float(self.top.max()),
        )


def draw_ground(axes: Axes, workspace: Workspace) -> None:
    """Draw the cells and regions of `workspace`, with equal scales on both axes.

    Raises
    ------
    WorkspaceError
        If the map has no geometry.
    """
    geometry = Geometry.of(workspace)
    left, right, bottom, top = geometry.extent
    axes.set_facecolor(_BLOCKED)
    colours = cell_colours(workspace)
    image = _image(geometry, colours) if workspace.cell_count > _MOST_OUTLINED else None
    if image is not None:
        axes.imshow(image, extent=geometry.extent, interpolation="nearest", zorder=1)
    else:
        _draw_cells(axes, geometry, colours)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_color(FAINT)
    if workspace.cell_count <= _MOST_NAMED:
        _write_cell_names(axes, workspace, geometry)
    _write_region_names(axes, workspace, geometry)


def _draw_cells(axes: Axes, geometry: Geometry, colours: Array) -> None:
    outlined = len(colours) <= _MOST_OUTLINED
    cells = PolyCollection(
        list(_corners(geometry)), facecolors=colours, edgecolors="#c9c9c4" if outlined else "face", zorder=1
    )
    cells.set_linewidth(0.6 if outlined else 0.3)
    cells.set_rasterized(not outlined)
    axes.add_collection(cells)


def _image(geometry: Geometry, colours: Array) -> Array | None:
    """The cells as pixels, where they are equal and in rows and columns."""
    left, right, bottom, top = geometry.extent
    width, height = geometry.right - geometry.left, geometry.top - geometry.bottom
    if np.ptp(width) > _EQUAL * width[0] or np.ptp(height) > _EQUAL * height[0]:
        return None
    column, row = (geometry.left - left) / width[0], (top - geometry.top) / height[0]
    if np.abs(column - np.round(column)).max() > _EQUAL or np.abs(row - np.round(row)).max() > _EQUAL:
        return None
    shape = round((top - bottom) / height[0]), round((right - left) / width[0]), 3
    image = np.tile(np.array(to_rgb(_BLOCKED)), (shape[0], shape[1], 1))
    image[np.round(row).astype(int), np.round(column).astype(int)] = colours
    return image


def colour_of(proposition: str, propositions: Sequence[str]) -> str:
    """The colour of a proposition among the sorted `propositions`."""
    return PALETTE[propositions.index(proposition) % len(PALETTE)]


def cell_colours(workspace: Workspace) -> Array:
    """The mean of the colours of what holds in each cell, mixed with the colour of free ground."""
    propositions = sorted(workspace.propositions)
    free = np.array(to_rgb(_FREE))
    mixed = []
    for holds in workspace.label_sets:
        rows = [to_rgb(colour_of(name, propositions)) for name in holds]
        mixed.append(free if not rows else 0.55 * free + 0.45 * np.mean(rows, axis=0))
    return np.array(mixed)[workspace.label_of]


def _corners(geometry: Geometry) -> Array:
    left, right, bottom, top = geometry.left, geometry.right, geometry.bottom, geometry.top
    return np.stack(
        [np.stack(pair, axis=1) for pair in ((left, bottom), (right, bottom), (right, top), (left, top))],
        axis=1,
    )


def _write_cell_names(axes: Axes, workspace: Workspace, geometry: Geometry) -> None:
    for cell in range(workspace.cell_count):
        width = geometry.right[cell] - geometry.left[cell]
        axes.annotate(
            workspace.names[cell],
            (float(geometry.left[cell] + 0.04 * width), float(geometry.bottom[cell] + 0.04 * width)),
            color=FAINT,
            fontsize=7,
            zorder=2,
        )


def _write_region_names(axes: Axes, workspace: Workspace, geometry: Geometry) -> None:
    """Each proposition by the cell of its region that is nearest to the region's middle."""
    assert workspace.positions is not None
    names = sorted(workspace.propositions)
    width = geometry.extent[1] - geometry.extent[0]
    rows: dict[int, int] = {}
    for name in names:
        holding = [index for index, holds in enumerate(workspace.label_sets) if name in holds]
        cells = np.flatnonzero(np.isin(workspace.label_of, holding))
        if len(cells) == 0:
            continue
        places = workspace.positions[cells]
        cell = int(cells[np.argmin(np.hypot(*(places - places.mean(axis=0)).T))])
        reach = float(np.ptp(places, axis=0).max()) + float(geometry.right[cell] - geometry.left[cell])
        if reach < _SMALL_REGION * width:
            x, y = workspace.positions[cell].tolist()
            colour = colour_of(name, names)
            axes.plot(x, y, "D", color=colour, markeredgecolor=INK, markersize=6, zorder=3)
        # Several names at one cell stand one below the other.
        rows[cell] = rows.get(cell, -1) + 1
        inside = workspace.cell_count <= _MOST_NAMED
        corner = (float(geometry.left[cell] if inside else geometry.right[cell]), float(geometry.top[cell]))
        _write_region_name(axes, name, corner, rows[cell], inside=inside)


def _write_region_name(axes: Axes, name: str, corner: tuple[float, float], row: int, *, inside: bool) -> None:
    text = axes.annotate(
        name,
        corner,
        xytext=(4, -4 - 13 * row) if inside else (7, -5 - 11 * row),
        textcoords="offset points",
        va="top",
        color=INK,
        fontsize=11 if inside else 9,
        fontweight="bold",
        zorder=8,
    )
    text.set_path_effects([patheffects.withStroke(linewidth=2.5, foreground="white")])


def mark_size(workspace: Workspace) -> float:
    """The half length of the dart that stands for a robot, in metres."""
    left, right, bottom, top = Geometry.of(workspace).extent
    assert workspace.sizes is not None
    return max(0.055 * float(np.median(workspace.sizes)), 0.009 * math.hypot(right - left, top - bottom))
