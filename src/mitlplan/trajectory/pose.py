"""Poses in the plane, and what a robot does along a stretch of time.

Headings are angles in radians, counted from the x axis to the left, and never wrapped: a robot that has
turned once has a heading greater by a full turn, so that headings are continuous in time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias, Union

import numpy as np
from numpy.typing import NDArray

_Place: TypeAlias = Union[float, NDArray[np.float64]]

QUARTER = math.pi / 2
"""A quarter turn to the left, in radians."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a robot is and where it faces.

    Parameters
    ----------
    x, y
        Metres.
    heading
        Radians.

    Examples
    --------
    >>> Pose(1.0, 2.0, QUARTER).then(Pose(3.0, 0.0, 0.0))
    Pose(x=1.0, y=5.0, heading=1.5707963267948966)
    """

    x: float
    y: float
    heading: float

    def then(self, step: Pose) -> Pose:
        """The pose reached by `step`, which is given as seen from this pose."""
        cosine, sine = direction(self.heading)
        return Pose(
            self.x + cosine * step.x - sine * step.y,
            self.y + sine * step.x + cosine * step.y,
            self.heading + step.heading,
        )

    def seen_from(self, frame: Pose) -> Pose:
        """What `frame` makes of the pose: ``frame.then(pose.seen_from(frame))`` is the pose again."""
        cosine, sine = direction(frame.heading)
        east, north = self.x - frame.x, self.y - frame.y
        return Pose(
            cosine * east + sine * north,
            cosine * north - sine * east,
            self.heading - frame.heading,
        )

    @property
    def turned_around(self) -> Pose:
        """The pose with ahead and behind exchanged: the place opposite, the heading as it was."""
        return Pose(-self.x, -self.y, self.heading)

    @property
    def mirrored(self) -> Pose:
        """The pose with left and right exchanged."""
        return Pose(self.x, -self.y, -self.heading)


ORIGIN = Pose(0.0, 0.0, 0.0)


def direction(heading: float) -> tuple[float, float]:
    """Cosine and sine, exactly 0 and 1 at quarter turns, so that straight lines stay straight.

    Examples
    --------
    >>> direction(3 * QUARTER)
    (0.0, -1.0)
    """
    quarters = heading / QUARTER
    nearest = round(quarters)
    if abs(quarters - nearest) < 1e-12:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return math.cos(heading), math.sin(heading)


@dataclass(frozen=True, eq=False, slots=True)
class Course:
    """Poses and controls at many times: float arrays of one shape.

    Parameters
    ----------
    x, y
        Metres.
    heading
        Radians.
    u, w
        Speed in metres a second, negative when driving backwards, and turn rate in radians a second.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    heading: NDArray[np.float64]
    u: NDArray[np.float64]
    w: NDArray[np.float64]

    def placed(self, start: Pose) -> Course:
        """The course of a robot that begins at `start` instead of the origin."""
        return self.moved(start.x, start.y, start.heading, *direction(start.heading))

    def moved(self, x: _Place, y: _Place, heading: _Place, cosine: _Place, sine: _Place) -> Course:
        """The course turned by `heading`, of that cosine and sine, and then shifted; each may be an array."""
        return Course(
            x + cosine * self.x - sine * self.y,
            y + sine * self.x + cosine * self.y,
            heading + self.heading,
            self.u,
            self.w,
        )
