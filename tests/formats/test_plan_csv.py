from __future__ import annotations

import csv
import io
from fractions import Fraction

from mitlplan.formats.plan_csv import plan_to_csv
from mitlplan.plan import Infeasible, LimitReached, Loop, Plan, Step

STEPS = (
    Step("pos0", Fraction(0), Fraction(1), (), Fraction(1, 2)),
    Step('a "b", c', Fraction(1), Fraction(7, 2), ("A", "B"), None),
)


def test_a_finite_plan_whole() -> None:
    assert plan_to_csv(Plan(STEPS, Fraction(7, 2))) == (
        'step,cell,enter,leave,holds,slack,next\n0,pos0,0,1,,1/2,1\n1,"a ""b"", c",1,7/2,A B,,\n'
    )


def test_a_loop_and_a_parking_plan_say_what_comes_next() -> None:
    loop = Plan(STEPS, Fraction(7, 2), Loop(0, Fraction(7, 2)))
    parks = Plan((STEPS[0], Step("pos3", Fraction(1), None)), Fraction(1), Loop(1, None))
    assert [row["next"] for row in csv.DictReader(io.StringIO(plan_to_csv(loop)))] == ["1", "0"]
    rows = list(csv.DictReader(io.StringIO(plan_to_csv(parks))))
    assert [(row["next"], row["leave"]) for row in rows] == [("1", "1"), ("1", "")]


def test_no_plan_is_the_header_alone() -> None:
    header = "step,cell,enter,leave,holds,slack,next\n"
    assert plan_to_csv(Infeasible("Too far.")) == header
    assert plan_to_csv(LimitReached("Out of time.")) == header
