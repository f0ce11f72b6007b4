"""Pictures: the map, and on it a plan or a trajectory with its controls over time."""

from __future__ import annotations

import io
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mitlplan.draw.ground import FAINT, INK, Geometry, cell_colours, draw_ground
from mitlplan.draw.way import dense_times, draw_plan, draw_trajectory
from mitlplan.plan import Plan
from mitlplan.trajectory import Trajectory
from mitlplan.workspace.workspace import Workspace

_DOTS_AN_INCH = 150
_MAP_HEIGHT = 4.6
_CONTROLS_WIDTH = 5.0
_MOST_BORDERS = 60
_STRIP = 0.22
"""The height of the strip of cells, where that of a control is 1."""
_LETTER = 4.6
"""The width of a small letter, in points."""


def settings() -> AbstractContextManager[None]:
    """The look of all pictures; the same picture always has the same bytes."""
    return rc_context(
        {
            "font.family": "sans-serif",
            "font.size": 9,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": FAINT,
            "axes.labelcolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "svg.hashsalt": "mitlplan",
        }
    )


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A figure and the axes in it.

    Parameters
    ----------
    figure
        Of matplotlib.
    ground
        The axes of the map.
    controls
        The axes of u, of w and of the cells over time; none without a trajectory.
    """

    figure: Figure
    ground: Axes
    controls: tuple[Axes, ...] = ()


def picture(
    workspace: Workspace, plan: Plan | None = None, trajectory: Trajectory | None = None, *, title: str = ""
) -> Picture:
    """Draw a map and what is known of the robot's way on it.

    Parameters
    ----------
    workspace
        With positions and sizes.
    plan
        Drawn from centre to centre, unless there is a trajectory.
    trajectory
        Drawn with marks at even times; beside it its controls, and the cells in which it is, over time.
    title
        Above the map.

    Raises
    ------
    WorkspaceError
        If the map has no geometry, or has not a cell of the plan.
    """
    with settings():
        figure, ground, controls = _layout(workspace, with_controls=trajectory is not None)
        draw_ground(ground, workspace)
        if trajectory is not None:
            draw_trajectory(ground, workspace, trajectory)
            draw_controls(controls[:2], trajectory)
            draw_visits(controls[2], workspace, trajectory)
        elif plan is not None:
            draw_plan(ground, workspace, plan)
        if title:
            ground.set_title(title, loc="left", color=INK, fontsize=10)
    return Picture(figure, ground, controls)


def rendered(drawn: Picture, kind: Literal["png", "svg", "pdf"]) -> bytes:
    """The file of a picture.

    Parameters
    ----------
    drawn
        From :func:`picture`.
    kind
        Of file.
    """
    file = io.BytesIO()
    with settings():
        metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
        drawn.figure.savefig(file, format=kind, dpi=_DOTS_AN_INCH, metadata=metadata)
    return file.getvalue()


def draw_controls(axes: tuple[Axes, ...], trajectory: Trajectory) -> None:
    """Speed and turn rate over time, with a line at each crossing."""
    times = dense_times(trajectory)
    course = trajectory.sample_at(times).course
    names = (("speed u  [m/s]", course.u, "#0072B2"), ("turn rate w  [rad/s]", course.w, "#D55E00"))
    crossings = [float(visit.enter) for visit in trajectory.visits[1:]]
    for axis, (name, values, colour) in zip(axes, names, strict=True):
        axis.axhline(0.0, color=FAINT, linewidth=0.8, zorder=1)
        if len(crossings) <= _MOST_BORDERS:
            for crossing in crossings:
                axis.axvline(crossing, color=FAINT, linewidth=0.6, linestyle=(0, (2, 3)), zorder=1)
        axis.plot(times, values, color=colour, linewidth=1.6, zorder=3)
        axis.fill_between(times, 0.0, values, color=colour, alpha=0.12, linewidth=0, zorder=2)
        axis.set_ylabel(name)
        axis.margins(x=0.01, y=0.12)
        low, high = axis.get_ylim()
        # A control that is all but constant is not blown up to fill its axis.
        if high - low < 1e-3 * max(1.0, float(np.abs(values).max())):
            axis.set_ylim(low - 0.5, high + 0.5)


def draw_visits(axis: Axes, workspace: Workspace, trajectory: Trajectory) -> None:
    """The plan: in which cell the robot is when, in the colours of the map, named where there is room."""
    assert workspace.positions is not None
    cells = {(x, y): cell for cell, (x, y) in enumerate(workspace.positions.tolist())}
    colours = cell_colours(workspace)
    end = float(trajectory.end)
    begins = [min(float(visit.enter), end) for visit in trajectory.visits]
    for visit, begin, finish in zip(trajectory.visits, begins, [*begins[1:], end], strict=True):
        cell = cells[visit.ground.x, visit.ground.y]
        edge = FAINT if len(begins) <= _MOST_BORDERS else "none"
        axis.axvspan(begin, finish, facecolor=colours[cell], edgecolor=edge, linewidth=0.6)
        lines = [workspace.names[cell], ", ".join(sorted(workspace.holds(cell)))]
        room = (finish - begin) / max(end, 1e-9) * _CONTROLS_WIDTH * 72 * 0.9
        if max(map(len, lines)) * _LETTER <= room:
            text = "\n".join(filter(None, lines))
            axis.text((begin + finish) / 2, 0.5, text, color=INK, fontsize=7, ha="center", va="center")
    axis.set_ylim(0.0, 1.0)
    axis.set_yticks([])
    axis.spines["left"].set_visible(False)
    axis.set_ylabel("cell", rotation=0, ha="right", va="center")
    axis.set_xlabel("time  [s]")


def _layout(workspace: Workspace, *, with_controls: bool) -> tuple[Figure, Axes, tuple[Axes, ...]]:
    left, right, bottom, top = Geometry.of(workspace).extent
    width = min(max(_MAP_HEIGHT * (right - left) / (top - bottom), 2.5), 9.0)
    height = min(_MAP_HEIGHT, max(width * (top - bottom) / (right - left), 1.6)) + 0.35
    if not with_controls:
        figure = Figure(figsize=(width + 0.3, height), layout="constrained")
        FigureCanvasAgg(figure)
        return figure, figure.add_subplot(), ()
    beside = width <= _MAP_HEIGHT * 1.3
    size = (width + _CONTROLS_WIDTH, max(height, 3.4)) if beside else (width + 0.3, height + 3.4)
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    if beside:
        both = figure.add_gridspec(
            3, 2, width_ratios=[width, _CONTROLS_WIDTH], height_ratios=[1.0, 1.0, _STRIP]
        )
        ground, *over_time = both[:, 0], both[0, 1], both[1, 1], both[2, 1]
    else:
        rows = figure.add_gridspec(4, 1, height_ratios=[height, 1.4, 1.4, 1.4 * _STRIP])
        ground, *over_time = rows[0], rows[1], rows[2], rows[3]
    speed = figure.add_subplot(over_time[0])
    turn_rate, visits = (figure.add_subplot(place, sharex=speed) for place in over_time[1:])
    for axis in (speed, turn_rate):
        axis.tick_params(labelbottom=False)
    return figure, figure.add_subplot(ground), (speed, turn_rate, visits)
