from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.check import check, signal_of
from mitlplan.logic.signal import Segment, Signal
from mitlplan.mission import Mission, mission_from_mapping
from mitlplan.plan import Loop, Plan, Step


def stay(cell: str, enter: int | str, leave: int | str | None, *holds: str) -> Step:
    return Step(cell, Fraction(enter), None if leave is None else Fraction(leave), holds)


def mission(spec: dict[str, str], *, waiting: bool = False, **keys: str) -> Mission:
    cells = {"pos0": [], "pos1": ["B"], "pos2": [], "pos3": ["A"]}
    ring = [("pos0", "pos1"), ("pos1", "pos2"), ("pos2", "pos3"), ("pos3", "pos0")]
    moves = [{"from": one, "to": other, "time": 1, "both": True} for one, other in ring]
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {"graph": {"cells": cells, "moves": moves, "waiting": waiting}},
            "robot": {"start": "pos0"},
            "spec": spec,
            **keys,
        }
    )


VISITS = Plan(
    (stay("pos0", 0, 1), stay("pos1", 1, 2, "B"), stay("pos2", 2, 3), stay("pos3", 3, 3, "A")),
    makespan=Fraction(3),
)
TO_AND_FRO = Plan((stay("pos0", 0, 1), stay("pos3", 1, 2, "A")), Fraction(2), Loop(0, Fraction(2)))
PARKS = Plan((stay("pos0", 0, 1), stay("pos3", 1, None, "A")), Fraction(1), Loop(1, None))


@pytest.mark.parametrize(
    ("spec", "plan", "waiting"),
    [
        ({"order": "!A U B", "visit": "F A"}, VISITS, False),
        ({"patrol": "G F[0,2] A"}, TO_AND_FRO, False),
        ({"never": "G !B", "visit": "F A"}, PARKS, True),
        ({"rest": "F G A"}, PARKS, True),
    ],
)
def test_plans_that_pass(spec: dict[str, str], plan: Plan, waiting: bool) -> None:
    assert check(mission(spec, waiting=waiting), plan) is None


def test_the_first_violated_requirement_is_named_with_the_reason() -> None:
    found = check(mission({"visit": "F A", "soon": "F[0,2] A"}), VISITS)
    assert found == ("the requirement soon is violated: F[0,2] A does not hold at 0: A never holds in [0,2].")


def test_a_fault_on_the_map_comes_before_the_formula() -> None:
    steps = (stay("pos0", 0, 1), stay("pos2", 1, 1))
    assert check(mission({"never": "false"}), Plan(steps, Fraction(1))) == (
        "steps[0] (pos0): no move leads from pos0 to pos2"
    )


@pytest.mark.parametrize(
    ("plan", "fault"),
    [
        (replace(VISITS, makespan=Fraction(2)), "the plan takes 3, not its makespan 2"),
        (replace(PARKS, makespan=Fraction(2)), "the plan takes 1, not its makespan 2"),
        (
            replace(VISITS, makespan=Fraction(2), attained=False, epsilon=Fraction(1, 2)),
            "the plan takes 3, which is not within 1/2 above the infimum 2",
        ),
        (
            replace(VISITS, makespan=Fraction(4), attained=False, epsilon=Fraction(1)),
            "the plan takes 3, which is not within 1 above the infimum 4",
        ),
        (replace(VISITS, makespan=Fraction(5, 2), attained=False, epsilon=Fraction(1, 2)), None),
    ],
)
def test_the_makespan_is_the_plans(plan: Plan, fault: str | None) -> None:
    assert check(mission({"any": "F A"}, waiting=True), plan) == fault


def test_the_missions_until_and_horizon_count() -> None:
    straight = Plan((stay("pos0", 0, 1), stay("pos1", 1, 1, "B")), Fraction(1))
    assert check(mission({"order": "!B U B"}), straight) is None
    assert check(mission({"order": "!B U B"}, until="closed"), straight) is not None
    assert check(mission({"always": "G !A"}, horizon="finite"), straight) is None
    assert check(mission({"always": "G !A"}), straight) is not None


def test_the_signals_of_the_three_kinds_of_plan() -> None:
    nothing, a, b = frozenset[str](), frozenset("A"), frozenset("B")
    times = [Segment(Fraction(time), holds) for time, holds in enumerate((nothing, b, nothing, a))]
    assert signal_of(VISITS.steps) == Signal(tuple(times), Fraction(3))
    short = (Segment(Fraction(0), nothing), Segment(Fraction(1), a))
    assert signal_of(TO_AND_FRO.steps, TO_AND_FRO.loop) == Signal(short, Fraction(2), Fraction(0))
    assert signal_of(PARKS.steps, PARKS.loop) == Signal(short, Fraction(2), Fraction(1))
