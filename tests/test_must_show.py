"""What the planner must show, whole: from a mission as a file would hold it to the checked answer.

The least makespans are those of the semantics, section 3, and of the examples, with and without waiting where
both are told. `plan` raises if a plan of its own does not pass the judge; the checks here say so once more.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from mitlplan.check import check
from mitlplan.mission import Mission, mission_from_mapping, read
from mitlplan.plan import Infeasible, Plan
from mitlplan.planner import plan

EXAMPLES = Path(__file__).parent.parent / "examples"

RING = {"pos0": ["pos0cell"], "pos1": ["B"], "pos2": [], "pos3": ["A"]}


def on_the_ring(formula: str, *, waiting: bool, until: str = "standard") -> Mission:
    """The paper's 2x2 map."""
    names = list(RING)
    moves = [
        {"from": origin, "to": target, "time": 1, "both": True}
        for origin, target in zip(names, [*names[1:], names[0]], strict=True)
    ]
    return mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {"graph": {"cells": RING, "moves": moves, "waiting": waiting}},
            "robot": {"start": "pos0"},
            "spec": formula,
            "until": until,
        }
    )


def planned(mission: Mission) -> Plan:
    """The plan, which is attained and passes the judge."""
    outcome = plan(mission)
    assert isinstance(outcome, Plan), outcome
    assert outcome.attained
    assert outcome.checked
    assert outcome.bound == outcome.makespan, "not proved fastest"
    assert check(mission, outcome) is None
    return outcome


def kind_of(found: Plan) -> str:
    """Finite, parking or looping."""
    if found.loop is None:
        return "finite"
    return "parking" if found.loop.period is None else "looping"


# --- The table of the semantics, section 3 -----------------------------------------------------------------

TABLE = [
    # formula, then makespan and kind without waiting and with it
    ("(!A U B) & F A", (3, "finite"), (3, "finite")),
    ("G F[0,2] A", (2, "looping"), (1, "parking")),
    ("F[0,4] A & F[0,4] B", (3, "finite"), (3, "finite")),
    ("F[2,4] A & F[0,2] B", (3, "finite"), (3, "finite")),
    ("G[0,3] !A & F B", (3, "finite"), (3, "finite")),
    ("G F[0,3] A & G F[0,3] B", (4, "looping"), (4, "looping")),
    ("F(A & F[2,2] A)", (3, "finite"), (3, "finite")),
    ("G !B & F A", (2, "looping"), (1, "parking")),
    ("F[2,4] A", (3, "finite"), (2, "finite")),
    ("!B U A", (1, "finite"), (1, "finite")),
    ("pos0cell U A", (1, "finite"), (1, "finite")),
]


@pytest.mark.parametrize("waiting", [False, True], ids=["without waiting", "with waiting"])
@pytest.mark.parametrize("row", TABLE, ids=[row[0] for row in TABLE])
def test_table(row: tuple[str, tuple[int, str], tuple[int, str]], waiting: bool) -> None:
    formula, *answers = row
    found = planned(on_the_ring(formula, waiting=waiting))
    assert (found.makespan, kind_of(found)) == answers[waiting]


@pytest.mark.parametrize("waiting", [False, True], ids=["without waiting", "with waiting"])
@pytest.mark.parametrize(
    ("formula", "until"), [("F[0,1] A & F[0,1] B", "standard"), ("pos0cell U A", "closed")]
)
def test_table_infeasible(formula: str, until: str, waiting: bool) -> None:
    assert isinstance(plan(on_the_ring(formula, waiting=waiting, until=until)), Infeasible)


def test_table_ways() -> None:
    """The plans that the table tells."""
    ways = {
        "(!A U B) & F A": [["pos0", "pos1", "pos0", "pos3"], ["pos0", "pos1", "pos2", "pos3"]],
        "G F[0,2] A": [["pos0", "pos3"]],
        "G F[0,3] A & G F[0,3] B": [["pos0", "pos3", "pos0", "pos1"], ["pos0", "pos1", "pos0", "pos3"]],
    }
    for formula, expected in ways.items():
        found = planned(on_the_ring(formula, waiting=False))
        assert [step.cell for step in found.steps] in expected


