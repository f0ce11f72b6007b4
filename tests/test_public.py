"""The names of the package: all there, found when used, and never hidden by the modules of the same name."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

import mitlplan as mp

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture
def yard() -> mp.Workspace:
    return mp.grid(rows=2, columns=2, move_time=1, regions={"A": [(1, 0)], "B": [(0, 1)]})


def test_all_names_are_there() -> None:
    assert dir(mp) == sorted(mp.__all__)
    for name in mp.__all__:
        assert getattr(mp, name) is not None


def test_a_name_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match=re.escape("module 'mitlplan' has no attribute 'plann'")):
        _ = mp.plann  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["plan", "check"])
def test_modules_do_not_hide_functions(name: str) -> None:
    setattr(mp, name, importlib.import_module(f"mitlplan.{name}"))
    assert callable(getattr(mp, name))


def test_a_module_imported_first_does_not_hide_the_function_either() -> None:
    code = "import mitlplan.plan, mitlplan.check\nprint(callable(mitlplan.plan), callable(mitlplan.check))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "True True\n"  # noqa: S603


def test_importing_the_package_imports_nothing_else() -> None:
    code = "import sys, mitlplan\nprint(sorted(name for name in sys.modules if name.startswith('mitlplan')))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "['mitlplan']\n"  # noqa: S603


def test_a_version() -> None:
    assert re.fullmatch(r"\d+(\.\d+)*(\+\w+)?", mp.__version__)


def test_workspace_and_text(yard: mp.Workspace) -> None:
    outcome = mp.plan(yard, "(!A U B) & F A", start="r0c0")
    assert str(outcome) == "0 r0c0 -> 1 r0c1 -> 2 r0c0 -> 3 r1c0"
    assert str(mp.plan(yard, mp.parse("(!A U B) & F A"), start=(0, 0))) == str(outcome)


def test_the_options_of_a_mission(yard: mp.Workspace) -> None:
    outcome = mp.plan(yard, {"away": "G !B", "see": "F A"}, start="r0c0", horizon="finite")
    assert isinstance(outcome, mp.Plan)
    assert (outcome.makespan, outcome.loop) == (1, None)
    endless = mp.plan(yard, {"away": "G !B", "see": "F A"}, start="r0c0")
    assert isinstance(endless, mp.Plan)
    assert endless.makespan == 2
    assert isinstance(mp.plan(yard, "B U A", start="r0c1"), mp.Infeasible)
    open_bound = mp.plan(
        mp.graph({"hall": ["C"], "dock": []}, [mp.Move("hall", "dock", both=True)], waiting=True),
        "G[0,2] C & F[0,9] !C",
        start="hall",
        epsilon="1/8",
    )
    assert isinstance(open_bound, mp.Plan)
    assert (open_bound.attained, open_bound.makespan, open_bound.epsilon) == (False, 2, Fraction(1, 8))


def test_a_mission_read_from_a_file() -> None:
    mission = mp.read(EXAMPLES / "paper" / "phi1.yaml")
    outcome = mp.plan(mission)
    assert isinstance(outcome, mp.Plan)
    assert mp.check(mission, outcome) is None
    assert mp.check(mp.mission_for(mission.workspace, "G !B", start="pos0"), outcome) is not None


def test_decisions_take_texts() -> None:
    assert mp.satisfiable("F[1,2] A & G !A") == mp.Unsatisfiable()
    assert isinstance(mp.satisfiable(mp.parse("F A")), mp.Satisfiable)
    assert mp.valid("A | !A") == mp.Unsatisfiable()
    assert isinstance(mp.equivalent("F[0,2] A", "F[0,2) A"), mp.Satisfiable)


def test_a_mission_has_its_own_spec(yard: mp.Workspace) -> None:
    mission = mp.mission_for(yard, "F A", start="r0c0")
    with pytest.raises(
        TypeError, match="^a mission has its own spec and start; give these with a workspace$"
    ):
        mp.plan(mission, "F A")  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="^on a workspace there is nothing to plan without a spec$"):
        mp.plan(yard)  # type: ignore[call-overload]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"spec": "F Q"},
            """\
spec: No cell carries the proposition Q.
  F Q
    ^
  hint: the propositions are A, B (or give the map propositions: [Q])""",
        ),
        ({"spec": {}}, "spec: there is no requirement; write a formula or name: formula"),
        (
            {"spec": {"go": "F ("}},
            "spec.go: Expected a formula, but the text ends.\n  F (\n     ^",
        ),
        (
            {"start": "q"},
            "robot.start: no cell is called q; cells are r0c0 to r1c1, row first, counted from the top left",
        ),
        ({"horizon": "long"}, "horizon: infinite or finite is expected, not 'long'"),
        ({"until": "open"}, "until: standard or closed is expected, not 'open'"),
        ({"epsilon": 0}, "epsilon: a positive number is expected, such as 1/1000"),
        (
            {"epsilon": 0.5},
            "epsilon: 0.5 is not an exact number; write it as a text or a Fraction, such as '0.1'",
        ),
    ],
)
def test_what_cannot_be_a_mission(yard: mp.Workspace, given: dict[str, object], message: str) -> None:
    with pytest.raises(mp.MissionError) as caught:
        mp.mission_for(yard, **({"spec": "F A", "start": "r0c0"} | given))  # type: ignore[arg-type]
    assert str(caught.value) == message


def test_propositions_that_no_cell_carries(yard: mp.Workspace) -> None:
    mission = mp.mission_for(yard, "G !Q & F A", start="r0c0", propositions=["Q"])
    assert isinstance(mp.plan(mission), mp.Plan)
