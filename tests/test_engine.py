"""Plans by way of the exported model: the planner's own answers, and those of the published construction."""

from __future__ import annotations

import json
import os
import re
import signal
import stat
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from mitlplan.cli import app
from mitlplan.engine import plan_by
from mitlplan.mission import Mission, mission_for
from mitlplan.plan import Infeasible, LimitReached, Plan
from mitlplan.planner import plan
from mitlplan.search.fastest import Limits
from mitlplan.search.reach import reach
from mitlplan.workspace import grid
from mitlplan_fuzz.comparison import mission_of
from mitlplan_fuzz.missions import random_mission
from tests.formats.test_verifyta import OLD, pretended, split
from tests.formats.verifyta_double import SPELLINGS, verifier

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def paper(text: str) -> Mission:
    workspace = grid(2, 2, regions={"A": [[1, 0]], "B": [[0, 1]]})
    return mission_for(workspace, text, start="r0c0")


def stops(found: Plan) -> list[tuple[str, Fraction]]:
    return [(step.cell, step.enter) for step in found.steps]


@pytest.mark.parametrize("first", range(0, 200, 50))
def test_the_model_of_a_random_mission_has_the_same_least_makespan(first: int) -> None:
    compared = 0
    for seed in range(first, first + 50):
        mission = mission_of(random_mission(seed))
        answer = plan_by(reach, mission, name="reach", limits=Limits(seconds=5))
        expected = plan(mission, time_limit=20)
        match answer, expected:
            case Plan(), Plan():
                # Those that go round for ever are not sought by way of the model.
                assert answer.checked
                assert answer.makespan >= expected.makespan, seed
                if answer.bound is not None:
                    assert (answer.makespan, answer.attained) == (expected.makespan, expected.attained), seed
            case Plan(), _:
                pytest.fail(f"seed {seed}: a plan where the planner says {expected}")
            case Infeasible(), _:
                assert isinstance(expected, Infeasible), seed
            case _:
                assert isinstance(answer, LimitReached)
                continue
        compared += 1
    assert compared >= 30


def test_the_paper_s_own_plans() -> None:
    first = plan_by(reach, paper("(!A U B) & F A"), name="reach", construction="published")
    assert isinstance(first, Plan)
    assert stops(first) == [("r0c0", 0), ("r0c1", 1), ("r0c0", 2), ("r1c0", 3)]
    assert (first.checked, first.bound, first.loop) == (True, None, None)
    second = plan_by(reach, paper("G F[0,2] A"), name="reach", construction="published")
    assert isinstance(second, Plan)
    assert stops(second) == [("r0c0", 0), ("r1c0", 1)]
    assert second.loop is not None
    assert (second.loop.start, second.loop.period, second.checked) == (0, 2, True)
    third = plan_by(reach, paper("F[0,4] A & F[0,4] B"), name="reach", construction="published")
    assert isinstance(third, Plan)
    assert (third.makespan, third.checked) == (4, True)


def test_a_limit_stops_the_published_construction_too() -> None:
    """The model of phi4 has 16 clocks, and takes minutes."""
    mission = paper("F[2,4] A & F[0,2] B")
    found = plan_by(reach, mission, name="reach", construction="published", limits=Limits(seconds=1e-6))
    assert isinstance(found, LimitReached)
    assert found.bound is None
    assert re.fullmatch(r"the time limit of 1e-06 s was reached after \d+ states", found.reason)


def test_what_a_search_has_found_when_it_is_stopped_is_not_said_to_be_the_fastest() -> None:
    mission = paper("F[2,4] A & F[0,2] B")
    found = plan_by(reach, mission, name="reach", construction="published", limits=Limits(seconds=1))
    assert isinstance(found, (Plan, LimitReached))
    assert isinstance(found, LimitReached) or found.bound != found.makespan


def test_what_the_published_construction_accepts_may_be_no_plan() -> None:
    """Its generator cycles in no time: A is six moves away, and its own deadline is 4 (docs/paper.md)."""
    workspace = grid(1, 7, regions={"A": [[0, 6]]})
    mission = mission_for(workspace, "F[2,4] A", start="r0c0")
    found = plan_by(reach, mission, name="reach", construction="published")
    assert isinstance(found, Plan)
    assert not found.checked
    assert found.fault is not None
    assert "F[2,4] A does not hold" in found.fault
    assert isinstance(plan(mission), Infeasible)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["plan", *map(str, arguments)])


