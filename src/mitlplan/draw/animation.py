"""The robot on its way, as an animated picture.

The picture of the trajectory is drawn once; for each frame the robot, the line of what it has done and a
hand on each of the controls are drawn over it. All frames share the palette of the picture, which keeps the
file small and the colours still.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Circle, Polygon

from mitlplan.draw.ground import INK, mark_size
from mitlplan.draw.picture import Picture, picture, settings
from mitlplan.draw.way import robot_outline
from mitlplan.trajectory import Samples, Trajectory
from mitlplan.workspace.workspace import Workspace

if TYPE_CHECKING:
    from PIL.Image import Image

_FRAMES_A_SECOND = 20
_LONGEST_SECONDS = 12.0
_PAUSE_MILLISECONDS = 1200
_DOTS_AN_INCH = 90


def animation(
    workspace: Workspace,
    trajectory: Trajectory,
    *,
    radius: float | None = None,
    title: str = "",
    speed: float | None = None,
) -> bytes:
    """An animated GIF of the robot on its way.

    Parameters
    ----------
    workspace
        With positions and sizes.
    trajectory
        What the robot does; one that goes round is shown once to its end, and again from the beginning.
    radius
        Of the disc around the robot, in metres; ``None``: none is drawn.
    title
        Above the map.
    speed
        Seconds of the robot in a second; ``None``: as it is, or as fast as 12 seconds ask for.

    Raises
    ------
    WorkspaceError
        If the map has no geometry.
    """
    end = float(trajectory.end)
    rate = max(1.0, end / _LONGEST_SECONDS) if speed is None else speed
    count = max(2, round(end / rate * _FRAMES_A_SECOND) + 1)
    samples = trajectory.sample_at(np.linspace(0.0, end, count, dtype=np.float64))
    with settings():
        drawn = picture(workspace, trajectory=trajectory, title=title)
        size = 1.5 * mark_size(workspace) if radius is None else 0.7 * radius
        frames = _frames(drawn, samples, size, radius)
    return _gif(frames)


def _frames(drawn: Picture, samples: Samples, size: float, radius: float | None) -> list[Image]:
    drawn.figure.set_dpi(_DOTS_AN_INCH)
    canvas: Any = drawn.figure.canvas
    canvas.draw()
    # The layout is settled: nothing moves while the frames are drawn.
    drawn.figure.set_layout_engine("none")
    background = canvas.copy_from_bbox(drawn.figure.bbox)
    robot = Polygon(np.zeros((4, 2)), facecolor=INK, edgecolor="white", linewidth=1.2, zorder=20)
    disc = Circle((0.0, 0.0), radius or 0.0, facecolor=INK, alpha=0.15, linewidth=0, zorder=19)
    shapes = [disc, robot] if radius else [robot]
    for shape in shapes:
        drawn.ground.add_patch(shape)
    hands = [axis.axvline(0.0, color=INK, linewidth=1.0, zorder=20) for axis in drawn.controls]
    course = samples.course
    frames = []
    for place, time in enumerate(samples.time.tolist()):
        robot.set_xy(robot_outline(course.x[place], course.y[place], course.heading[place], size))
        disc.set_center((float(course.x[place]), float(course.y[place])))
        canvas.restore_region(background)
        for shape in shapes:
            drawn.ground.draw_artist(shape)
        for axis, hand in zip(drawn.controls, hands, strict=True):
            hand.set_xdata([time, time])
            axis.draw_artist(hand)
        frames.append(_image(canvas))
    return frames


def _image(canvas: Any) -> Image:
    from PIL import Image

    return Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3].copy())


def _gif(frames: list[Image]) -> bytes:
    from PIL.Image import Dither, Quantize

    palette = frames[0].quantize(255, method=Quantize.MEDIANCUT)
    still = [frame.quantize(palette=palette, dither=Dither.NONE) for frame in frames]
    durations = [round(1000 / _FRAMES_A_SECOND)] * (len(still) - 1) + [_PAUSE_MILLISECONDS]
    file = io.BytesIO()
    still[0].save(file, "gif", save_all=True, append_images=still[1:], duration=durations, loop=0)
    return file.getvalue()
