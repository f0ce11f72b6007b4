"""The straight line as a whole: the same answer every time, and refusals in a sentence."""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from mitlplan.cli import app
from mitlplan.logic.parse import parse
from mitlplan.mission import Mission, mission_from_mapping, read
from mitlplan.plan import Infeasible, Outcome, Plan, Statistics
from mitlplan.planner import Satisfiable, equivalent, plan, satisfiable
from mitlplan_fuzz.comparison import mission_of
from mitlplan_fuzz.missions import random_mission

EXAMPLES = Path(__file__).parent.parent / "examples"
LONGEST = 10.0
"""Seconds for an answer: nearly all take a hundredth of one."""


def answer(outcome: Outcome) -> Outcome:
    """An outcome without what differs from run to run: the seconds."""
    statistics = replace(outcome.statistics, seconds={})
    return replace(outcome, statistics=statistics)


# --- The same input, the same plan -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["paper/phi1", "paper/phi2", "paper/phi4", "warehouse", "warehouse-infeasible", "rescue"]
)
def test_examples_twice(name: str) -> None:
    file = EXAMPLES / f"{name}.yaml"
    assert answer(plan(read(file))) == answer(plan(read(file)))


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_random_missions_twice(first: int) -> None:
    """Cells, times, slack, numbers of states: all the same."""
    for seed in range(first, first + 50):
        small = random_mission(seed)
        outcomes = [plan(mission_of(small), memory_limit=20) for _ in range(2)]
        assert answer(outcomes[0]) == answer(outcomes[1]), seed


def test_the_statistics_say_what_was_done() -> None:
    outcome = plan(read(EXAMPLES / "warehouse.yaml"))
    assert isinstance(outcome, Plan)
    assert outcome.statistics.construction == "compact"
    assert outcome.statistics.zones > 0
    assert outcome.statistics.locations > len(outcome.steps)
    assert outcome.statistics != Statistics()
    assert all(seconds >= 0 for seconds in outcome.statistics.seconds.values())


# --- The order in which things are written -----------------------------------------------------------------

CELLS = {"hall": [], "dock": ["D"], "shelf": ["S"], "press": ["P"], "yard": ["Y"], "pit": ["P", "Y"]}
MOVES = [
    ("hall", "dock", 1),
    ("hall", "shelf", "3/2"),
    ("shelf", "press", 2),
    ("dock", "yard", 1),
    ("yard", "pit", ["1", "2"]),
    ("pit", "press", 1),
    ("press", "hall", "1/2"),
]
REQUIREMENTS = {
    "order": "!S U D",
    "deliver": "F[0,14] (S & F[0,9] P)",
    "fresh": "G (D -> F[0,6] Y)",
    "again": "G F[0,20] D",
    "calm": "G[0,3] !P",
}


def world(cells: Sequence[str], moves: Sequence[Any], names: Sequence[str], *, waiting: bool) -> Mission:
    """The same mission, written in this order."""
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {
                "graph": {
                    "cells": {name: list(reversed(CELLS[name])) for name in cells},
                    "moves": [
                        {"from": origin, "to": target, "time": time, "both": True}
                        for origin, target, time in moves
                    ],
                    "waiting": waiting,
                }
            },
            "robot": {"start": "hall"},
            "spec": {name: REQUIREMENTS[name] for name in names},
        }
    )


@pytest.mark.parametrize("waiting", [False, True], ids=["without waiting", "with waiting"])
@pytest.mark.parametrize(
    "names",
    [
        ("order", "deliver", "fresh"),
        ("order", "again"),
        ("calm", "deliver", "order", "fresh"),
        tuple(REQUIREMENTS),
    ],
    ids=" ".join,
)
def test_shuffled(names: tuple[str, ...], waiting: bool) -> None:
    """Requirements, cells and moves in any order: the same makespan, or none."""
    stream = random.Random(5)
    found = set()
    for _ in range(3):
        cells, moves, some = list(CELLS), list(MOVES), list(names)
        for items in (cells, moves, some):
            stream.shuffle(items)
        outcome = plan(world(cells, moves, some, waiting=waiting), time_limit=LONGEST)
        match outcome:
            case Plan():
                found.add((outcome.makespan, outcome.attained, len(outcome.steps), outcome.bound))
            case Infeasible():
                found.add((None, True, 0, None))
            case _:
                pytest.fail(outcome.reason)
    assert len(found) == 1


