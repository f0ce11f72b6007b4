"""The way of the robot in a picture: a plan from centre to centre, or a trajectory with marks in time.

Colours run from dark to bright with time, so that a way that crosses itself can be followed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from matplotlib import colormaps, patheffects
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import FancyArrowPatch
from numpy.typing import NDArray

from mitlplan.draw.ground import INK, mark_size
from mitlplan.errors import WorkspaceError
from mitlplan.plan import Plan
from mitlplan.trajectory import Trajectory
from mitlplan.workspace.workspace import Workspace

Array: TypeAlias = NDArray[np.float64]

_MOST_CELLS_WITH_ARROWS = 144
_MOST_ARROWS = 40
_SAMPLES_A_PIECE = 120
_MOST_SAMPLES = 40_000
_INSTANT = 1e-9
_WHOLE = np.linspace(0.0, 1.0, 3, dtype=np.float64)


def time_colour(share: float | Array) -> Any:
    """The colour of a moment, from 0 to 1: dark to bright, without what would vanish on the ground."""
    return colormaps["plasma"](0.72 * np.asarray(share))


def draw_plan(axes: Axes, workspace: Workspace, plan: Plan) -> None:
    """Arrows from centre to centre, each cell with the times at which it is entered.

    Raises
    ------
    WorkspaceError
        If the map has no geometry, or has not a cell of the plan.
    """
    centres = _centres(workspace, plan)
    following = [*range(1, len(plan.steps))]
    if plan.loop is not None and plan.loop.period is not None:
        following.append(plan.loop.start)
    if workspace.cell_count <= _MOST_CELLS_WITH_ARROWS and len(following) <= _MOST_ARROWS:
        _draw_arrows(axes, centres, following)
        _label_entries(axes, plan, centres)
    else:
        _draw_route(axes, workspace, plan, centres[[0, *following]])
    _mark(axes, centres[0], "o")
    if len(following) < len(plan.steps):
        _mark(axes, centres[-1], "s")


def _draw_arrows(axes: Axes, centres: Array, following: Sequence[int]) -> None:
    """Bent to the right, so that the way there and the way back lie side by side."""
    for number, target in enumerate(following):
        axes.add_patch(
            FancyArrowPatch(
                tuple(centres[number].tolist()),
                tuple(centres[target].tolist()),
                connectionstyle="arc3,rad=0.12",
                arrowstyle="-|>",
                mutation_scale=12,
                shrinkA=8,
                shrinkB=8,
                color=time_colour(number / max(len(following) - 1, 1)),
                linewidth=1.8,
                zorder=5,
            )
        )


def _label_entries(axes: Axes, plan: Plan, centres: Array) -> None:
    """Beside each cell all the times at which it is entered."""
    entered: dict[str, list[str]] = {}
    for step in plan.steps:
        entered.setdefault(step.cell, []).append(shown_time(step.enter))
    for step, (x, y) in zip(plan.steps, centres.tolist(), strict=True):
        times = entered.pop(step.cell, None)
        if times is not None:
            _label(axes, ", ".join(times) + " s", x, y, (22.0, 10.0))


def _draw_route(axes: Axes, workspace: Workspace, plan: Plan, points: Array) -> None:
    """A line, with a dart and the time at some of the cells."""
    times = np.array([float(step.enter) for step in plan.steps])
    end = max(float(plan.makespan), 1e-9)
    _draw_line(axes, points, times[: len(points) - 1] / end)
    stride = math.ceil(len(points) / 12)
    for place in range(0, len(points) - 1, stride):
        (x, y), (next_x, next_y) = points[place].tolist(), points[place + 1].tolist()
        heading = math.atan2(next_y - y, next_x - x)
        text = shown_time(plan.steps[place].enter)
        _draw_dart(axes, (x, y, heading), mark_size(workspace), times[place] / end, text)


def draw_trajectory(axes: Axes, workspace: Workspace, trajectory: Trajectory) -> None:
    """The way of the robot's centre, with a dart and the time at even times.

    Raises
    ------
    WorkspaceError
        If the map has no geometry.
    """
    end = max(float(trajectory.end), 1e-9)
    times = _bend_times(trajectory)
    course = trajectory.sample_at(times).course
    points = np.column_stack([course.x, course.y])
    _draw_line(axes, points, times[:-1] / end)
    step = even_step(trajectory.end, min(12, max(4, 3 * len(trajectory.visits) - 1)))
    # The end of a loop is a place on the way, which has its mark already.
    count = math.floor(trajectory.end / step) + (1 if trajectory.repeat_from is None else 0)
    marks = trajectory.sample(step)
    for place in range(count):
        x, y, heading = (float(row[place]) for row in (marks.course.x, marks.course.y, marks.course.heading))
        share = float(marks.time[place]) / end
        _draw_dart(axes, (x, y, heading), mark_size(workspace), share, shown_time(place * step))
    _mark(axes, points[0], "o")
    if trajectory.repeat_from is None:
        _mark(axes, points[-1], "s")


def _bend_times(trajectory: Trajectory) -> Array:
    """Times enough to draw the way smoothly: many where it is bent, the ends where it is straight."""
    each = max(2, min(_SAMPLES_A_PIECE, _MOST_SAMPLES // len(trajectory.pieces)))
    times = []
    for piece in trajectory.pieces:
        bent = any(leg.course(_WHOLE).w.any() for stroke in piece.motion.strokes for leg in stroke)
        shares = np.linspace(0.0, 1.0, each if bent else 2)[:-1]
        times.append(float(piece.begin) + float(piece.duration) * shares)
    return np.append(np.concatenate(times), float(trajectory.end))


def dense_times(trajectory: Trajectory) -> Array:
    """Times enough to draw the controls of every piece, with both sides of every jump of the controls."""
    each = max(2, min(_SAMPLES_A_PIECE, _MOST_SAMPLES // len(trajectory.pieces)))
    times = []
    for piece in trajectory.pieces:
        strokes = np.cumsum([sum(leg.duration for leg in stroke) for stroke in piece.motion.strokes])
        jumps = np.append(0.0, strokes[:-1])
        ends = np.append(strokes[:-1], 1.0)
        shares = np.sort(np.concatenate([np.linspace(0.0, 1.0, each), jumps, ends * (1 - _INSTANT)]))
        times.append(float(piece.begin) + float(piece.duration) * shares[shares <= 1 - _INSTANT])
    return np.concatenate(times)


def even_step(end: Fraction, most: int) -> Fraction:
    """The least of 1, 2 and 5 times a power of ten that divides `end` into no more than `most` parts.

    Examples
    --------
    >>> even_step(Fraction(7, 2), 8), even_step(Fraction(300), 16)
    (Fraction(1, 2), Fraction(20, 1))
    """
    if end <= 0:
        return Fraction(1)
    power = Fraction(10) ** math.floor(math.log10(end / most))
    return next(power * digit for digit in (1, 2, 5, 10) if end / (power * digit) <= most)


def shown_time(time: Fraction) -> str:
    """A time for a picture: exact if it is short.

    Examples
    --------
    >>> shown_time(Fraction(7, 2)), shown_time(Fraction(1, 3))
    ('3.5', '0.33')
    """
    return f"{float(time):.2f}".rstrip("0").rstrip(".")


def _draw_line(axes: Axes, points: Array, shares: Array) -> None:
    line = LineCollection(
        list(np.stack([points[:-1], points[1:]], axis=1)),
        colors=time_colour(shares),
        linewidths=2.2,
        capstyle="round",
        zorder=5,
    )
    axes.add_collection(line)


def _draw_dart(axes: Axes, pose: tuple[float, float, float], size: float, share: float, text: str) -> None:
    x, y, heading = pose
    outline = robot_outline(x, y, heading, size).T
    axes.fill(*outline, facecolor=time_colour(share), edgecolor="white", linewidth=0.7, zorder=6)
    # To the left of the robot, so that the times of a way there and back stand on different sides; a text is
    # wider than it is high.
    across, up = -math.sin(heading), math.cos(heading)
    away = 7 + abs(across) * 2.6 * len(text) + abs(up) * 4
    _label(axes, text, x, y, (away * across, away * up))


def robot_outline(x: float, y: float, heading: float, size: float) -> Array:
    """A dart of that size, pointing where the robot faces."""
    dart = size * np.array([(1.3, 0.0), (-0.9, 0.8), (-0.5, 0.0), (-0.9, -0.8)])
    turn = np.array([[math.cos(heading), math.sin(heading)], [-math.sin(heading), math.cos(heading)]])
    return np.asarray(dart @ turn + (x, y))


def _mark(axes: Axes, place: Array, shape: str) -> None:
    """A ring where the robot starts, a square where it stops."""
    axes.plot(
        *place,
        shape,
        markersize=15,
        markerfacecolor="none",
        markeredgecolor=INK,
        markeredgewidth=1.3,
        clip_on=False,
        zorder=4,
    )


def _label(axes: Axes, text: str, x: float, y: float, beside: tuple[float, float] = (16.0, 9.0)) -> None:
    written = axes.annotate(
        text,
        (x, y),
        xytext=beside,
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=8,
        color=INK,
        zorder=9,
    )
    written.set_path_effects([patheffects.withStroke(linewidth=2.2, foreground="white")])


def _centres(workspace: Workspace, plan: Plan) -> Array:
    if workspace.positions is None:
        raise WorkspaceError("this map says nothing of where its cells lie, so no plan can be drawn on it")
    cells = []
    for step in plan.steps:
        cell = workspace.index_of(step.cell)
        if cell is None:
            raise WorkspaceError(f"no cell is called {step.cell}; {workspace.advise(step.cell)}")
        cells.append(cell)
    return np.asarray(workspace.positions[cells])
