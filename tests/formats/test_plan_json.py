from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.errors import PlanFileError
from mitlplan.formats.plan_json import plan_from_mapping, plan_to_json, plan_to_mapping, read_plan
from mitlplan.plan import Infeasible, LimitReached, Loop, Outcome, Plan, Statistics, Step

STATISTICS = Statistics("compact", 12, 40, 31, {"read": 0.01, "search": 0.002})
PLAN = Plan(
    (
        Step("pos0", Fraction(0), Fraction(1), (), Fraction(0)),
        Step("pos1", Fraction(1), Fraction(7, 2), ("A", "B"), None),
    ),
    makespan=Fraction(7, 2),
    checked=True,
    bound=Fraction(7, 2),
    statistics=STATISTICS,
)


def test_a_plan_whole() -> None:
    assert plan_to_json(PLAN) == (
        '{"mitlplan": 1,\n'
        ' "status": "plan",\n'
        ' "makespan": "7/2",\n'
        ' "bound": "7/2",\n'
        ' "attained": true,\n'
        ' "epsilon": null,\n'
        ' "steps": [\n'
        '  {"cell": "pos0", "enter": "0", "leave": "1", "holds": [], "slack": "0"},\n'
        '  {"cell": "pos1", "enter": "1", "leave": "7/2", "holds": ["A", "B"], "slack": null}],\n'
        ' "loop": null,\n'
        ' "checked": true,\n'
        ' "fault": null,\n'
        ' "reason": null,\n'
        ' "conflict": [],\n'
        ' "statistics": {"engine": "zones", "construction": "compact", "locations": 12, "edges": 40, '
        '"zones": 31, "seconds": {"read": 0.01, "search": 0.002}}}\n'
    )


@pytest.mark.parametrize(
    ("outcome", "expected"),
    [
        (
            Plan((Step("a", Fraction(0), None),), Fraction(0), Loop(0, None)),
            {"loop": {"start": 0, "period": None}, "makespan": "0"},
        ),
        (
            Plan((Step("a", Fraction(0), Fraction(2)),), Fraction(2), Loop(0, Fraction(2))),
            {"loop": {"start": 0, "period": "2"}},
        ),
        (
            Plan((), Fraction(2), attained=False, epsilon=Fraction(1, 1000)),
            {"attained": False, "epsilon": "1/1000", "makespan": "2"},
        ),
        (
            Infeasible("Too far.", ("order", "visit")),
            {"status": "infeasible", "reason": "Too far.", "conflict": ["order", "visit"], "makespan": None},
        ),
        (
            LimitReached("Out of time.", Fraction(1, 3)),
            {"status": "limit", "reason": "Out of time.", "bound": "1/3", "steps": [], "checked": False},
        ),
        (LimitReached("Out of memory."), {"status": "limit", "bound": None}),
    ],
)
def test_each_kind_of_answer(outcome: Outcome, expected: dict[str, Any]) -> None:
    answer = plan_to_mapping(outcome)
    assert {key: answer[key] for key in expected} == expected
    assert json.loads(plan_to_json(outcome)) == answer
    assert list(answer) == list(plan_to_mapping(PLAN))


times = st.fractions(0, 1000, max_denominator=100)
steps = st.builds(
    Step, st.text(min_size=1).filter(str.isprintable), times, times | st.none(), st.just(("A",)), times
)
plans = st.builds(
    Plan,
    st.lists(steps, min_size=1, max_size=4).map(tuple),
    times,
    st.none() | st.builds(Loop, st.integers(0, 9), times | st.none()),
    attained=st.booleans(),
    epsilon=times | st.none(),
    bound=times | st.none(),
)
outcomes = (
    plans
    | st.builds(Infeasible, st.text(), st.lists(st.sampled_from("ab")).map(tuple))
    | st.builds(LimitReached, st.text(), times | st.none())
)


@given(outcomes)
def test_what_is_written_is_read_back(tmp_path_factory: pytest.TempPathFactory, outcome: Outcome) -> None:
    file = tmp_path_factory.mktemp("plans") / "plan.json"
    file.write_text(plan_to_json(outcome), encoding="utf-8")
    assert read_plan(file) == outcome


