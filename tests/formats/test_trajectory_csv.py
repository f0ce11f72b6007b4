from __future__ import annotations

import csv
import io
from fractions import Fraction

import numpy as np
import pytest

from mitlplan.formats.trajectory_csv import COLUMNS, trajectory_to_csv
from mitlplan.trajectory import follow
from mitlplan.workspace import grid
from tests.trajectory.strategies import plan_of

ROUND_THE_SQUARE = follow(plan_of(["r0c0", "r0c1", "r1c1", "r1c0"], [Fraction(1)] * 3), grid(2, 2))


def test_every_digit_comes_back() -> None:
    text = trajectory_to_csv(ROUND_THE_SQUARE, Fraction(1, 30))
    header, *rows = csv.reader(io.StringIO(text))
    assert tuple(header) == COLUMNS
    read = np.array(rows, dtype=float)
    samples = ROUND_THE_SQUARE.sample(Fraction(1, 30))
    course = samples.course
    for column, expected in zip(
        read.T, (samples.time, course.x, course.y, course.heading, course.u, course.w), strict=True
    ):
        assert (column == expected).all()


def test_there_is_a_line_for_each_crossing_that_the_step_meets() -> None:
    times = [line.split(",")[0] for line in trajectory_to_csv(ROUND_THE_SQUARE, Fraction(1, 3)).splitlines()]
    assert {"1.0", "2.0", "3.0", "3.5"} <= set(times)


@pytest.mark.parametrize("step", [Fraction(0), Fraction(-1), Fraction(1, 10**9)])
def test_steps_that_make_no_sense(step: Fraction) -> None:
    with pytest.raises(ValueError, match="not positive or too many"):
        trajectory_to_csv(ROUND_THE_SQUARE, step)


def test_a_loop_can_be_followed_for_longer() -> None:
    forever = follow(plan_of(["r0c0", "r0c1"], [Fraction(1)] * 2, loop=0), grid(1, 2))
    lines = trajectory_to_csv(forever, Fraction(1, 2), Fraction(20)).splitlines()
    assert len(lines) == 42
    assert lines[3].split(",")[1:3] == lines[7].split(",")[1:3] == lines[-1].split(",")[1:3]
