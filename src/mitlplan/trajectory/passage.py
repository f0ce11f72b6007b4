"""Passages: the ways through one cell, and which of them stay in it.

A cell is a rectangle with open doors in its border; the rest of the border is wall. A way through fits a
robot of radius r if its centre stays in the rectangle and a disc of radius r around it touches no wall. (At
a door the disc reaches into the neighbour, where the robot comes from or goes to.) Cells of one kind are
crossed alike, so everything is worked out once, in a frame in which the robot begins facing along the x axis
or less than a quarter turn away from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan.trajectory.leg import Weights
from mitlplan.trajectory.motion import Motion, Style, passing
from mitlplan.trajectory.pose import QUARTER, Pose
from mitlplan.trajectory.profile import Profile
from mitlplan.workspace.motion import Door, Rectangle

Array: TypeAlias = NDArray[np.float64]
Wall: TypeAlias = tuple[float, float, float, float]

INSIDE = 1e-9
"""How far, in metres, rounding may put a pose outside its cell."""

_DIGITS = 12
_LONG_WAY_ROUND = 2.5
_SAMPLES = 1025


@dataclass(frozen=True, slots=True)
class Passage:
    """From a pose in a cell to another, or to its centre.

    Parameters
    ----------
    width, height
        Of the cell, whose centre is the origin.
    begin
        Where the robot is at first.
    goal
        Where it goes; its heading counts up to full turns. ``None``: to the centre, with any heading.
    walls
        The segments (x, y, x, y) of the border that are not open.
    """

    width: float
    height: float
    begin: Pose
    goal: Pose | None
    walls: tuple[Wall, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """A motion through a passage, and what it asks of the robot.

    Parameters
    ----------
    motion
        In one second.
    style
        How it is driven.
    clearance
        The least distance to a wall, in metres.
    speed, turn_rate, acceleration, turn_acceleration
        The greatest absolute values in one second; accelerations are infinite where controls jump.
    """

    motion: Motion
    style: Style
    clearance: float
    speed: float
    turn_rate: float
    acceleration: float
    turn_acceleration: float


def passage(cell: Rectangle, begin: Pose, goal: Pose | None, doors: tuple[Door, ...]) -> Passage:
    """The passage through `cell`, in the frame in which equal passages are equal.

    Parameters
    ----------
    cell
        The ground.
    begin, goal
        In the frame of the map.
    doors
        What is open.
    """
    quarters = math.floor(begin.heading / QUARTER + 1e-6)
    frame = Pose(cell.x, cell.y, quarters * QUARTER)
    width, height = (cell.width, cell.height) if quarters % 2 == 0 else (cell.height, cell.width)
    openings = [(Pose(door.x, door.y, 0.0).seen_from(frame), door.opening / 2) for door in doors]
    return Passage(
        round(width, _DIGITS),
        round(height, _DIGITS),
        _rounded(begin.seen_from(frame)),
        None if goal is None else _rounded(goal.seen_from(frame)),
        tuple(_walls(width / 2, height / 2, openings)),
    )


@lru_cache(maxsize=4096)
def choose(way: Passage, style: Style, weights: Weights, profile: Profile) -> Choice | None:
    """The cheapest motion of one style through `way`; ``None`` if none stays in the cell.

    Parameters
    ----------
    way
        From :func:`passage`.
    style
        How to go.
    weights, profile
        Of the cost, and of the motion.
    """
    fitting = [
        _measured(way, style, motion.smoothed(profile))
        for motion in _motions(way, style, weights)
        if _greatest(partial(_outside, way, motion)) <= INSIDE
    ]
    if not fitting:
        return None
    # Of two that cost the same, as the two ways round do, the one that keeps clear of the walls.
    return min(fitting, key=lambda choice: (round(choice.motion.cost, 9), -choice.clearance))


def _motions(way: Passage, style: Style, weights: Weights) -> Iterator[Motion]:
    centre = Pose(0.0, 0.0, 0.0).seen_from(way.begin)
    for goal in _goals(way, centre):
        motion = passing(goal, centre, weights, style)
        if motion is not None:
            yield motion


def _goals(way: Passage, centre: Pose) -> Iterator[Pose]:
    """The goal as seen from the beginning, for each way round that may pay."""
    if way.goal is None:
        sense = 1.0 if centre.x >= 0 else -1.0
        yield Pose(centre.x, centre.y, math.atan2(sense * centre.y, sense * centre.x) + 0.0)
        return
    goal = way.goal.seen_from(way.begin)
    turn = math.remainder(goal.heading, 4 * QUARTER)
    yield Pose(goal.x, goal.y, turn)
    if abs(turn) > _LONG_WAY_ROUND:
        yield Pose(goal.x, goal.y, turn - math.copysign(4 * QUARTER, turn))


# ------------------------------------------------------------------------------------------------ measuring


def _measured(way: Passage, style: Style, motion: Motion) -> Choice:
    smooth = motion.profile is not Profile.EVEN
    return Choice(
        motion,
        style,
        clearance=-_greatest(lambda time: -_distance_to_walls(way, motion, time)),
        speed=_greatest(lambda time: np.abs(motion.course(time).u)),
        turn_rate=_greatest(lambda time: np.abs(motion.course(time).w)),
        acceleration=_greatest(lambda time: np.abs(motion.slopes(time)[0])) if smooth else math.inf,
        turn_acceleration=_greatest(lambda time: np.abs(motion.slopes(time)[1])) if smooth else math.inf,
    )


def _greatest(value: Callable[[Array], Array]) -> float:
    """The maximum over the second, looked for once more around the greatest sample."""
    time = np.linspace(0.0, 1.0, _SAMPLES, dtype=np.float64)
    place = int(np.argmax(value(time)))
    low, high = time[max(place - 1, 0)], time[min(place + 1, _SAMPLES - 1)]
    around = np.linspace(low, high, _SAMPLES, dtype=np.float64)
    return float(max(value(time)[place], value(around).max()))


def _outside(way: Passage, motion: Motion, time: Array) -> Array:
    course = motion.course(time).placed(way.begin)
    return np.maximum(np.abs(course.x) - way.width / 2, np.abs(course.y) - way.height / 2)


def _distance_to_walls(way: Passage, motion: Motion, time: Array) -> Array:
    course = motion.course(time).placed(way.begin)
    least = np.full(time.shape, math.inf)
    for x, y, end_x, end_y in way.walls:
        along, up = end_x - x, end_y - y
        square = along**2 + up**2
        share = (
            ((course.x - x) * along + (course.y - y) * up) / square if square > 0 else np.zeros(time.shape)
        )
        share = np.clip(share, 0.0, 1.0)
        least = np.minimum(least, np.hypot(course.x - x - share * along, course.y - y - share * up))
    return least


# -------------------------------------------------------------------------------------------------- the walls


def _walls(half_width: float, half_height: float, openings: list[tuple[Pose, float]]) -> Iterator[Wall]:
    """The border without its openings; an end of an opening is a wall of no length at least."""
    for sign in (-1.0, 1.0):
        for low, high in _closed(half_height, [(p.y, h) for p, h in openings if _on(p.x, sign * half_width)]):
            yield _rounded_wall(sign * half_width, low, sign * half_width, high)
        for low, high in _closed(half_width, [(p.x, h) for p, h in openings if _on(p.y, sign * half_height)]):
            yield _rounded_wall(low, sign * half_height, high, sign * half_height)


def _closed(half: float, openings: list[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """The parts of a side from -half to half between its openings; a corner opens both its sides."""
    if any(reach == 0 for _, reach in openings):
        return
    begin = -half
    for middle, reach in sorted(openings):
        yield begin, max(begin, middle - reach)
        begin = min(half, middle + reach)
    yield begin, half


def _on(coordinate: float, side: float) -> bool:
    return abs(coordinate - side) < INSIDE


def _rounded_wall(*ends: float) -> Wall:
    x, y, end_x, end_y = (round(end, _DIGITS) + 0.0 for end in ends)
    return x, y, end_x, end_y


def _rounded(pose: Pose) -> Pose:
    """So that passages which rounding tells apart are the same; adding 0.0 makes -0.0 a 0.0."""
    heading = round(pose.heading, 12)
    nearest = round(heading / QUARTER) * QUARTER
    exact = nearest if abs(heading - nearest) < 1e-11 else heading
    return Pose(round(pose.x, _DIGITS) + 0.0, round(pose.y, _DIGITS) + 0.0, exact + 0.0)