def test_the_judge_s_word_on_the_command_line(tmp_path: Path) -> None:
    file = tmp_path / "far.yaml"
    file.write_text(
        "mitlplan: 1\nworkspace: {grid: {rows: 1, columns: 7, regions: {A: [[0, 6]]}}}\n"
        'robot: {start: r0c0}\nspec: "F[2,4] A"\n'
    )
    result = run(file, "--construction", "published", "--format", "json")
    answer = json.loads(result.stdout)
    assert (result.exit_code, answer["status"], answer["checked"]) == (1, "plan", False)
    assert "F[2,4] A does not hold" in answer["fault"]
    assert "unsound" in result.stderr
    text = run(file, "--construction", "published").stdout
    assert "violated, says the judge: " in text


@pytest.mark.parametrize("engine", ["zones", "reach"])
def test_engines_on_the_command_line(engine: str) -> None:
    result = run(EXAMPLES / "paper" / "phi4.yaml", "--engine", engine, "--format", "json")
    answer = json.loads(result.stdout)
    assert (result.exit_code, answer["makespan"], answer["bound"]) == (0, "3", "3")
    assert answer["statistics"]["engine"] == engine


def test_uppaal_s_verifier_as_the_engine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    output, errors = split(OLD)
    program = pretended(tmp_path, output=output, errors=errors)
    monkeypatch.setenv("MITLPLAN_VERIFYTA", str(program))
    result = run(
        EXAMPLES / "paper" / "phi1.yaml",
        *("--engine", "uppaal", "--construction", "published", "--format", "json"),
    )
    answer = json.loads(result.stdout)
    assert result.exit_code == 0
    assert [step["cell"] for step in answer["steps"]] == ["pos0", "pos1", "pos0", "pos3"]
    assert (answer["makespan"], answer["checked"]) == ("3", True)
    assert answer["statistics"]["engine"] == "uppaal"


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("construction", ["compact", "seed", "published"])
def test_the_verifier_is_asked_and_understood_whatever_the_model(
    construction: str, spelling: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It gets nothing but the exported model; what it prints is a plan for the mission again."""
    monkeypatch.setenv("PATH", str(verifier(tmp_path, spelling).parent), prepend=os.pathsep)
    for name in ("phi1", "phi2", "phi3"):
        command = (EXAMPLES / "paper" / f"{name}.yaml", "--construction", construction, "--format", "json")
        asked, own = (run(*command, "--engine", engine) for engine in ("uppaal", "reach"))
        assert asked.exit_code == own.exit_code
        told = json.loads(asked.stdout.replace("not by uppaal", "not by reach"))
        assert told | {"statistics": None} == json.loads(own.stdout) | {"statistics": None}


def test_without_the_verifier_a_sentence_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MITLPLAN_VERIFYTA", raising=False)
    monkeypatch.setenv("PATH", "")
    result = run(EXAMPLES / "paper" / "phi1.yaml", "--engine", "uppaal")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "UPPAAL comes from https://uppaal.org" in result.stderr


def slow_verifier(folder: Path) -> tuple[Path, Path]:
    """A script that starts a program of its own, as verifyta is installed; and the file that one makes."""
    mark = folder / "alive"
    program = folder / "verifyta"
    program.write_text(f"#!/bin/sh\n(sleep 2; touch {mark}) &\ntouch {folder / 'begun'}\nwait\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program, mark


def test_the_verifier_ends_with_the_time_limit_and_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program, mark = slow_verifier(tmp_path)
    monkeypatch.setenv("MITLPLAN_VERIFYTA", str(program))
    # Within this process the clock starts with the call, not with Python.
    finished = run(EXAMPLES / "paper" / "phi1.yaml", "--engine", "uppaal", "--time-limit", "0.3")
    assert finished.exit_code == 3
    assert "verifyta was stopped at the time limit of 0.3 s" in finished.stdout
    time.sleep(2.2)
    assert not mark.exists()


def test_the_verifier_ends_with_an_interrupt(tmp_path: Path) -> None:
    program, mark = slow_verifier(tmp_path)
    process = subprocess.Popen(  # noqa: S603  (the command line under test)
        [
            sys.executable,
            "-m",
            "mitlplan",
            "plan",
            str(EXAMPLES / "paper" / "phi1.yaml"),
            "--engine",
            "uppaal",
        ],
        env=os.environ | {"MITLPLAN_VERIFYTA": str(program)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (tmp_path / "begun").exists():
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    written, messages = process.communicate(timeout=30)
    assert (process.returncode, written, messages) == (130, "", "mitlplan: interrupted\n")
    time.sleep(2.2)
    assert not mark.exists()
