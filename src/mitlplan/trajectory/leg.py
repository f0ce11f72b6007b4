"""Legs: the pieces of which motions are made, each at a constant rate of cost.

The unicycle x' = u cos th, y' = u sin th, th' = w moves at least cost, the integral of r1 u^2 + r2 w^2, where
u = p cos(th - b) and th'' = (r1/r2) p^2/2 sin 2(th - b): a pendulum in 2(th - b) (Moiseev and Sachkov, ESAIM:
COCV 16(2), 2010). With L = sqrt(r2/r1) as the unit of length both weights are 1, and w^2 + u^2 is constant.
A pendulum that goes round is :class:`Rotating`: w keeps its sign; one that swings is :class:`Oscillating`:
w changes it. Standing, driving straight, turning on the spot and circles are :class:`Steady`.

Every leg begins at the origin with heading 0. Times are floats in seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias, Union

import numpy as np
from numpy.typing import NDArray

from mitlplan.trajectory.elliptic import Modulus
from mitlplan.trajectory.pose import Course, Pose

Array: TypeAlias = NDArray[np.float64]
Slopes: TypeAlias = tuple[Array, Array]

_NOTHING = 1e-50
"""What is smaller is taken for 0, so that squares and quotients of it stay numbers."""


@dataclass(frozen=True, slots=True)
class Weights:
    """What driving and turning cost: the integral of ``linear * u**2 + angular * w**2``.

    Parameters
    ----------
    linear, angular
        The paper's r1 and r2; both positive. Only ``linear * cell**2 / angular`` shapes a motion.
    """

    linear: float = 1.0
    angular: float = 1.0

    def __post_init__(self) -> None:
        if not (0 < self.linear < math.inf and 0 < self.angular < math.inf):
            raise ValueError("the weights of speed and turn rate are positive numbers")

    @property
    def length(self) -> float:
        """The length, in metres, that costs as much to drive as a radian costs to turn."""
        return math.sqrt(self.angular / self.linear)


EQUAL_WEIGHTS = Weights()
"""The paper's: a metre costs as much as a radian."""


@dataclass(frozen=True, slots=True)
class Steady:
    """Constant controls: a straight line, a circle, a turn on the spot, or standing still.

    Parameters
    ----------
    speed, turn_rate
        Metres and radians a second.
    duration
        Seconds.
    """

    speed: float
    turn_rate: float
    duration: float = 1.0

    def course(self, time: Array) -> Course:
        """Poses and controls at `time`."""
        turned = self.turn_rate * time
        chord = self.speed * time * np.sinc(turned / (2 * np.pi))
        ones = np.ones_like(turned)
        x, y = chord * np.cos(turned / 2), chord * np.sin(turned / 2)
        return Course(x, y, turned, self.speed * ones, self.turn_rate * ones)

    def slopes(self, time: Array) -> Slopes:
        """The derivatives of u and w at `time`."""
        return np.zeros_like(time), np.zeros_like(time)

    def rate(self, weights: Weights) -> float:
        """The cost a second."""
        return weights.linear * self.speed**2 + weights.angular * self.turn_rate**2

    def scaled(self, factor: float) -> Steady:
        """The same path in `factor` times the time."""
        return Steady(self.speed / factor, self.turn_rate / factor, self.duration * factor)

    @property
    def backward(self) -> Steady:
        """The leg with ahead and behind exchanged: the way turned half around, the headings as they were."""
        return replace(self, speed=-self.speed)

    @property
    def retraced(self) -> Steady:
        """The leg with its controls in the opposite order of time."""
        return self

    @property
    def mirrored(self) -> Steady:
        """The leg with left and right exchanged."""
        return replace(self, turn_rate=-self.turn_rate)


