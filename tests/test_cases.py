"""The corpus, each case through every stage: text, normal form, plan, judge, and the oracle where it can.

A bug that is mended adds a case to ``cases/*.toml``, not a function here.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from mitlplan.check import check
from mitlplan.errors import MitlplanError
from mitlplan.logic.formula import And, Formula, Iff, Not, operands_of
from mitlplan.logic.normalize import normalize, written
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.show import show
from mitlplan.logic.signal import Segment, Signal
from mitlplan.mission import Mission, mission_from_mapping
from mitlplan.plan import Infeasible, Plan
from mitlplan.planner import Satisfiable, Unsatisfiable, equivalent, plan, satisfiable, valid
from mitlplan_fuzz.oracles.tick_planner import Least, NoneUpTo, least_by_progression

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Case = Mapping[str, Any]

FOLDER = Path(__file__).parent / "cases"
MISSIONS = tomllib.loads((FOLDER / "missions.toml").read_text(encoding="utf-8"))
FORMULAS = tomllib.loads((FOLDER / "formulas.toml").read_text(encoding="utf-8"))

PLANNED = [case for case in MISSIONS["case"] if case["status"] != "refused"]
REFUSED = [case for case in MISSIONS["case"] if case["status"] == "refused"]
SATISFIABLE = [case for case in FORMULAS["formula"] if "satisfiable" in case]
VALID = [case for case in FORMULAS["formula"] if "valid" in case]
PAIRS = FORMULAS["pair"]

LONGEST = 20.0
"""Seconds for an answer: nearly all take a hundredth of one."""

FARTHEST = 1000
"""How many ticks the oracle is sent for an answer: further it is not slow but useless."""


def named(case: Case) -> str:
    """What the case is called in a report."""
    return str(case.get("name") or case.get("text") or f"{case['left']} = {case['right']}")


def mission_of(case: Case) -> Mission:
    """The mission, made of what a mission file would hold."""
    world = MISSIONS["workspace"][case["on"]]
    moves = [_move(move, both=True) for move in world.get("both", [])]
    moves += [_move(move, both=False) for move in world.get("moves", [])]
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {
                "graph": {"cells": world["cells"], "moves": moves, "waiting": case.get("waiting", False)}
            },
            "robot": {"start": case.get("start", next(iter(world["cells"])))},
            "spec": case.get("spec") or case["formula"],
            "horizon": case.get("horizon", "infinite"),
            "until": case.get("until", "standard"),
        }
    )


def _move(move: list[str], *, both: bool) -> dict[str, Any]:
    origin, target, *times = move
    return {"from": origin, "to": target, "time": times if len(times) > 1 else times[0], "both": both}


def formula_of(mission: Mission) -> Formula:
    """All requirements together."""
    first, *others = [requirement.formula for requirement in mission.spec]
    return And((first, *others)) if others else first


# --- Missions ----------------------------------------------------------------------------------------------


def test_the_names_are_different() -> None:
    names = [case["name"] for case in MISSIONS["case"]]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("case", PLANNED, ids=named)
def test_mission_text_and_normal_form(case: Case) -> None:
    mission = mission_of(case)
    for requirement in mission.spec:
        assert_stable(requirement.formula, mission.until)


@pytest.mark.parametrize("case", PLANNED, ids=named)
def test_mission_plan(case: Case) -> None:
    mission = mission_of(case)
    outcome = plan(mission, time_limit=LONGEST)
    if case["status"] == "infeasible":
        assert isinstance(outcome, Infeasible)
        assert list(outcome.conflict) == case.get("conflict", list(outcome.conflict))
        return
    assert isinstance(outcome, Plan)
    assert (outcome.makespan, outcome.attained) == (Fraction(case["makespan"]), case.get("attained", True))
    assert kind_of(outcome) == case["kind"]
    assert outcome.checked
    assert check(mission, outcome) is None


def kind_of(found: Plan) -> str:
    """Finite, parking or looping."""
    if found.loop is None:
        return "finite"
    return "parking" if found.loop.period is None else "looping"


@pytest.mark.parametrize("case", PLANNED, ids=named)
def test_mission_oracle(case: Case) -> None:
    """The answer in the file is the oracle's, as far as ticks can tell."""
    mission = mission_of(case)
    ticks = ticks_a_second(mission)
    makespan = Fraction(case.get("makespan", 8))
    if makespan * ticks > FARTHEST:
        pytest.skip("too many ticks")
    # Two strict steps one after the other still fit in before the next whole tick.
    resolution = 4 * ticks
    answer = least_by_progression(
        mission.workspace,
        mission.start,
        formula_of(mission),
        bound=int(makespan) + 1,
        until=mission.until,
        horizon=mission.horizon,
        resolution=resolution,
    )
    if case["status"] == "infeasible":
        assert isinstance(answer, NoneUpTo)
        return
    assert isinstance(answer, Least)
    assert answer.kind == case["kind"]
    if case.get("attained", True):
        assert answer.makespan == makespan
    else:
        assert makespan < answer.makespan < makespan + Fraction(1, ticks)


