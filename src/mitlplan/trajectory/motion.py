"""Motions: what the robot does in one cell, in one second, seen from where it begins.

A motion is made of strokes, and a stroke of legs: within a stroke the controls are continuous, between
strokes the robot may come to a stop. The legs share the second so that the rate of cost is the same on all
of them, which is the cheapest way to share it: the root of the cost of the whole is the sum of the roots of
its parts.

Time scaling, the paper's lemma: a motion stretched to T seconds has its controls divided by T, and costs a
T-th. The robot goes the same way, so where it is, and what it may touch, does not depend on T.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan.trajectory.boundary import Way, connect, connect_forward, cost_of_way
from mitlplan.trajectory.leg import Slopes, Steady, Weights, end_of
from mitlplan.trajectory.pose import ORIGIN, QUARTER, Course, Pose
from mitlplan.trajectory.profile import Profile
from mitlplan.trajectory.three_point import three_point

Array: TypeAlias = NDArray[np.float64]

_SAME = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What the robot does in one second from the origin, facing along the x axis.

    Parameters
    ----------
    name
        What it is called in messages and pictures.
    strokes
        The ways between stops.
    end
        The pose at the end.
    cost
        The integral of the rate of cost over the second.
    profile
        How each stroke is run through.

    Examples
    --------
    >>> motion = turn_left(0.5, 0.5, Weights())
    >>> round(motion.cost, 10), round(motion.cost_in(2.0), 10)
    (3.0771054975, 1.5385527488)
    >>> motion.end
    Pose(x=0.5, y=0.5, heading=1.5707963267948966)
    """

    name: str
    strokes: tuple[Way, ...]
    end: Pose
    cost: float
    profile: Profile = Profile.EVEN

    def cost_in(self, duration: float) -> float:
        """The cost when the motion takes `duration` seconds."""
        return self.cost / duration

    @property
    def mirrored(self) -> Motion:
        """The motion with left and right exchanged."""
        strokes = tuple(tuple(leg.mirrored for leg in stroke) for stroke in self.strokes)
        return replace(self, strokes=strokes, end=self.end.mirrored)

    @property
    def backward(self) -> Motion:
        """The motion with ahead and behind exchanged."""
        strokes = tuple(tuple(leg.backward for leg in stroke) for stroke in self.strokes)
        return replace(self, strokes=strokes, end=self.end.turned_around)

    def smoothed(self, profile: Profile) -> Motion:
        """The motion with another profile."""
        cost = self.cost / self.profile.cost_factor * profile.cost_factor
        return replace(self, profile=profile, cost=cost)

    def course(self, time: Array) -> Course:
        """Poses and controls at `time`, in seconds from 0 to 1."""
        return self._driven(time)[0]

    def slopes(self, time: Array) -> Slopes:
        """The derivatives of u and w at `time`."""
        return self._driven(time)[1]

    def _driven(self, time: Array) -> tuple[Course, Slopes]:
        time = np.asarray(time, dtype=np.float64)
        begins, seconds, last_legs = self._timetable()
        stroke = np.clip(np.searchsorted(begins, time, side="right") - 1, 0, len(begins) - 1)
        share = np.clip((time - begins[stroke]) / seconds[stroke], 0.0, 1.0)
        done, pace, change = self.profile.progress(share)
        even_time = begins[stroke] + done * seconds[stroke]
        course, slopes = self._evenly(even_time, last_legs[stroke])
        return (
            replace(course, u=course.u * pace, w=course.w * pace),
            (
                slopes[0] * pace**2 + course.u * change / seconds[stroke],
                slopes[1] * pace**2 + course.w * change / seconds[stroke],
            ),
        )

    def _timetable(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """For each stroke when it begins, how long it takes, and the number of its last leg."""
        seconds = np.array([sum(leg.duration for leg in stroke) for stroke in self.strokes])
        begins = np.concatenate([[0.0], np.cumsum(seconds)[:-1]])
        return begins, seconds, np.cumsum([len(stroke) for stroke in self.strokes]) - 1

    def _evenly(self, time: Array, last_leg: NDArray[np.int64]) -> tuple[Course, Slopes]:
        """Course and slopes of the even profile, on no later leg than `last_leg`."""
        legs = [leg for stroke in self.strokes for leg in stroke]
        begins = np.cumsum([0.0, *(leg.duration for leg in legs)])[:-1]
        number = np.minimum(np.searchsorted(begins, time, side="right") - 1, last_leg)
        rows = np.zeros((7, *time.shape))
        pose = ORIGIN
        for index, leg in enumerate(legs):
            here = number == index
            if here.any():
                local = time[here] - begins[index]
                course, slopes = leg.course(local).placed(pose), leg.slopes(local)
                rows[:, here] = course.x, course.y, course.heading, course.u, course.w, *slopes
            pose = pose.then(end_of(leg))
        return Course(*rows[:5]), (rows[5], rows[6])


def joined(name: str, ways: Sequence[Way], end: Pose, weights: Weights) -> Motion:
    """One motion of several ways, sharing the second as is cheapest.

    Parameters
    ----------
    name
        Of the motion.
    ways
        The strokes, each as long as it likes.
    end
        The pose at the end of the last.
    weights
        Of the cost.
    """
    roots = [math.sqrt(cost_of_way(way, weights) * sum(leg.duration for leg in way)) for way in ways]
    strokes = []
    for way, share in zip(ways, roots, strict=True):
        factor = share / sum(roots) / sum(leg.duration for leg in way)
        strokes.append(tuple(leg.scaled(factor) for leg in way))
    return Motion(name, tuple(strokes), end, sum(roots) ** 2)


# ---------------------------------------------------------------------------------------- elementary motions


class Style(Enum):
    """How a turn or a U-turn is driven."""

    FREE = "free"
    """At least cost, backwards where that is cheaper; no U-turns, which would never enter their cell."""
    FORWARD_ONLY = "forward-only"
    """At least cost with u >= 0; a U-turn reaches the line through the centre."""
    ARC = "arc"
    """The paper's quarter circle, with a straight line before or after it in a rectangle."""
    THREE_POINT = "three-point"
    """Forwards, backwards and forwards: U-turns only, to the line through the centre and back."""
    SPOT = "spot"
    """To the centre, a turn on the spot, and out."""


def straight(distance: float, weights: Weights) -> Motion:
    """Forward by `distance` metres; backward if that is negative.

    Examples
    --------
    >>> straight(0.5, Weights()).cost
    0.25
    """
    name = "forward" if distance >= 0 else "backward"
    return joined(name, [(Steady(distance, 0.0),)], Pose(distance, 0.0, 0.0), weights)


@lru_cache(maxsize=1)
def standing() -> Motion:
    """Nothing at all."""
    return Motion("standing", ((Steady(0.0, 0.0),),), ORIGIN, 0.0)


def turn_left(ahead: float, aside: float, weights: Weights, style: Style = Style.FREE) -> Motion | None:
    """A quarter turn to the left; ``None`` if there is none in that style.

    Parameters
    ----------
    ahead, aside
        Where it ends: metres ahead and to the left.
    weights
        Of the cost.
    style
        Any but THREE_POINT.

    Examples
    --------
    >>> round(turn_left(0.5, 0.5, Weights(), Style.ARC).cost, 10)
    3.0842513753
    """
    return passing(Pose(ahead, aside, QUARTER), Pose(ahead, 0.0, 0.0), weights, style)


def turn_right(ahead: float, aside: float, weights: Weights, style: Style = Style.FREE) -> Motion | None:
    """As :func:`turn_left`, to the right."""
    return passing(Pose(ahead, -aside, -QUARTER), Pose(ahead, 0.0, 0.0), weights, style)


def u_turn(depth: float, weights: Weights, style: Style = Style.THREE_POINT) -> Motion | None:
    """Back to where one came from, by the left; ``None`` if there is no such motion in that style.

    Parameters
    ----------
    depth
        How far ahead the centre is, in metres.
    weights
        Of the cost.
    style
        THREE_POINT, FORWARD_ONLY or SPOT.

    Examples
    --------
    >>> [round(u_turn(0.5, Weights(), style).cost, 5) for style in (Style.THREE_POINT, Style.FORWARD_ONLY)]
    [12.05676, 15.88706]
    """
    return passing(Pose(0.0, 0.0, 2 * QUARTER), Pose(depth, 0.0, 0.0), weights, style)


def passing(goal: Pose, centre: Pose, weights: Weights, style: Style) -> Motion | None:
    """The motion from the origin through a cell to `goal`, if there is one in that style.

    Parameters
    ----------
    goal
        Its heading says which way to turn, and how often.
    centre
        Of the cell; the heading is not used.
    weights
        Of the cost.
    style
        How to go.
    """
    if centre.x < 0:
        ahead = passing(goal.turned_around, centre.turned_around, weights, style)
        return None if ahead is None else ahead.backward
    if goal.heading < 0:
        left = passing(goal.mirrored, centre.mirrored, weights, style)
        return None if left is None else left.mirrored
    if style is Style.SPOT:
        ways = _by_way_of(centre, goal)
    elif math.hypot(goal.x, goal.y) < _SAME:
        ways = _back_to_start(goal, centre.x, weights, style)
    else:
        ways = _onward(goal, weights, style)
    return joined(_name(goal, style), ways, goal, weights) if ways and all(ways) else None


def _name(goal: Pose, style: Style) -> str:
    if abs(goal.heading) < _SAME:
        if abs(goal.y) > _SAME:
            return f"{style.value} change of lane"
        return "straight way" if abs(goal.x) > _SAME else "way in and out"
    return f"{style.value} {'U-turn' if abs(goal.heading - 2 * QUARTER) < _SAME else 'turn'}"


def _onward(goal: Pose, weights: Weights, style: Style) -> Sequence[Way]:
    match style:
        case Style.FREE:
            return [connect(goal, weights.length)]
        case Style.FORWARD_ONLY:
            return [connect_forward(goal, weights.length)]
        case Style.ARC if abs(goal.heading - QUARTER) < _SAME and goal.x > 0 and goal.y > 0:
            radius = min(goal.x, goal.y)
            lines = [(Steady(length, 0.0),) for length in (goal.x - radius, goal.y - radius)]
            circle = (Steady(QUARTER * radius, QUARTER),)
            return [way for way in (lines[0], circle, lines[1]) if way[0].speed > _SAME]
        case _:
            return ()


def _back_to_start(goal: Pose, depth: float, weights: Weights, style: Style) -> Sequence[Way]:
    if abs(goal.heading - 2 * QUARTER) > _SAME:
        return ()
    match style:
        case Style.THREE_POINT:
            return three_point(depth, weights.length)
        case Style.FORWARD_ONLY:
            middle = Pose(depth, 0.0, QUARTER)
            there = connect_forward(middle, weights.length)
            back = connect_forward(goal.seen_from(middle), weights.length)
            return [there + back] if there and back else ()
        case _:
            return ()


def _by_way_of(centre: Pose, goal: Pose) -> Sequence[Way]:
    """Straight to the centre and straight on to the goal, turning on the spot where that is needed."""
    ways: list[Way] = []
    heading = 0.0
    x, y = 0.0, 0.0
    for target in (centre, goal):
        distance = math.hypot(target.x - x, target.y - y)
        if distance > _SAME:
            course = math.atan2(target.y - y, target.x - x)
            # Forwards or backwards, whichever is nearer to how the robot faces, or will have to face.
            facing = heading if target is centre else goal.heading
            sense = 1 if math.cos(course - facing) >= -_SAME else -1
            wanted = heading + math.remainder(course + (0 if sense > 0 else math.pi) - heading, 2 * math.pi)
            ways += [(Steady(0.0, wanted - heading),), (Steady(sense * distance, 0.0),)]
            heading, x, y = wanted, target.x, target.y
    ways.append((Steady(0.0, goal.heading - heading),))
    return [way for way in ways if way[0].rate(Weights()) > _SAME**2]