@pytest.mark.parametrize("waiting", [False, True], ids=["without waiting", "with waiting"])
def test_the_closed_until_where_labels_overlap(waiting: bool) -> None:
    """`!B U A` means the same under both: B and A are never together."""
    assert planned(on_the_ring("!B U A", waiting=waiting, until="closed")).makespan == 1


# --- The examples ------------------------------------------------------------------------------------------

PLANNED = [
    ("paper/phi1", 3),
    ("paper/phi2", 2),
    ("paper/phi3", 3),
    ("paper/phi4", 3),
    ("warehouse", 154),
    ("rescue", 110),
]
REFUSED = [
    ("warehouse-infeasible", ("deadline",)),
    ("rescue-infeasible", ("find", "keep clear")),
]


@pytest.mark.parametrize(("name", "makespan"), PLANNED)
def test_example(name: str, makespan: int) -> None:
    assert planned(read(EXAMPLES / f"{name}.yaml")).makespan == makespan


@pytest.mark.parametrize(("name", "conflict"), REFUSED)
def test_infeasible_example(name: str, conflict: tuple[str, ...]) -> None:
    outcome = plan(read(EXAMPLES / f"{name}.yaml"))
    assert isinstance(outcome, Infeasible)
    assert outcome.conflict == conflict


def test_patrol_of_berlin() -> None:
    found = planned(read(EXAMPLES / "patrol-berlin.yaml"))
    assert kind_of(found) == "looping"
    assert found.makespan <= 756


def test_no_patrol_of_berlin() -> None:
    """No tour of the four places takes 754 seconds, and each of them is needed for that."""
    outcome = plan(read(EXAMPLES / "patrol-berlin-infeasible.yaml"))
    assert isinstance(outcome, Infeasible)
    assert outcome.conflict == ("first zone", "second zone", "third zone", "home")


def data_of(name: str) -> Any:
    """What an example file holds."""
    return YAML(typ="safe", pure=True).load(EXAMPLES / f"{name}.yaml")


def test_times_that_do_not_grow_with_the_numbers() -> None:
    """The warehouse with every time multiplied by 1000/7: as many states, and exactly as much later."""
    small = planned(read(EXAMPLES / "warehouse.yaml"))
    data = data_of("warehouse")
    data["workspace"]["movingai"]["move_time"] = "1000/7"
    data["spec"] = {
        "collect first": "!bay U p2",
        "deadline": "F[0,160000/7] bay",
        "fresh": "G (p2 -> F[0,80000/7] bay)",
    }
    large = planned(mission_from_mapping(data, folder=EXAMPLES))
    assert large.makespan == Fraction(154 * 1000, 7)
    assert large.statistics.zones == small.statistics.zones
    assert [step.cell for step in large.steps] == [step.cell for step in small.steps]


# --- The paper's formulas on grids -------------------------------------------------------------------------


@pytest.mark.parametrize("size", [*range(2, 9), 16, 33, 64])
@pytest.mark.parametrize(
    "formula",
    ["(!A U B) & F A", "F[0,{four}] A & F[0,{four}] B", "F[{two},{four}] A & F[0,{two}] B"],
    ids=["phi1", "phi3", "phi4"],
)
def test_grids(formula: str, size: int) -> None:
    """B top right, A bottom left, from the top left: there and across; bounds grow with the grid."""
    last = size - 1
    mission = mission_from_mapping(
        {
            "mitlplan": 1,
            "workspace": {
                "grid": {
                    "rows": size,
                    "columns": size,
                    "move_time": 1,
                    "waiting": False,
                    "regions": {"A": [[last, 0]], "B": [[0, last]]},
                }
            },
            "robot": {"start": "r0c0"},
            "spec": formula.format(two=2 * last, four=4 * last),
        }
    )
    assert planned(mission).makespan == 3 * last