def ticks_a_second(mission: Mission) -> int:
    """How many ticks make all times of the mission whole."""
    times = set(mission.workspace.durations)
    todo = [formula_of(mission)]
    while todo:
        part = todo.pop()
        interval = getattr(part, "interval", None)
        if interval is not None:
            times |= {interval.lower, interval.upper or Fraction(0)}
        todo += operands_of(part)
    ticks = 1
    while any((time * ticks).denominator > 1 for time in times):
        ticks += 1
    return ticks


@pytest.mark.parametrize("case", REFUSED, ids=named)
def test_mission_is_refused(case: Case) -> None:
    with pytest.raises(MitlplanError, match="instant"):
        plan(mission_of(case))


# --- Formulas ----------------------------------------------------------------------------------------------


def assert_stable(formula: Formula, until: str) -> None:
    """What is shown reads back as the same formula, and the normal form has itself for its normal form."""
    assert parse(show(formula)) == formula
    core = normalize(formula, until)
    assert normalize(written(core)) == core


@pytest.mark.parametrize("case", [*FORMULAS["formula"], *PAIRS], ids=named)
def test_formula_text_and_normal_form(case: Case) -> None:
    for text in (case.get("text"), case.get("left"), case.get("right")):
        if text is not None:
            assert_stable(parse(text), case.get("until", "standard"))


@pytest.mark.parametrize("case", SATISFIABLE, ids=named)
def test_formula_is_satisfiable(case: Case) -> None:
    formula, until = parse(case["text"]), case.get("until", "standard")
    match satisfiable(formula, until=until, time_limit=LONGEST):
        case Satisfiable(signal):
            assert case["satisfiable"]
            assert satisfies(formula, signal, until=until)
        case answer:
            assert isinstance(answer, Unsatisfiable)
            assert not case["satisfiable"]


@pytest.mark.parametrize("case", VALID, ids=named)
def test_formula_is_valid(case: Case) -> None:
    formula, until = parse(case["text"]), case.get("until", "standard")
    match valid(formula, until=until, time_limit=LONGEST):
        case Satisfiable(signal):
            assert not case["valid"]
            assert satisfies(Not(formula), signal, until=until)
        case answer:
            assert isinstance(answer, Unsatisfiable)
            assert case["valid"]


@pytest.mark.parametrize("case", PAIRS, ids=named)
def test_formulas_are_equivalent(case: Case) -> None:
    left, right, until = parse(case["left"]), parse(case["right"]), case.get("until", "standard")
    match equivalent(left, right, until=until, time_limit=LONGEST):
        case Satisfiable(signal):
            assert not case["equivalent"]
            assert satisfies(Not(Iff(left, right)), signal, until=until)
        case answer:
            assert isinstance(answer, Unsatisfiable)
            assert case["equivalent"]


def random_signals(count: int) -> list[Signal]:
    """Signals that repeat, with changes at halves: finer than the bounds of the corpus."""
    stream = random.Random(7)
    signals = []
    for _ in range(count):
        starts = sorted({Fraction(0), *(Fraction(stream.randrange(12), 2) for _ in range(5))})
        segments = tuple(
            Segment(start, frozenset(name for name in "pqr" if stream.random() < 0.5)) for start in starts
        )
        end = starts[-1] + Fraction(stream.randrange(1, 5), 2)
        signals.append(Signal(segments, end, repeat_from=stream.choice(starts)))
    return signals


SIGNALS = random_signals(150)


@pytest.mark.parametrize("case", [*FORMULAS["formula"], *PAIRS], ids=named)
def test_formula_judge(case: Case) -> None:
    """No signal contradicts the file."""
    until = case.get("until", "standard")
    formula = Iff(parse(case["left"]), parse(case["right"])) if "left" in case else parse(case["text"])
    truths = {satisfies(formula, signal, until=until) for signal in SIGNALS}
    if case.get("equivalent") or case.get("valid"):
        assert truths == {True}
    if case.get("satisfiable") is False:
        assert truths == {False}
