from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan.check import check
from mitlplan.errors import TrajectoryError
from mitlplan.mission import Mission, mission_from_mapping
from mitlplan.plan import Loop, Plan, Step
from mitlplan.trajectory.follow import Waiting, follow, spans_of
from mitlplan.trajectory.retime import retime
from mitlplan.trajectory.robot import Robot


def mission(spec: str) -> Mission:
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {
                "grid": {
                    "rows": 2,
                    "columns": 4,
                    "move_time": 1,
                    "waiting": True,
                    "regions": {"A": [[0, 3]], "B": [[1, 1]]},
                }
            },
            "robot": {"start": [0, 0]},
            "spec": spec,
        }
    )


def plan_on(read: Mission, slacks: dict[int, str | None], deadline: int = 6) -> Plan:
    """To A and round to B, a step a second, except that the plan ends at `deadline`."""
    cells = ["r0c0", "r0c1", "r0c2", "r0c3", "r1c3", "r1c2", "r1c1"]
    steps = []
    for place, cell in enumerate(cells):
        index = read.workspace.index_of(cell)
        assert index is not None
        slack = slacks.get(place, "0")
        last = place == len(cells) - 1
        steps.append(
            Step(
                cell,
                Fraction(place if not last else deadline),
                Fraction(place + 1 if place < len(cells) - 2 else deadline),
                tuple(sorted(read.workspace.holds(index))),
                None if slack is None else Fraction(slack),
            )
        )
    return Plan(tuple(steps), Fraction(deadline))


def costs(read: Mission, plan: Plan) -> float:
    return follow(plan, read.workspace, waiting=Waiting.SLOW, stop_time=Fraction(1)).cost


def test_slack_is_spent_and_the_judge_agrees() -> None:
    read = mission("F[0,4] A & F[0,12] B")
    plan = plan_on(read, {1: "1", 2: "1", 3: "1", 4: None, 5: None, 6: "6"})
    assert check(read, plan) is None
    spans = spans_of(plan, read.workspace)
    slower = retime(plan, spans, lambda found: check(read, found) is None, deadline=Fraction(12))
    assert check(read, slower) is None
    assert slower.steps[3].enter == 4
    assert slower.makespan == 12
    assert costs(read, slower) < costs(read, plan)
    # Up to A half a cell, which a move's time of a second is more than enough for, and two whole ones.
    durations = [float(slower.steps[place + 1].enter - slower.steps[place].enter) for place in range(3)]
    assert durations == pytest.approx([1.0, 1.5, 1.5], abs=1e-4)


def test_without_a_later_deadline_the_makespan_stays() -> None:
    read = mission("F[0,5] A & F[9,12] B")
    plan = plan_on(read, dict.fromkeys(range(7)) | {1: "2", 2: "2", 3: "2"}, deadline=9)
    assert check(read, plan) is None
    slower = retime(plan, spans_of(plan, read.workspace), lambda found: check(read, found) is None)
    assert slower.makespan == 9
    assert costs(read, slower) < costs(read, plan)


def test_windows_that_do_not_hold_together_are_left_half_way() -> None:
    """A and B within four seconds of each other: each alone may be late, not B alone."""
    read = mission("F(A & F[0,4] B)")
    plan = plan_on(read, dict.fromkeys(range(7), "20"))
    asked: list[Plan] = []

    def accepts(found: Plan) -> bool:
        asked.append(found)
        return check(read, found) is None

    slower = retime(plan, spans_of(plan, read.workspace), accepts, deadline=Fraction(20))
    assert check(read, slower) is None
    assert len(asked) > 1
    assert costs(read, slower) < costs(read, plan)


def test_nothing_is_changed_that_is_always_refused() -> None:
    read = mission("F[0,5] A")
    plan = plan_on(read, dict.fromkeys(range(7)))
    assert retime(plan, spans_of(plan, read.workspace), lambda _: False, deadline=Fraction(99)) is plan


def test_a_slow_robot_bounds_the_spans() -> None:
    read = mission("F A")
    plan = plan_on(read, {})
    robot = Robot(speed=Fraction(1))
    spans = spans_of(plan_on(read, {}), read.workspace, robot=robot)
    assert [str(span.least) for span in spans[:3]] == ["1", "1", "1"]
    assert spans[3].least >= 1
    assert all(span.most is None for span in spans)
    with pytest.raises(TrajectoryError, match="the deadline 3 is before the makespan 6"):
        retime(plan, spans, lambda _: True, deadline=Fraction(3))


def test_a_loop_keeps_its_period() -> None:
    read = mission("G F[0,9] A")
    names = ["r0c0", "r0c1", "r0c2", "r0c3", "r0c2", "r0c1"]
    entered = [0, 1, 2, 3, 4, 6]
    steps = []
    for name, enter, leave in zip(names, entered, [*entered[1:], 8], strict=True):
        index = read.workspace.index_of(name)
        assert index is not None
        holds = tuple(sorted(read.workspace.holds(index)))
        steps.append(Step(name, Fraction(enter), Fraction(leave), holds, None))
    plan = Plan(tuple(steps), Fraction(8), loop=Loop(0, Fraction(8)))
    assert check(read, plan) is None
    slower = retime(plan, spans_of(plan, read.workspace), lambda found: check(read, found) is None)
    assert check(read, slower) is None
    assert slower.makespan == 8
    assert costs(read, slower) < costs(read, plan)
