"""What a real robot can do, and how fast it can therefore be.

The limits are on absolute values: a robot drives backwards as fast as forwards. A motion stretched to T
seconds has its speeds divided by T and its accelerations by T squared, so the least time of a motion is
plain from the greatest values of the motion that takes a second. Where controls jump no acceleration
suffices: a robot with such a limit needs a profile from rest to rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from mitlplan.errors import TrajectoryError
from mitlplan.trajectory.leg import EQUAL_WEIGHTS, Weights
from mitlplan.trajectory.motion import Style
from mitlplan.trajectory.passage import Choice, Passage, choose, passage
from mitlplan.trajectory.pose import Pose
from mitlplan.trajectory.profile import Profile
from mitlplan.workspace.motion import Door, Rectangle

_SLACK = 1e-9
"""Relative: a limit that is kept but for rounding is kept."""


@dataclass(frozen=True, slots=True)
class Robot:
    """The limits of a robot; ``None`` is no limit.

    Parameters
    ----------
    speed
        Metres a second.
    turn_rate
        Radians a second.
    acceleration
        Metres a second squared.
    turn_acceleration
        Radians a second squared.
    radius
        Of the disc that covers the robot, in metres.

    Raises
    ------
    TrajectoryError
        If a limit is not positive, or the radius is negative.
    """

    speed: Fraction | None = None
    turn_rate: Fraction | None = None
    acceleration: Fraction | None = None
    turn_acceleration: Fraction | None = None
    radius: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        for name in ("speed", "turn_rate", "acceleration", "turn_acceleration"):
            limit = getattr(self, name)
            if limit is not None and limit <= 0:
                raise TrajectoryError(f"the robot's {name} is {limit}; a limit is a positive number")
        if self.radius < 0:
            raise TrajectoryError(f"the robot's radius is {self.radius}; it is 0 or positive")


@dataclass(frozen=True, slots=True)
class Driving:
    """How the robot is driven.

    Parameters
    ----------
    weights
        Of the cost.
    turn, u_turn
        The style of turns and of U-turns, where the robot fits and can drive so; otherwise, and if they are
        ``None``, the cheapest that it can.
    profile
        How motions are run through; the cubic and the quintic one begin and end every stroke at rest.
    reverse
        Whether the robot may cross from cell to cell backwards.
    """

    weights: Weights = EQUAL_WEIGHTS
    turn: Style | None = None
    u_turn: Style | None = None
    profile: Profile = Profile.EVEN
    reverse: bool = False

    def __post_init__(self) -> None:
        if self.turn is Style.THREE_POINT:
            raise TrajectoryError("a three-point turn is a U-turn; turns are free, forward-only, arc or spot")
        if self.u_turn in (Style.FREE, Style.ARC):
            raise TrajectoryError(
                "a U-turn is three-point, forward-only or spot: others never enter the cell"
            )


UNLIMITED_ROBOT = Robot()
"""A point that can do anything."""

CHEAPEST_DRIVING = Driving()
"""Equal weights, the cheapest motions, always ahead from cell to cell."""


def choices(way: Passage, driving: Driving) -> Iterator[Choice]:
    """The motions through `way`, the one asked for first, then the cheapest, each found when it is needed."""
    for style in _styles(way, driving):
        choice = choose(way, style, driving.weights, driving.profile)
        if choice is not None:
            yield choice


def least_time(choice: Choice, robot: Robot) -> float:
    """The least time, in seconds, that the limits of `robot` leave to a motion."""
    return max(need for need, _ in _needs(choice, robot))


def obstacle(choice: Choice, duration: float, robot: Robot) -> str:
    """What keeps `robot` from driving a motion in `duration` seconds; empty if nothing does."""
    if choice.clearance < float(robot.radius) - _SLACK:
        return (
            f"a robot of radius {_shown(robot.radius)} m does not fit: "
            f"the {choice.motion.name} comes as near as {choice.clearance:.3g} m to a wall"
        )
    need, limit = max(_needs(choice, robot))
    if math.isinf(need):
        return f"the {limit} cannot be kept where the controls jump; ask for a profile from rest to rest"
    if need > duration * (1 + _SLACK):
        return f"the {choice.motion.name} takes {need:.4g} s because of the {limit}, but has {duration:.4g} s"
    return ""


def _needs(choice: Choice, robot: Robot) -> Iterator[tuple[float, str]]:
    yield 0.0, "nothing"
    limits = (
        ("speed", "m/s", robot.speed, choice.speed, 1),
        ("turn rate", "rad/s", robot.turn_rate, choice.turn_rate, 1),
        ("acceleration", "m/s^2", robot.acceleration, choice.acceleration, 2),
        ("turn acceleration", "rad/s^2", robot.turn_acceleration, choice.turn_acceleration, 2),
    )
    for name, unit, limit, greatest, power in limits:
        if limit is not None:
            yield (greatest / float(limit)) ** (1 / power), f"{name} limit of {_shown(limit)} {unit}"


def _shown(number: Fraction) -> str:
    return f"{float(number):g}"


def _styles(way: Passage, driving: Driving) -> tuple[Style, ...]:
    """What was asked for, and then from the least restricted to the most, so from the cheapest on."""
    if way.goal is None:
        return (Style.FREE, Style.SPOT)
    step = way.goal.seen_from(way.begin)
    every: tuple[Style, ...] = (Style.FREE, Style.FORWARD_ONLY, Style.ARC, Style.SPOT)
    asked = driving.turn
    if math.hypot(step.x, step.y) < _SLACK:
        every, asked = (Style.THREE_POINT, Style.FORWARD_ONLY, Style.SPOT), driving.u_turn
    return every if asked is None else (asked, *(style for style in every if style is not asked))


# --------------------------------------------------------------------------------------------- travel times


@dataclass(frozen=True, slots=True)
class DrivenTimes:
    """The travel times of a robot, for :func:`mitlplan.workspace.motion.with_headings` and its sister.

    Parameters
    ----------
    robot
        With a speed.
    driving
        How it is driven.
    resolution
        Times are rounded up to multiples of it, in seconds.

    Raises
    ------
    TrajectoryError
        If the robot has no speed, or does not fit through a cell.

    Examples
    --------
    >>> times = DrivenTimes(Robot(speed=Fraction(1, 2)))
    >>> cell = Rectangle(0.0, 0.0, 1.0, 1.0)
    >>> times.through(cell, Door(-0.5, 0.0, 0.0, 1.0), Door(0.5, 0.0, 0.0, 1.0))
    Fraction(2, 1)
    """

    robot: Robot
    driving: Driving = CHEAPEST_DRIVING
    resolution: Fraction = Fraction(1, 1000)

    def __post_init__(self) -> None:
        if self.robot.speed is None:
            raise TrajectoryError("travel times need the robot's speed")

    def through(self, cell: Rectangle, entry: Door, leave: Door) -> Fraction:
        """From one door of `cell` to another, or back to the same."""
        goal = Pose(leave.x, leave.y, leave.heading)
        return self._time(passage(cell, Pose(entry.x, entry.y, entry.heading), goal, (entry, leave)))

    def out_of(self, cell: Rectangle, heading: float | None, leave: Door) -> Fraction:
        """From the centre of `cell`, facing `heading` (``None``: facing as it likes), to a door."""
        goal = Pose(leave.x, leave.y, leave.heading)
        begin = Pose(cell.x, cell.y, leave.heading if heading is None else heading)
        return self._time(passage(cell, begin, goal, (leave,)))

    def _time(self, way: Passage) -> Fraction:
        refused = "no motion stays inside"
        for choice in choices(way, self.driving):
            refused = obstacle(choice, math.inf, self.robot)
            if not refused:
                ticks = least_time(choice, self.robot) / float(self.resolution)
                return math.ceil(ticks * (1 - _SLACK)) * self.resolution
        raise TrajectoryError(f"a cell of {way.width:g} m by {way.height:g} m cannot be crossed: {refused}")
