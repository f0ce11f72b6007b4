from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, pairwise
from math import inf

import pytest

from mitlplan.check import check
from mitlplan.compose import core_of
from mitlplan.errors import TrajectoryError
from mitlplan.mission import Mission, mission_from_mapping
from mitlplan.plan import Loop, Plan, Step
from mitlplan.refusal import reasons
from mitlplan.trajectory.follow import Waiting, follow, spans_of
from mitlplan.trajectory.retime import Retimed, retime
from mitlplan.trajectory.robot import Robot
from mitlplan.trajectory.timetable import Span


def mission(spec: str, move_time: str = "1") -> Mission:
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {
                "grid": {
                    "rows": 2,
                    "columns": 4,
                    "move_time": move_time,
                    "waiting": True,
                    "regions": {"A": [[0, 3]], "B": [[1, 1]]},
                }
            },
            "robot": {"start": [0, 0]},
            "spec": spec,
        }
    )


HALF = Fraction(1, 2)
TO_A_AND_B = ["r0c0", "r0c1", "r0c2", "r0c3", "r1c3", "r1c2", "r1c1"]


def plan_on(read: Mission, cells: Sequence[str], times: Sequence[int | Fraction]) -> Plan:
    """The cells, entered at those times; one time more is the end of the plan."""
    ends = [*times[1:], times[-1]][: len(cells)]
    steps = []
    for cell, enter, leave in zip(cells, times, ends, strict=False):
        index = read.workspace.index_of(cell)
        assert index is not None
        holds = tuple(sorted(read.workspace.holds(index)))
        steps.append(Step(cell, Fraction(enter), Fraction(leave), holds))
    return Plan(tuple(steps), Fraction(times[-1]))


def costs(read: Mission, plan: Plan) -> float:
    return follow(plan, read.workspace, waiting=Waiting.SLOW, stop_time=Fraction(1)).cost


def retimed(read: Mission, plan: Plan, deadline: int | None = None) -> Retimed:
    """As the command line does it."""
    core = core_of(read)
    return retime(
        plan,
        spans_of(plan, read.workspace),
        lambda found: check(read, found) is None,
        reasons=lambda found: reasons(core, found, horizon=read.horizon),
        deadline=None if deadline is None else Fraction(deadline),
    )


def best_by_trying(read: Mission, plan: Plan, spans: list[Span], latest: int, parts: int) -> float:
    """The least cost over all stays that are multiples of 1/`parts` seconds; the judge looks at every one."""
    ended = plan.steps[-1].leave != plan.steps[-1].enter
    cells = [step.cell for step in plan.steps]
    best = inf
    ticks = range(latest * parts + 1)
    for chosen in combinations(ticks[1:], len(spans)):
        times = [Fraction(0), *(Fraction(tick, parts) for tick in chosen)]
        cost = sum(span.cost / float(b - a) for span, (a, b) in zip(spans, pairwise(times), strict=True))
        if cost < best and all(
            b - a >= span.least for span, (a, b) in zip(spans, pairwise(times), strict=True)
        ):
            ends = [[Fraction(tick, parts)] for tick in ticks if Fraction(tick, parts) > times[-1]]
            timed = (plan_on(read, cells, [*times, *end]) for end in (ends if ended else [[]]))
            if any(check(read, one) is None for one in timed):
                best = cost
    return best


def test_the_time_is_shared_by_the_roots_of_the_costs() -> None:
    read = mission("F[0,4] A & F[0,12] B")
    plan = plan_on(read, TO_A_AND_B, range(7))
    found = retimed(read, plan, 12)
    assert check(read, found.plan) is None
    assert found.cost == found.bound
    assert (found.plan.steps[3].enter, found.plan.makespan) == (4, 12)
    # Up to A half a cell, which a move's time of a second is more than enough for, and two whole ones.
    entered = [float(step.enter) for step in found.plan.steps]
    assert [end - begin for begin, end in pairwise(entered[:4])] == pytest.approx([1.0, 1.5, 1.5], abs=1e-4)
    # Behind A a quarter turn, another one, and a straight cell.
    roots = [3.0771054975**0.5, 3.0771054975**0.5, 1.0]
    wanted = [8 * root / sum(roots) for root in roots]
    assert [end - begin for begin, end in pairwise(entered[3:])] == pytest.approx(wanted, abs=1e-4)


