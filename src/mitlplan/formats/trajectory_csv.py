"""Trajectories as CSV: time, pose and controls, a line for each sample.

Times are in seconds, lengths in metres, ``theta`` in radians and never wrapped, ``u`` in metres and ``w`` in
radians a second. Numbers are written with all their digits, so reading them gives back the same floats.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from mitlplan.trajectory import Trajectory

COLUMNS = ("t", "x", "y", "theta", "u", "w")


def trajectory_to_csv(trajectory: Trajectory, step: Fraction, until: Fraction | None = None) -> str:
    """The samples of `trajectory`.

    Parameters
    ----------
    trajectory
        What to write.
    step, until
        Seconds, as in :meth:`mitlplan.trajectory.Trajectory.sample`.

    Raises
    ------
    ValueError
        If there are no samples at such a step, or too many.

    Examples
    --------
    >>> from mitlplan.plan import Plan, Step
    >>> from mitlplan.trajectory import follow
    >>> from mitlplan.workspace import grid
    >>> steps = (Step("r0c0", Fraction(0), Fraction(1)), Step("r0c1", Fraction(1), Fraction(1)))
    >>> trajectory = follow(Plan(steps, makespan=Fraction(1)), grid(1, 2))
    >>> print(trajectory_to_csv(trajectory, Fraction(1, 2)), end="")
    t,x,y,theta,u,w
    0.0,0.5,0.5,0.0,0.5,0.0
    0.5,0.75,0.5,0.0,0.5,0.0
    1.0,1.0,0.5,0.0,1.0,0.0
    1.5,1.5,0.5,0.0,0.0,0.0
    """
    samples = trajectory.sample(step, until)
    course = samples.course
    # Adding 0.0 makes -0.0 a 0.0.
    rows = np.column_stack([samples.time, course.x, course.y, course.heading, course.u, course.w]) + 0.0
    lines = [",".join(COLUMNS), *(",".join(map(repr, row)) for row in rows.tolist())]
    return "\n".join(lines) + "\n"
