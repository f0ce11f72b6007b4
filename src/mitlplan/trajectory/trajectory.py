"""A trajectory: where the robot is, which way it faces and how it is steered, at any time.

It is a chain of pieces, each a motion stretched to its time and put where it belongs. It also knows which
cell the robot is in when. Values change at once at the border between two pieces and are those of the later
one, as a plan's are: the robot is in a cell from the instant at which it crosses into it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan.trajectory.leg import Weights
from mitlplan.trajectory.motion import Motion
from mitlplan.trajectory.pose import Course, Pose, direction
from mitlplan.workspace.motion import Rectangle

Array: TypeAlias = NDArray[np.float64]

_MOST_SAMPLES = 20_000_000
_ROUNDING = 1e-14


@dataclass(frozen=True, slots=True)
class Visit:
    """A stay in a cell, from the instant of crossing into it.

    Parameters
    ----------
    cell
        Its name.
    ground
        Where it lies.
    enter, leave
        Seconds; a `leave` of ``None`` is the end of the trajectory, whenever that is.
    """

    cell: str
    ground: Rectangle
    enter: Fraction
    leave: Fraction | None


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A motion, stretched in time and put in its place.

    Parameters
    ----------
    motion
        In one second, from the origin.
    visit
        The number of the visit that it belongs to.
    begin
        Seconds.
    duration
        Seconds, positive.
    pose
        Where it begins.
    """

    motion: Motion
    visit: int
    begin: Fraction
    duration: Fraction
    pose: Pose


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """A trajectory at many times.

    Parameters
    ----------
    time
        Seconds, ascending.
    course
        Poses and controls.
    visit
        The number of the visit that the robot is on.
    """

    time: Array
    course: Course
    visit: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """What the robot does, from time 0 on.

    Parameters
    ----------
    visits
        The cells, in order; the first begins at time 0.
    pieces
        One after the other, without a gap.
    weights
        What driving and turning cost.
    repeat_from
        ``None``, or the time to which a robot that goes round for ever jumps back at the end.
    """

    visits: tuple[Visit, ...]
    pieces: tuple[Piece, ...]
    weights: Weights
    repeat_from: Fraction | None = None

    @property
    def end(self) -> Fraction:
        """When the last piece ends, in seconds."""
        return self.pieces[-1].begin + self.pieces[-1].duration

    @property
    def last_pose(self) -> Pose:
        """The pose at the end."""
        return self.pieces[-1].pose.then(self.pieces[-1].motion.end)

    @property
    def cost(self) -> float:
        """The integral of the weighted squares of the controls, up to the end."""
        return sum(piece.motion.cost_in(float(piece.duration)) for piece in self.pieces)

    def sample(self, step: Fraction, until: Fraction | None = None) -> Samples:
        """The trajectory at 0, `step`, 2 `step` and so on, and at the end.

        Parameters
        ----------
        step
            Seconds.
        until
            Where to stop, in seconds; ``None``: at the end. A trajectory that goes round can be asked for
            later times, another stays where it ended.

        Raises
        ------
        ValueError
            If `step` is not positive, or so small that there are too many samples.
        """
        last = self.end if until is None else until
        if step <= 0 or last < 0 or last / step > _MOST_SAMPLES:
            raise ValueError(f"steps of {step} s up to {last} s are not positive or too many")
        count = math.floor(last / step) + 1
        # Quotients of whole numbers, so that the sample at a crossing falls on the crossing.
        times = np.arange(count, dtype=np.float64) * step.numerator / step.denominator
        if (count - 1) * step < last:
            times = np.append(times, float(last))
        return self.sample_at(times)

    def sample_at(self, times: Array) -> Samples:
        """The trajectory at `times`, in seconds, ascending and none negative."""
        inner, turned = self._wrapped(np.asarray(times, dtype=np.float64))
        begins = np.array([float(piece.begin) for piece in self.pieces])
        # A time of a later round is rounded when it is brought back; what then falls on a border is past it.
        rounding = np.where(inner < times, _ROUNDING * (1 + np.abs(times)), 0.0)
        number = np.maximum(np.searchsorted(begins, inner + rounding, side="right") - 1, 0)
        durations = np.array([float(piece.duration) for piece in self.pieces])[number]
        course = self._course(number, np.clip((inner - begins[number]) / durations, 0.0, 1.0))
        pace = 1 / durations
        if self.repeat_from is None:
            pace = pace * (inner < float(self.end))
        visit = np.array([piece.visit for piece in self.pieces])[number]
        course = replace(course, heading=course.heading + turned, u=course.u * pace, w=course.w * pace)
        return Samples(np.asarray(times, dtype=np.float64), course, visit)

    def _wrapped(self, times: Array) -> tuple[Array, Array]:
        """The times of the first round, and by how much the robot has turned in the rounds since."""
        if self.repeat_from is None:
            return times, np.zeros(times.shape)
        first, end = float(self.repeat_from), float(self.end)
        rounds = np.where(times < end, 0.0, np.floor((times - first) / (end - first)))
        begin = next(piece.pose for piece in self.pieces if piece.begin == self.repeat_from)
        return times - rounds * (end - first), rounds * (self.last_pose.heading - begin.heading)

    def _course(self, number: NDArray[np.int64], share: Array) -> Course:
        """What the pieces of that `number` do; each motion is evaluated once, for all pieces that use it."""
        rows = np.zeros((5, len(share)))
        motion_of, motions = self._motions()
        for index, motion in motions.items():
            here = motion_of[number] == index
            if here.any():
                course = motion.course(share[here])
                rows[:, here] = course.x, course.y, course.heading, course.u, course.w
        poses = [piece.pose for piece in self.pieces]
        places = np.array([(pose.x, pose.y, pose.heading, *direction(pose.heading)) for pose in poses])
        return Course(*rows).moved(*places[number].T)

    def _motions(self) -> tuple[NDArray[np.int64], Mapping[int, Motion]]:
        """For each piece the index of its motion, and the motions."""
        index: dict[int, int] = {}
        motions: dict[int, Motion] = {}
        of_piece = []
        for piece in self.pieces:
            place = index.setdefault(id(piece.motion), len(index))
            motions[place] = piece.motion
            of_piece.append(place)
        return np.array(of_piece), motions