def test_without_a_later_deadline_the_makespan_stays() -> None:
    read = mission("F[0,5] A & F[9,12] B")
    plan = plan_on(read, TO_A_AND_B, [0, 1, 2, 3, 4, 5, 9])
    found = retimed(read, plan)
    assert check(read, found.plan) is None
    assert found.plan.makespan == 9
    assert costs(read, found.plan) < costs(read, plan)


SHORT = ["r0c0", "r0c1", "r1c1", "r0c1", "r0c2", "r0c3"]
"""To B, and by way of a U-turn to A."""


@pytest.mark.parametrize(
    ("spec", "cells", "times", "latest"),
    [
        ("F[0,9] A", SHORT, [0, 1, 2, 3, 4, 5], 9),
        ("F[0,4] B & F[0,9] A", SHORT, [0, 1, 2, 3, 4, 5], 9),
        # Each alone may be late, but not A alone.
        ("F(B & F[0,4] A)", SHORT, [0, 1, 2, 3, 4, 5], 9),
        # One or the other: two convex sets, of which the cheaper one is wanted.
        ("F[0,3] B & F A | F B & F[0,6] A", SHORT, [0, 1, 2, 3, 4, 5], 9),
        ("F[0,2] B & F[0,8] A | F[3,4] B & F[0,7] A | F[5,5] B & F A", SHORT, [0, 1, 2, 3, 4, 5], 9),
        # To leave B soon, which asks for a quick U-turn.
        ("!B U (B & F[0,1] !B) & F A", SHORT, [0, 1, 2, Fraction(5, 2), 4, 5], 8),
        ("!A U (B & F(2,inf) A) & F A", SHORT, [0, 1, 2, 3, 4, 5], 8),
        ("G[0,5) !A & F[6,7] A", SHORT, [0, 1, 2, 3, 4, 5, 6], 8),
        ("G[0,6] !A & F A", ["r0c0", "r0c1", "r0c2", "r0c3"], [0, 1, 2, 7], 9),
        ("F[2,7] A & F G[0,2] A", ["r0c0", "r0c1", "r0c2", "r0c3"], [0, 1, 2, 3, 5], 8),
    ],
)
def test_no_times_on_a_grid_are_cheaper(
    spec: str, cells: list[str], times: list[int | Fraction], latest: int
) -> None:
    read = mission(spec, move_time="1/2")
    plan = plan_on(read, cells, times)
    assert check(read, plan) is None
    found = retimed(read, plan, latest)
    assert check(read, found.plan) is None
    assert found.cost == found.bound
    spans = spans_of(plan, read.workspace)
    ours = sum(
        span.cost / float(after.enter - before.enter)
        for span, (before, after) in zip(spans, pairwise(found.plan.steps), strict=True)
    )
    assert ours == pytest.approx(found.cost, rel=1e-12)
    tried = best_by_trying(read, plan, spans, latest, parts=2)
    assert ours <= tried * (1 + 1e-6)
    assert tried < inf


def test_the_best_of_many_branches() -> None:
    """A is left soon after B or seen late; all of it is decided before the time is shared."""
    read = mission("F[3,9] B & F(B & F[0,4] A) & (F[0,8] A | F[10,12] A)")
    plan = plan_on(read, SHORT, [0, 2, 4, 5, 6, 7])
    assert check(read, plan) is None
    early, late = retimed(read, plan, 9), retimed(read, plan, 12)
    assert check(read, late.plan) is None
    # Before 8 or, where the deadline allows it, behind 10; never in between.
    assert early.plan.makespan == 8
    assert late.plan.makespan >= 10
    assert late.cost == late.bound < early.cost == early.bound


def test_a_judge_without_reasons_is_met_half_way() -> None:
    read = mission("F(A & F[0,4] B)")
    plan = plan_on(read, TO_A_AND_B, range(7))
    asked: list[Plan] = []

    def accepts(found: Plan) -> bool:
        asked.append(found)
        return check(read, found) is None

    found = retime(plan, spans_of(plan, read.workspace), accepts, deadline=Fraction(20))
    assert check(read, found.plan) is None
    assert len(asked) > 1
    assert found.bound < found.cost
    assert costs(read, found.plan) < costs(read, plan)
    assert retimed(read, plan, 20).cost < found.cost


