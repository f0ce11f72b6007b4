"""Trajectories as JSON: which motion when, and samples of poses and controls.

What the plan fixes exactly is written as text, ``"7/2"``; what is computed in floats is a number. The units
are those of the CSV.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np

from mitlplan.formats.trajectory_csv import COLUMNS
from mitlplan.trajectory import Trajectory


def trajectory_to_mapping(
    trajectory: Trajectory, step: Fraction, until: Fraction | None = None
) -> dict[str, Any]:
    """What the JSON of `trajectory` holds.

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
    """
    samples = trajectory.sample(step, until)
    course = samples.course
    columns = (samples.time, course.x, course.y, course.heading, course.u, course.w)
    return {
        "mitlplan": 1,
        "status": "trajectory",
        "end": str(trajectory.end),
        "repeat_from": None if trajectory.repeat_from is None else str(trajectory.repeat_from),
        "cost": trajectory.cost,
        "weights": {"linear": trajectory.weights.linear, "angular": trajectory.weights.angular},
        "cells": [
            {
                "cell": visit.cell,
                "enter": str(visit.enter),
                "leave": None if visit.leave is None else str(visit.leave),
            }
            for visit in trajectory.visits
        ],
        "motions": [
            {
                "name": piece.motion.name,
                "cell": trajectory.visits[piece.visit].cell,
                "begin": str(piece.begin),
                "duration": str(piece.duration),
                "x": piece.pose.x,
                "y": piece.pose.y,
                "theta": piece.pose.heading,
                "cost": piece.motion.cost_in(float(piece.duration)),
            }
            for piece in trajectory.pieces
        ],
        "step": str(step),
        # Adding 0.0 makes -0.0 a 0.0.
        "samples": {
            name: (np.asarray(column) + 0.0).tolist() for name, column in zip(COLUMNS, columns, strict=True)
        },
    }


def trajectory_to_json(trajectory: Trajectory, step: Fraction, until: Fraction | None = None) -> str:
    """The JSON of `trajectory`, a line for each cell, motion and column.

    Parameters and errors are those of :func:`trajectory_to_mapping`.

    Examples
    --------
    >>> from mitlplan.plan import Plan, Step
    >>> from mitlplan.trajectory import follow
    >>> from mitlplan.workspace import grid
    >>> steps = (Step("r0c0", Fraction(0), Fraction(1)), Step("r0c1", Fraction(1), Fraction(1)))
    >>> trajectory = follow(Plan(steps, makespan=Fraction(1)), grid(1, 2))
    >>> json.loads(trajectory_to_json(trajectory, Fraction(1, 2)))["samples"]["x"]
    [0.5, 0.75, 1.0, 1.5]
    """
    entries = []
    for key, value in trajectory_to_mapping(trajectory, step, until).items():
        match key:
            case "cells" | "motions":
                rows = [json.dumps(row, ensure_ascii=False) for row in value]
                entries.append(f'"{key}": [\n  ' + ",\n  ".join(rows) + "]")
            case "samples":
                columns = [f"{json.dumps(name)}: {json.dumps(column)}" for name, column in value.items()]
                entries.append('"samples": {\n  ' + ",\n  ".join(columns) + "}")
            case _:
                entries.append(f"{json.dumps(key)}: {json.dumps(value)}")
    return "{" + ",\n ".join(entries) + "}\n"
