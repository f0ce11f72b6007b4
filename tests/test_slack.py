"""Slack: by hand, and against all timetables in half seconds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from mitlplan.mission import mission_from_mapping
from mitlplan.plan import Plan
from mitlplan.planner import plan
from mitlplan_fuzz.comparison import mission_of
from mitlplan_fuzz.missions import SmallMission, random_mission
from tests.oracles.brute_slack import FARTHEST, STEP, possible, slack_by_trying


def planned(data: Mapping[str, Any]) -> Plan:
    """The plan for a mission on a row or ring of cells."""
    outcome = plan(mission_from_mapping({"mitlplan": 1, **data}))
    assert isinstance(outcome, Plan)
    return outcome


def row(length: int, spec: str, regions: Mapping[str, Sequence[int]], **options: Any) -> Plan:
    """The plan on a row of cells in which the robot may wait, from the first."""
    grid = {
        "rows": 1,
        "columns": length,
        "waiting": True,
        "regions": {name: [[0, column] for column in columns] for name, columns in regions.items()},
    }
    return planned({"workspace": {"grid": grid}, "robot": {"start": "r0c0"}, "spec": spec, **options})


def slack(found: Plan) -> list[str]:
    """The slack of all steps, as one reads it."""
    return ["any" if step.slack is None else str(step.slack) for step in found.steps]


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("F A", ["0", "any", "any", "any"]),
        ("F[0,5] A", ["0", "2", "2", "2"]),
        # As late as one likes up to the bound, which itself does not count.
        ("F[0,5) A", ["0", "2", "2", "2"]),
        # Out of the first cell and into A, each in time; the cells between are not seen.
        ("F[0,3] !home & F[0,10] A", ["0", "2", "7", "7"]),
        # The last instant in the middle is never long ago.
        ("F (mid & F[0,4] A)", ["0", "any", "any", "any"]),
        # The first one is: from 2 on A is due by 4, but whoever is late in the middle is due later.
        ("F[0,6] mid & G (mid -> F[0,2] A)", ["0", "4", "4", "1"]),
    ],
)
def test_finite_plans(spec: str, expected: list[str]) -> None:
    found = row(4, spec, {"home": [0], "mid": [2], "A": [3]})
    assert [step.enter for step in found.steps] == [0, 1, 2, 3]
    assert slack(found) == expected


def test_a_choice_of_the_formula_is_made_anew() -> None:
    """Planned to satisfy the first half; late, the second is as good."""
    found = row(2, "F[0,1] A | F[4,9] A", {"A": [1]})
    assert found.makespan == 1
    assert slack(found) == ["0", "8"]


def test_parking() -> None:
    found = row(3, "F[0,7] A & F G A", {"A": [2]})
    assert found.loop is not None
    assert found.loop.period is None
    assert slack(found) == ["0", "5", "5"]


def test_loops() -> None:
    """A round of 4; each place is left at once and must be seen again within 6 seconds after that."""
    found = row(3, "G F[0,6] A & G F[0,6] B", {"A": [0], "B": [2]})
    assert found.loop is not None
    assert found.loop.period == 4
    assert [step.enter for step in found.steps] == [0, 1, 2, 3]
    # Leaving A later: B at most at 6. Once A is left, B can be late until A has to be seen again.
    assert slack(found) == ["0", "4", "3", "3"]


def test_a_patrol_without_slack() -> None:
    """Where every stay has its one length nothing can be late."""
    grid = {"rows": 2, "columns": 2, "waiting": False, "regions": {"A": [[1, 0]], "B": [[0, 1]]}}
    data = {"workspace": {"grid": grid}, "robot": {"start": "r0c0"}}
    for spec in ("(!A U B) & F A", "G F[0,9] A & G F[0,9] B"):
        assert set(slack(planned({**data, "spec": spec}))) == {"0"}


def test_a_move_that_may_take_longer() -> None:
    cells = {"a": [], "b": ["B"], "c": ["C"]}
    moves = [{"from": "a", "to": "b", "time": [1, 4]}, {"from": "b", "to": "c", "time": ["1/2", 2]}]
    graph = {"cells": cells, "moves": moves, "waiting": False}
    for spec, expected in (
        ("F C", ["0", "3", "3/2"]),
        ("F[0,3] C", ["0", "3/2", "3/2"]),
        ("F[0,2] B & F C", ["0", "1", "3/2"]),
    ):
        found = planned({"workspace": {"graph": graph}, "robot": {"start": "a"}, "spec": spec})
        assert slack(found) == expected


def test_the_mission_may_end_later() -> None:
    """Over a finite horizon `G` speaks of the time up to the end, and the first instant counts as well."""
    found = row(3, "F A & G (home -> F[0,3] mid)", {"home": [0], "mid": [1], "A": [2]}, horizon="finite")
    assert slack(found) == ["0", "2", "any"]


# --- Against all timetables --------------------------------------------------------------------------------

SHORT = {
    # Entering A between 2 and 3 breaks a requirement, entering it later does not; to be late before A is
    # possible, with a jump over that gap.
    (801, 1),
    # The automata have too many states: what is not settled is not promised.
    (960, 1),
}


def small_plan(small: SmallMission) -> Plan | None:
    """A short plan with times in half seconds, on a map on which times are free."""
    if small.tick_timed:
        return None
    found = plan(mission_of(small), time_limit=5)
    if not isinstance(found, Plan) or not found.attained or len(found.steps) > 4:
        return None
    return found if all((step.enter / STEP).denominator == 1 for step in found.steps) else None


@pytest.mark.parametrize("first", range(0, 1000, 100))
def test_slack_against_all_timetables(first: int) -> None:
    """No more is promised than is possible, and no less but for the reasons named."""
    short, wrong = set(), set()
    for seed in range(first, first + 100):
        small = random_mission(seed)
        found = small_plan(small)
        for place, step in enumerate(found.steps if found else ()):
            if place == 0:
                assert step.slack == 0
                continue
            assert found is not None
            tried = slack_by_trying(small, found, place)
            told = FARTHEST if step.slack is None else min(step.slack, FARTHEST)
            if told < tried:
                short.add((seed, place))
            # A supremum need not be attained: the half second before it is.
            elif told > tried + STEP and not possible(small, found, place, told // STEP * STEP - STEP):
                wrong.add((seed, place))
    assert not wrong
    assert short == {one for one in SHORT if one[0] in range(first, first + 100)}


def test_the_small_plans_are_of_every_kind() -> None:
    kinds = {"finite": 0, "parking": 0, "looping": 0, "free": 0}
    for seed in range(1000):
        found = small_plan(random_mission(seed))
        if found is None:
            continue
        kind = "finite" if found.loop is None else "parking" if found.loop.period is None else "looping"
        kinds[kind] += len(found.steps) - 1
        kinds["free"] += sum(step.slack is None or step.slack > 0 for step in found.steps)
    # Plans that park are mostly longer, or shorter: to be there is to be done.
    assert kinds.pop("parking") >= 2
    assert all(count >= 10 for count in kinds.values()), kinds