@pytest.mark.parametrize("first", range(0, 200, 50))
def test_cells_of_random_missions_shuffled(first: int) -> None:
    stream = random.Random(first)
    for seed in range(first, first + 50):
        small = random_mission(seed)
        cells, moves = list(small.cells), list(small.moves)
        stream.shuffle(cells)
        stream.shuffle(moves)
        other = replace(small, cells=tuple(cells), moves=tuple(moves))
        one, two = (plan(mission_of(each), time_limit=LONGEST) for each in (small, other))
        assert type(one) is type(two), seed
        if isinstance(one, Plan) and isinstance(two, Plan) and one.bound == one.makespan:
            assert (one.makespan, one.attained) == (two.makespan, two.attained), seed


# --- Times that cannot be told exactly ---------------------------------------------------------------------

FINE = ("1/999999937", "1/999999929")
"""Their common denominator is about 10^18."""


def fine_mission(spec: str, *, waiting: bool) -> dict[str, Any]:
    """Three cells in a row with moves whose times have nothing in common."""
    return {
        "mitlplan": 1,
        "workspace": {
            "graph": {
                "cells": {"a": [], "b": ["B"], "c": ["C"]},
                "moves": [
                    {"from": "a", "to": "b", "time": FINE[0], "both": True},
                    {"from": "b", "to": "c", "time": FINE[1], "both": True},
                ],
                "waiting": waiting,
            }
        },
        "robot": {"start": "a"},
        "spec": spec,
    }


def test_fine_times_are_exact() -> None:
    """Far too fine for floats, and yet right to the last digit."""
    for waiting in (False, True):
        outcome = plan(mission_from_mapping(fine_mission("F C", waiting=waiting)))
        assert isinstance(outcome, Plan)
        assert outcome.makespan == Fraction(1, 999999937) + Fraction(1, 999999929)


@pytest.mark.parametrize("waiting", [False, True], ids=["without waiting", "with waiting"])
@pytest.mark.parametrize(
    "spec",
    [
        "F[0,1000000000] C",
        "F[1,1000000000] C",
        "F[0,3] (B & F(0,2] C)",
        "G (B -> F[0,2] C)",
        "G F[0,1000000000] C",
        "G F[0,2) C & G F[0,2) B",
    ],
)
def test_times_too_large_for_their_denominator(spec: str, waiting: bool, tmp_path: Path) -> None:
    """Refused in a sentence with the code for bad input; never a wrong answer, never a traceback."""
    file = tmp_path / "mission.json"
    file.write_text(json.dumps(fine_mission(spec, waiting=waiting)), encoding="utf-8")
    result = CliRunner().invoke(app, ["plan", str(file)])
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith(
        "mitlplan: the times of this mission are too large or too finely divided: "
    )
    assert "ticks" in result.stderr
    assert result.stderr.count("\n") == 1
    with pytest.raises(OverflowError, match="ticks"):
        plan(read(file))


def test_formulas_too_large_for_their_denominator() -> None:
    text = "F[0,1/999999937] a & F[0,1/999999929] b & F[1000000000,2000000000] c"
    with pytest.raises(OverflowError, match="common denominator"):
        satisfiable(parse(text))


# --- Decisions ---------------------------------------------------------------------------------------------


def test_a_witness_may_be_asked_for_again() -> None:
    """The signal that tells two formulas apart tells them apart whoever asks."""
    formulas = parse("F[0,2] a"), parse("F[0,2) a")
    answers = [equivalent(*formulas), equivalent(*reversed(formulas))]
    assert all(isinstance(one, Satisfiable) for one in answers)
    assert equivalent(*formulas) == answers[0]