@dataclass(frozen=True, slots=True)
class Rotating:
    """An extremal on which the turn rate keeps its sign.

    Parameters
    ----------
    length
        The unit of length L of the weights.
    modulus
        Of the elliptic functions.
    phase
        The argument of the elliptic functions at the start.
    pace
        By how much the argument grows a second: the square root of the canonical rate of cost.
    sense
        1 to turn left, -1 to turn right.
    duration
        Seconds.
    """

    length: float
    modulus: Modulus
    phase: float
    pace: float
    sense: int
    duration: float = 1.0

    def course(self, time: Array) -> Course:
        """Poses and controls at `time`."""
        angle, start, area = self._progress(time)
        width, start_width = self.modulus.delta(angle), self.modulus.delta(start)
        x, y = _aligned(area, (np.cos(angle) ** 2 - np.cos(start) ** 2) / (width + start_width), start)
        stretch = self.length * self.modulus.root
        return Course(
            stretch * x,
            self.sense * stretch * y,
            self.sense * (angle - start),
            stretch * self.pace * np.sin(angle),
            self.sense * self.pace * width,
        )

    def slopes(self, time: Array) -> Slopes:
        """The derivatives of u and w at `time`."""
        angle, _, _ = self._progress(time)
        steepest = self.modulus.root * self.pace**2 * np.cos(angle)
        return (
            self.length * steepest * self.modulus.delta(angle),
            -self.sense * steepest * self.modulus.root * np.sin(angle),
        )

    def _progress(self, time: Array) -> tuple[Array, Array, Array]:
        """The amplitude, that at the start, and the integral of sn^2 between them."""
        angle, area = self.modulus.amplitude(self.phase + self.pace * time)
        start, start_area = self.modulus.amplitude(np.asarray(self.phase))
        return angle, start, area - start_area

    def rate(self, weights: Weights) -> float:
        """The cost a second."""
        return weights.angular * self.pace**2

    def scaled(self, factor: float) -> Rotating:
        """The same path in `factor` times the time."""
        return replace(self, pace=self.pace / factor, duration=self.duration * factor)

    @property
    def backward(self) -> Rotating:
        """The leg with ahead and behind exchanged: the way turned half around, the headings as they were."""
        return replace(self, phase=self.phase + 2 * self.modulus.quarter_period)

    @property
    def retraced(self) -> Rotating:
        """The leg with its controls in the opposite order of time."""
        last = self.phase + self.pace * self.duration
        return replace(self, phase=2 * self.modulus.quarter_period - last)

    @property
    def mirrored(self) -> Rotating:
        """The leg with left and right exchanged."""
        return replace(self, sense=-self.sense)


