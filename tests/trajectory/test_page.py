"""The numbers of docs/trajectory.md are those of the code."""

from __future__ import annotations

import json
import re
import shlex
from fractions import Fraction
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mitlplan.check import check
from mitlplan.cli import app
from mitlplan.cli_trajectory import DRIVE_KEYS, ROBOT_KEYS
from mitlplan.formats.plan_json import read_plan
from mitlplan.formats.trajectory_csv import trajectory_to_csv
from mitlplan.mission import read
from mitlplan.plan import Plan
from mitlplan.planner import plan
from mitlplan.trajectory import Profile, Style, Weights, follow, turn_left, u_turn
from tests.trajectory.elementary import ELEMENTARY

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "trajectory.md").read_text(encoding="utf-8")
EQUAL = Weights()


def table(first: str) -> dict[str, list[str]]:
    """The rows of the table whose first heading is `first`, by their first entry."""
    rows = PAGE[PAGE.index(f"| {first} |") :].split("\n\n")[0].splitlines()[2:]
    cells = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]
    return {row[0]: row[1:] for row in cells}


def cost(first: str, name: str) -> float:
    return float(table(first)[name][0])


def test_the_table_of_costs() -> None:
    turn = turn_left(0.5, 0.5, EQUAL)
    assert turn is not None
    expected = {one.name: one.cost for one in ELEMENTARY} | {
        "quarter turn, cubic profile": turn.smoothed(Profile.CUBIC).cost,
        "quarter turn, quintic profile": turn.smoothed(Profile.QUINTIC).cost,
    }
    assert list(table("motion")) == list(expected)
    for name, value in expected.items():
        assert cost("motion", name) == pytest.approx(value, abs=6e-10)


def test_the_table_of_rectangles() -> None:
    for aspect, (free, _, _, forward, arc) in table("length : width").items():
        for text, style in ((free, Style.FREE), (forward, Style.FORWARD_ONLY), (arc, Style.ARC)):
            motion = turn_left(float(aspect) / 2, 0.5, EQUAL, style)
            assert motion is not None
            assert float(text) == pytest.approx(motion.cost, abs=6e-8)


def test_the_table_of_u_turns() -> None:
    for style in (Style.THREE_POINT, Style.FORWARD_ONLY, Style.SPOT):
        motion = u_turn(0.5, EQUAL, style)
        assert motion is not None
        assert cost("U-turn", f"`{style.value}`") == pytest.approx(motion.cost, abs=6e-8)


@pytest.mark.parametrize(
    ("name", "cells", "step"),
    [("phi1", 4, "1/20"), ("phi2", 2, "1/20"), ("random-32-32-20", 32, "1/10"), ("Berlin_1_256", 300, "1/2")],
)
def test_the_tables_of_samples_are_those_of_today(name: str, cells: int, step: str) -> None:
    mission = read(DOCS / "trajectory" / f"{name}.yaml")
    found = read_plan(DOCS / "trajectory" / f"{name}.json")
    assert isinstance(found, Plan)
    assert check(mission, found) is None
    today = plan(mission)
    assert isinstance(today, Plan)
    assert (len(found.steps), found.makespan) == (cells, today.makespan)
    written = (DOCS / "trajectory" / f"{name}.csv").read_text().splitlines()
    now = trajectory_to_csv(follow(found, mission.workspace), Fraction(step)).splitlines()
    assert len(written) == len(now)
    for old, new in zip(written[1:], now[1:], strict=True):
        assert [float(x) for x in old.split(",")] == pytest.approx(
            [float(x) for x in new.split(",")], abs=1e-9
        )


def test_the_commands_of_the_page_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "docs").symlink_to(DOCS)
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^    mitlplan (.*)$", PAGE, re.MULTILINE)
    assert len(commands) > 5
    for command in commands:
        result = CliRunner().invoke(app, shlex.split(command.partition("|")[0], comments=True))
        assert (result.exit_code, result.stderr) == (0, ""), command


def test_what_retiming_saves() -> None:
    mission = str(DOCS / "trajectory" / "phi1-late.yaml")
    costs = re.findall(r"falls from ([\d.]+) to ([\d.]+)", PAGE)
    for drive, told in zip(("retime=false", "retime=true"), *costs, strict=True):
        arguments = ["trajectory", mission, "--format", "json", "--drive", drive]
        found = json.loads(CliRunner().invoke(app, arguments).stdout)
        assert found["cost"] == pytest.approx(float(told), abs=5e-4)


def test_the_page_names_every_key_of_the_command_line() -> None:
    for option, keys in (("--drive", DRIVE_KEYS), ("--robot", ROBOT_KEYS)):
        named = re.findall(r"`(\w+)`", " ".join(table(f"key of `{option}`")))
        assert sorted(named) == sorted(keys)
