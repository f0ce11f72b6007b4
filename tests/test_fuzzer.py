"""The fuzzer notices: whatever voice is made to lie, some other one contradicts it within a few cases.

Every voice is damaged in turn, on the surface or deep inside; a comparison that cannot fail would pass the
ten thousand missions of test_differential.py as well.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import Any

import pytest
from typer.testing import CliRunner

from mitlplan import planner
from mitlplan.logic import semantics
from mitlplan.plan import Infeasible, Outcome, Plan
from mitlplan.planner import Unsatisfiable, plan
from mitlplan.translation.compact import one_shot
from mitlplan_fuzz import comparison, missions, runner
from mitlplan_fuzz.comparison import Verdict, verdict_on
from mitlplan_fuzz.missions import random_case
from mitlplan_fuzz.oracles.rtamt_voice import rtamt_is_there
from mitlplan_fuzz.oracles.tick_planner import Least
from mitlplan_fuzz.program import app
from mitlplan_fuzz.runner import Finding, Tally, fuzz

FIRST = 5_000_000
ENOUGH = 300
"""Cases within which every damage below must show; most need one or two."""

Damage = Callable[[pytest.MonkeyPatch], None]


def _a_plan_changed(change: Callable[[Plan], Outcome], construction: str = "compact") -> Damage:
    def asked(*arguments: Any, **options: Any) -> Outcome:
        outcome = plan(*arguments, **options)
        damaged = isinstance(outcome, Plan) and options.get("construction", "compact") == construction
        return change(outcome) if damaged and isinstance(outcome, Plan) else outcome

    return lambda monkeypatch: monkeypatch.setattr(comparison, "plan", asked)


def _late(outcome: Plan) -> Plan:
    return replace(outcome, makespan=outcome.makespan + 1, bound=outcome.makespan + 1)


def _shifted(outcome: Plan) -> Plan:
    steps = tuple(
        replace(step, enter=step.enter + (number > 0), leave=None if step.leave is None else step.leave + 1)
        for number, step in enumerate(outcome.steps)
    )
    return replace(outcome, steps=steps, makespan=outcome.makespan + 1)


def _none(outcome: Plan) -> Infeasible:
    return Infeasible("not true", (), outcome.statistics)


def _longer_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    below = one_shot.below
    monkeypatch.setattr(
        one_shot, "below", lambda clock, interval: below(clock, replace(interval, upper_open=False))
    )


def _no_lower_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(one_shot, "above", lambda _clock, _interval: ())


def _judge_of_junctions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(semantics, "_conjunctive", lambda _claim: False)


def _judge_of_untils(monkeypatch: pytest.MonkeyPatch) -> None:
    satisfies = comparison.satisfies
    for module in (comparison, planner):
        monkeypatch.setattr(
            module, "satisfies", lambda *given, **options: satisfies(*given, **{**options, "until": "closed"})
        )


def _judge_says_yes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparison, "satisfies", lambda *_, **__: True)


def _oracle(monkeypatch: pytest.MonkeyPatch) -> None:
    answered = comparison.least_by_progression

    def later(*arguments: Any, **options: Any) -> Any:
        answer = answered(*arguments, **options)
        return replace(answer, makespan=answer.makespan + 1) if isinstance(answer, Least) else answer

    monkeypatch.setattr(comparison, "least_by_progression", later)


def _progression(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparison, "_progressed", lambda *_, **__: True)


def _rtamt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparison, "monitored", lambda *_: False)


def _conflicts_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        planner, "_conflict", lambda mission, _limits: tuple(each.name for each in mission.spec)
    )


def _no_formula_has_a_signal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparison, "satisfiable", lambda *_, **__: Unsatisfiable())


DAMAGES: dict[str, Damage] = {
    "plans whose makespan is too late": _a_plan_changed(_late),
    "plans that set out later": _a_plan_changed(_shifted),
    "no plans": _a_plan_changed(_none),
    "no plans by the seed construction": _a_plan_changed(_none, "seed"),
    "late plans by the seed construction": _a_plan_changed(_late, "seed"),
    "intervals with their ends": _longer_intervals,
    "intervals from 0 on": _no_lower_bounds,
    "a judge who takes and for or": _judge_of_junctions,
    "a judge who closes every until": _judge_of_untils,
    "a judge who says yes": _judge_says_yes,
    "a late oracle": _oracle,
    "progression that says yes": _progression,
    "an rtamt that says no": _rtamt,
    "conflicts of all requirements": _conflicts_of_all,
    "formulas without signals": _no_formula_has_a_signal,
}


@pytest.mark.parametrize("name", DAMAGES)
def test_every_lie_is_contradicted(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    DAMAGES[name](monkeypatch)
    assert any(_objects(seed) for seed in range(FIRST, FIRST + ENOUGH)), name


def _objects(seed: int) -> bool:
    try:
        return bool(verdict_on(random_case(seed), seed=seed).disagreements)
    except AssertionError:
        # The planner asks the judge itself; the runner reports this as well.
        return True


def test_every_voice_votes_and_none_lies() -> None:
    assert rtamt_is_there()
    votes: Counter[str] = Counter()
    for seed in range(FIRST, FIRST + 60):
        verdict = verdict_on(random_case(seed), seed=seed)
        assert not verdict.disagreements, str(random_case(seed))
        votes += verdict.votes
    assert set(votes) == {
        "conflict",
        "engine",
        "equivalent",
        "judge",
        "one walk",
        "oracle",
        "progression",
        "rtamt",
        "satisfiable",
        "seed construction",
        "valid",
    }


def test_the_program_counts_and_is_content() -> None:
    result = CliRunner().invoke(app, ["--cases", "6", "--seed", str(FIRST), "--jobs", "2"])
    assert result.exit_code == 0, result.output
    assert result.stdout == ""
    assert re.search(
        rf"^6 cases from seed {FIRST} on, in \d+ s: 0 disagreements$", result.stderr, re.MULTILINE
    )
    assert "opinions: " in result.stderr


def test_a_crash_and_an_error_are_findings_and_the_rest_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "_work", work_that_dies_on_its_second)
    told: list[Finding] = []
    tally = fuzz(0, seconds=None, cases=4, jobs=1, found=told.append, progress=lambda _tally: None)
    assert isinstance(tally, Tally)
    assert tally.done == 4
    assert told == tally.findings
    assert [finding.seed for finding in told] == [1, 2]
    assert told[0].sentences[0].startswith("the process died with 7, after ")
    assert told[0].case == str(missions.random_case(1))
    assert told[1].sentences == ("they differ",)


def work_that_dies_on_its_second(
    reports: Connection, seed: int, step: int, last: int | None, end: float | None
) -> None:
    """What a process of the fuzzer does, for a native half that crashes and an engine that errs."""
    assert last is not None
    assert end is None
    for each in range(seed, last, step):
        reports.send(each)
        if each == 1:
            os._exit(7)
        wrong = ["they differ"] if each == 2 else []
        reports.send((Verdict(wrong), "the case" if wrong else ""))
    reports.send(None)