def test_that_it_was_checked_is_not_believed(tmp_path: Path) -> None:
    file = tmp_path / "plan.json"
    file.write_text(plan_to_json(PLAN), encoding="utf-8")
    found = read_plan(file)
    assert isinstance(found, Plan)
    assert not found.checked


def test_unknown_keys_of_other_programs_are_let_be() -> None:
    data = {**plan_to_mapping(PLAN), "drawn_by": "somebody"}
    assert isinstance(plan_from_mapping(data), Plan)


GOOD_STEP: dict[str, Any] = {"cell": "a", "enter": "0", "leave": "1"}
GOOD: dict[str, Any] = {"mitlplan": 1, "status": "plan", "makespan": "1", "steps": [GOOD_STEP]}


def test_the_least_that_is_a_plan() -> None:
    expected = Plan((Step("a", Fraction(0), Fraction(1)),), Fraction(1))
    assert plan_from_mapping(GOOD) == expected


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mitlplan": 2}, "mitlplan: version 1 of the format is read here, not 2"),
        ({"status": "done"}, "status: 'plan', 'infeasible' or 'limit' is expected, not 'done'"),
        ({"makespan": None}, "a plan has a makespan and at least one step"),
        ({"steps": []}, "a plan has a makespan and at least one step"),
        ({"makespan": "soon"}, "makespan: 'soon' is not a number; write one such as 5, 2.5 or 7/2"),
        ({"makespan": "-1"}, "makespan: -1 is negative; write 0 or a positive number"),
        (
            {"makespan": 0.5},
            "makespan: 0.5 is not an exact number; write it as a text or a Fraction, such as '0.1'",
        ),
        ({"steps": {}}, "steps: a list is expected, not {}"),
        ({"steps": ["a"]}, "steps[0]: names with values are expected, not 'a'"),
        ({"steps": [{"cell": "a", "enter": "0"}]}, "steps[0]: the key 'leave' is missing"),
        (
            {"steps": [GOOD_STEP, {**GOOD_STEP, "enter": "1e400"}]},
            "steps[1].enter: 1e400 is out of range; numbers and their denominators go up to 1e18",
        ),
        ({"steps": [{**GOOD_STEP, "cell": 3}]}, "steps[0].cell: a name is expected, not 3"),
        ({"steps": [{**GOOD_STEP, "cell": "\x1b[2J"}]}, "steps[0].cell: a name is expected, not '\\x1b[2J'"),
        ({"steps": [{**GOOD_STEP, "holds": "A"}]}, "steps[0].holds: a list is expected, not 'A'"),
        ({"loop": {"start": -1, "period": "1"}}, "loop.start: a whole number from 0 is expected, not -1"),
        ({"loop": {"start": 0}}, "loop: the key 'period' is missing"),
        ({"reason": 5}, "reason: a text is expected, not 5"),
    ],
)
def test_what_is_no_plan(change: dict[str, Any], message: str) -> None:
    with pytest.raises(PlanFileError) as caught:
        plan_from_mapping({**GOOD, **change})
    assert str(caught.value) == message


def test_a_file_has_places(tmp_path: Path) -> None:
    file = tmp_path / "plan.txt"
    file.write_text(json.dumps({**GOOD, "makespan": "soon"}, indent=1), encoding="utf-8")
    with pytest.raises(PlanFileError) as caught:
        read_plan(file)
    assert str(caught.value) == (
        f"{file}:4:14: makespan: 'soon' is not a number; write one such as 5, 2.5 or 7/2"
    )


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(PlanFileError) as caught:
        read_plan(tmp_path / "nowhere.json")
    assert str(caught.value) == f"{tmp_path / 'nowhere.json'}: cannot read it: No such file or directory"


def test_too_many_steps_are_refused() -> None:
    with pytest.raises(PlanFileError, match=r"^steps: 1000001 steps are too many; at most 1000000 are read$"):
        plan_from_mapping({**GOOD, "steps": [GOOD_STEP] * 1_000_001})


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["mitlplan", "status", "steps", "cell", "loop"]), inner, max_size=4
            )
        ),
        max_leaves=10,
    )
)
def test_any_data_is_a_plan_or_refused(data: object) -> None:
    with pytest.raises(PlanFileError):
        plan_from_mapping(data)