@dataclass(frozen=True, slots=True)
class Oscillating:
    """An extremal on which the turn rate changes its sign, sooner or later.

    Parameters
    ----------
    length
        The unit of length L of the weights.
    modulus
        Of the elliptic functions.
    phase
        The argument of the elliptic functions at the start.
    pace
        By how much the argument grows a second: the canonical momentum p.
    sense
        1, or -1 for the mirrored leg.
    duration
        Seconds.
    """

    length: float
    modulus: Modulus
    phase: float
    pace: float
    sense: int
    duration: float = 1.0

    def course(self, time: Array) -> Course:
        """Poses and controls at `time`."""
        angle, start, area = self._progress(time)
        lean, start_lean = self._lean(angle), self._lean(start)
        root = self.modulus.root
        x, y = _aligned(root**2 * area, root * (np.cos(angle) - np.cos(start)), start_lean)
        return Course(
            self.length * x,
            self.sense * self.length * y,
            self.sense * (lean - start_lean),
            self.length * self.pace * root * np.sin(angle),
            self.sense * self.pace * root * np.cos(angle),
        )

    def slopes(self, time: Array) -> Slopes:
        """The derivatives of u and w at `time`."""
        angle, _, _ = self._progress(time)
        steepest = self.pace**2 * self.modulus.root * self.modulus.delta(angle)
        return self.length * steepest * np.cos(angle), -self.sense * steepest * np.sin(angle)

    def _progress(self, time: Array) -> tuple[Array, Array, Array]:
        """The amplitude, that at the start, and the integral of sn^2 between them."""
        angle, area = self.modulus.amplitude(self.phase + self.pace * time)
        start, start_area = self.modulus.amplitude(np.asarray(self.phase))
        return angle, start, area - start_area

    def _lean(self, angle: Array) -> Array:
        """The heading from the one at which u vanishes."""
        return np.asarray(np.arctan2(self.modulus.root * np.sin(angle), self.modulus.delta(angle)))

    def rate(self, weights: Weights) -> float:
        """The cost a second."""
        return weights.angular * (self.pace * self.modulus.root) ** 2

    def scaled(self, factor: float) -> Oscillating:
        """The same path in `factor` times the time."""
        return replace(self, pace=self.pace / factor, duration=self.duration * factor)

    @property
    def backward(self) -> Oscillating:
        """The leg with ahead and behind exchanged: the way turned half around, the headings as they were."""
        return replace(self, phase=self.phase + 2 * self.modulus.quarter_period, sense=-self.sense)

    @property
    def retraced(self) -> Oscillating:
        """The leg with its controls in the opposite order of time."""
        last = self.phase + self.pace * self.duration
        return replace(self, phase=2 * self.modulus.quarter_period - last, sense=-self.sense)

    @property
    def mirrored(self) -> Oscillating:
        """The leg with left and right exchanged."""
        return replace(self, sense=-self.sense)


Leg: TypeAlias = Union[Steady, Rotating, Oscillating]


def _aligned(along: Array, across: Array, start: Array) -> tuple[Array, Array]:
    """From the axes of the momentum to those of the robot at the start."""
    sine, cosine = np.sin(start), np.cos(start)
    return sine * along - cosine * across, cosine * along + sine * across


def end_of(leg: Leg) -> Pose:
    """The pose at the end of `leg`, from the origin with heading 0."""
    course = leg.course(np.asarray(leg.duration))
    return Pose(float(course.x), float(course.y), float(course.heading))


def extremal(speed: float, across: float, turn_rate: float, length: float, duration: float = 1.0) -> Leg:
    """The extremal with the given start.

    Parameters
    ----------
    speed
        u at the start, in metres a second.
    across
        The momentum to the left at the start, as the speed u that the robot would have if it faced that way.
    turn_rate
        w at the start, in radians a second.
    length
        The unit of length of the weights, in metres.
    duration
        Seconds.

    Examples
    --------
    >>> extremal(1.0, 0.0, 0.0, length=1.0)
    Steady(speed=1.0, turn_rate=0.0, duration=1.0)
    """
    speed, across, turn_rate = (
        0.0 if abs(value) < _NOTHING else value for value in (speed, across, turn_rate)
    )
    # Both equilibria of the pendulum, and no pendulum at all.
    if (across == 0 and turn_rate == 0) or (speed == 0 and (across == 0 or turn_rate == 0)):
        return Steady(speed, turn_rate, duration)
    ahead, aside = speed / length, across / length
    momentum, pace = math.hypot(ahead, aside), math.hypot(ahead, turn_rate)
    # pace^2 - momentum^2, the sign of which tells the two kinds apart, without cancellation.
    excess = (abs(turn_rate) - abs(aside)) * (abs(turn_rate) + abs(aside))
    if excess >= 0:
        sense = 1 if turn_rate >= 0 else -1
        modulus = Modulus(momentum / pace, excess / pace**2)
        phase = modulus.argument(math.atan2(ahead, sense * aside))
        return Rotating(length, modulus, phase, pace, sense, duration)
    sense = 1 if aside >= 0 else -1
    modulus = Modulus(pace / momentum, -excess / momentum**2)
    phase = modulus.argument(math.atan2(ahead, sense * turn_rate))
    return Oscillating(length, modulus, phase, momentum, sense, duration)
