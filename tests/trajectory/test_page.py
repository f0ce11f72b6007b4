"""The numbers of docs/trajectory.md are those of the code."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from fractions import Fraction
from io import StringIO
from pathlib import Path

import pytest

from mitlplan.check import check
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


def test_the_python_of_the_page_runs_and_prints_what_it_says() -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    printed = StringIO()
    with redirect_stdout(printed):
        exec(code, {})  # noqa: S102  # the page is ours
    assert printed.getvalue().splitlines() == re.findall(r"^# (.*)$", code, flags=re.MULTILINE)


def test_pictures_exist() -> None:
    for target in re.findall(r"\]\((trajectory/[^)]+)\)", PAGE):
        assert (DOCS / target).exists(), target