def test_nothing_is_changed_that_is_always_refused() -> None:
    read = mission("F[0,5] A")
    plan = plan_on(read, TO_A_AND_B, range(7))
    found = retime(plan, spans_of(plan, read.workspace), lambda _: False, deadline=Fraction(99))
    assert found.plan is plan
    assert found.bound < found.cost


def test_a_slow_robot_bounds_the_spans() -> None:
    read = mission("F A")
    plan = plan_on(read, TO_A_AND_B, range(7))
    spans = spans_of(plan, read.workspace, robot=Robot(speed=Fraction(1)))
    assert [str(span.least) for span in spans[:3]] == ["1", "1", "1"]
    assert spans[3].least >= 1
    assert all(span.most is None for span in spans)
    with pytest.raises(TrajectoryError, match="the deadline 3 is before the makespan 6"):
        retime(plan, spans, lambda _: True, deadline=Fraction(3))


def test_a_plan_that_is_too_fast_for_the_robot_is_made_slower() -> None:
    read = mission("F A & F B")
    plan, robot = plan_on(read, TO_A_AND_B, range(7)), Robot(speed=HALF)
    with pytest.raises(TrajectoryError, match="speed limit"):
        follow(plan, read.workspace, robot=robot)
    spans = spans_of(plan, read.workspace, robot=robot)
    with pytest.raises(TrajectoryError, match="the robot cannot drive so fast that the plan ends by 8"):
        retime(plan, spans, lambda _: True, deadline=Fraction(8))
    found = retime(plan, spans, lambda slower: check(read, slower) is None, deadline=Fraction(20))
    assert check(read, found.plan) is None
    assert found.plan.makespan == 20
    follow(found.plan, read.workspace, robot=robot, waiting=Waiting.SLOW)


def there_and_back(read: Mission) -> Plan:
    names = ["r0c0", "r0c1", "r0c2", "r0c3", "r0c2", "r0c1"]
    return replace(plan_on(read, names, [0, 1, 2, 3, 4, 6, 8]), loop=Loop(0, Fraction(8)))


def test_a_loop_keeps_its_period() -> None:
    read = mission("G F[0,9] A")
    plan = there_and_back(read)
    assert check(read, plan) is None
    found = retimed(read, plan)
    assert check(read, found.plan) is None
    assert found.plan.makespan == 8
    assert found.cost == found.bound
    assert costs(read, found.plan) < costs(read, plan)


def test_a_loop_keeps_what_is_promised_in_every_round() -> None:
    """Never more than three seconds in A, where the U-turn would take longer if it could."""
    free = mission("G F[0,9] A", move_time="1/2")
    bound = mission("G F[0,9] A & G F[0,3] !A", move_time="1/2")
    cells = [step.cell for step in there_and_back(bound).steps]
    plan = replace(plan_on(bound, cells, [0, 1, 2, 3, 6, 7, 8]), loop=Loop(0, Fraction(8)))
    assert check(bound, plan) is None
    found = retimed(bound, plan)
    assert check(bound, found.plan) is None
    assert found.cost == found.bound
    stay = found.plan.steps[4].enter - found.plan.steps[3].enter
    assert stay == pytest.approx(3, abs=1e-5)
    assert retimed(free, plan).cost < found.cost


def test_parking_has_no_end() -> None:
    read = mission("F A & G(A -> G A) & F[0,9] A")
    cells = ["r0c0", "r0c1", "r0c2", "r0c3"]
    plan = plan_on(read, cells, range(4))
    steps = (*plan.steps[:-1], replace(plan.steps[-1], leave=None))
    plan = Plan(steps, Fraction(3), Loop(3, None))
    assert check(read, plan) is None
    found = retimed(read, plan, 30)
    assert check(read, found.plan) is None
    assert found.plan.makespan == 9
    assert found.cost == found.bound


def test_a_long_plan_with_a_deadline_in_the_middle() -> None:
    cells = 200
    read = mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {
                "grid": {
                    "rows": 1,
                    "columns": cells,
                    "waiting": True,
                    "regions": {"A": [[0, 80]], "B": [[0, cells - 1]]},
                }
            },
            "robot": {"start": [0, 0]},
            "spec": "F[0,100] A & F[0,400] B",
        }
    )
    plan = plan_on(read, [f"r0c{column}" for column in range(cells)], range(cells))
    found = retimed(read, plan, 400)
    assert check(read, found.plan) is None
    assert found.cost == found.bound
    assert (found.plan.steps[80].enter, found.plan.makespan) == (100, 400)
