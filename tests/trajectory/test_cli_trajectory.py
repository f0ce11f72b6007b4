from __future__ import annotations

import csv
import io
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from mitlplan.cli import app

MISSION = """
mitlplan: 1
workspace:
  grid: {rows: 2, columns: 2, move_time: 1, waiting: WAITING, regions: {A: [[1, 0]], B: [[0, 1]]}}
robot: {start: [0, 0]}
spec: "SPEC"
"""
PHI1, PHI2 = "(!A U B) & F A", "G F[0,2] A"


def mission(folder: Path, spec: str = PHI1, *, waiting: bool = False) -> str:
    file = folder / "mission.yaml"
    file.write_text(MISSION.replace("SPEC", spec).replace("WAITING", str(waiting).lower()))
    return str(file)


def run(*arguments: str, code: int = 0) -> tuple[str, str]:
    result = CliRunner().invoke(app, list(arguments))
    assert result.exit_code == code, (result.output, result.exception)
    return result.stdout, result.stderr


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_csv_goes_to_the_terminal(here: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(run("trajectory", mission(here), "--step", "1/4")[0])))
    assert [row["t"] for row in rows[:5]] == ["0.0", "0.25", "0.5", "0.75", "1.0"]
    assert float(rows[-1]["t"]) == 3.5
    assert (float(rows[-1]["x"]), float(rows[-1]["y"])) == (0.5, 0.5)


def test_a_loop_is_followed_as_long_as_asked(here: Path) -> None:
    output, _ = run("trajectory", mission(here, PHI2), "--step", "1", "--until", "20")
    assert len(output.splitlines()) == 22


def test_json_into_a_file_of_a_plan_from_a_file(here: Path) -> None:
    steps = [
        ("r0c0", "0", "1", []),
        ("r0c1", "1", "2", ["B"]),
        ("r1c1", "2", "3", []),
        ("r1c0", "3", "3", ["A"]),
    ]
    plan = {
        "mitlplan": 1,
        "status": "plan",
        "makespan": "3",
        "steps": [
            {"cell": cell, "enter": enter, "leave": leave, "holds": holds}
            for cell, enter, leave, holds in steps
        ],
    }
    Path("plan.json").write_text(json.dumps(plan))
    assert run("trajectory", mission(here), "plan.json", "--format", "json", "-o", "found.json") == ("", "")
    found = json.loads(Path("found.json").read_text())
    assert [cell["cell"] for cell in found["cells"]] == ["r0c0", "r0c1", "r1c1", "r1c0"]
    assert found["cost"] == pytest.approx(0.25 + 2 * 3.0771054975 + 0.5)
    plan["steps"] = plan["steps"][:2]
    Path("plan.json").write_text(json.dumps(plan))
    assert (
        "plan.json: the plan is not one for this mission"
        in run("trajectory", mission(here), "plan.json", code=2)[1]
    )


@pytest.mark.parametrize("form", ["sqlite3", "mcap"])
def test_bags(here: Path, form: str) -> None:
    pytest.importorskip("rosbags")
    run("trajectory", mission(here), "--format", form, "--output", "bag")
    assert (here / "bag" / "metadata.yaml").exists()
    assert "it exists; a bag" in run("trajectory", mission(here), "--format", form, "-o", "bag", code=2)[1]
    assert "name it with --output" in run("trajectory", mission(here), "--format", form, code=2)[1]


@pytest.mark.parametrize("kind", ["svg", "png", "pdf", "gif"])
def test_pictures(here: Path, kind: str) -> None:
    run("draw", mission(here), "--output", f"plan.{kind}", "--robot", "radius=0.1")
    data = (here / f"plan.{kind}").read_bytes()
    assert data[:4] in (b"<?xm", b"\x89PNG", b"%PDF", b"GIF8")
    if kind == "gif":
        assert Image.open(io.BytesIO(data)).n_frames > 50


def test_a_picture_that_fails_leaves_the_one_before(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("plan.png").write_bytes(b"before")

    def no_space(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", no_space)
    sentence = run("draw", mission(here), "--output", "plan.png", code=2)[1]
    assert sentence.endswith("plan.png: No space left on device\n")
    assert Path("plan.png").read_bytes() == b"before"
    assert sorted(path.name for path in here.iterdir()) == ["mission.yaml", "plan.png"]


@pytest.mark.parametrize("shown", ["map", "plan", "trajectory"])
def test_what_is_shown(here: Path, shown: str) -> None:
    run("draw", mission(here), "--show", shown, "--title", "phi1")
    assert (here / "plan.svg").exists()


def test_a_map_needs_no_plan(here: Path) -> None:
    run("draw", mission(here, "F[0,1/2] A"), "--show", "map", "-o", "map.png")
    assert "no plan" in run("draw", mission(here, "F[0,1/2] A"), "-o", "plan.png", code=1)[1]


def test_how_it_is_driven(here: Path) -> None:
    file = mission(here)
    wishes = ["--drive", "turn=arc", "--drive", "u_turn=forward-only", "--drive", "reverse=yes"]
    backward = json.loads(run("trajectory", file, "--format", "json", *wishes)[0])
    assert "way in and out" in [motion["name"] for motion in backward["motions"]]
    names = {
        motion["name"]
        for motion in json.loads(run("trajectory", file, "--format", "json", *wishes[:4])[0])["motions"]
    }
    assert names == {"straight way", "forward-only U-turn", "arc turn"}
    smooth = run("trajectory", file, "--drive", "profile=cubic", "--step", "1/2")[0]
    controls = np.array([row.split(",")[4:] for row in smooth.splitlines()[1:]], dtype=float)
    assert (controls[::2] == 0).all()


def test_slack_is_spent(here: Path) -> None:
    file = mission(here, "F[0,8] A & F[0,20] B", waiting=True)
    plain = json.loads(run("trajectory", file, "--format", "json")[0])
    slow = json.loads(
        run("trajectory", file, "--format", "json", "--drive", "retime=true", "--drive", "deadline=20")[0]
    )
    assert slow["cost"] < plain["cost"] / 2
    assert Fraction(slow["cells"][-1]["enter"]) > Fraction(plain["cells"][-1]["enter"])


def test_the_mission_can_ask_for_it(here: Path) -> None:
    file = mission(here, "F[0,8] A & F[0,20] B", waiting=True)
    spoken = run("trajectory", file, "--drive", "retime=true", "--drive", "deadline=20")
    plain = run("trajectory", file)
    text = Path(file).read_text().replace("start: [0, 0]", "start: [0, 0], retime: true, deadline: 20")
    Path(file).write_text(text)
    assert run("trajectory", file) == spoken != plain
    assert run("trajectory", file, "--drive", "retime=false") == plain


def test_headings_have_names(here: Path) -> None:
    named = run("trajectory", mission(here), "--robot", "heading=west")[0]
    assert named == run("trajectory", mission(here), "--robot", f"heading={np.pi}")[0]
    assert float(named.splitlines()[1].split(",")[3]) == np.pi


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--robot", "sped=1"], "there is no sped; did you mean speed?"),
        (["--robot", "speed"], "write speed=VALUE"),
        (["--robot", "speed=fast"], "speed: 'fast' is not a number"),
        (["--robot", "speed=0"], "a limit is a positive number"),
        (["--robot", "heading=up"], "a heading is a number of radians or one of east, northeast"),
        (["--robot", "heading=nan"], "a heading is a number of radians or one of east, northeast"),
        (["--robot", "speed=1/2"], "r0c1, entered at 1: the three-point U-turn takes"),
        (["--drive", "turn=fast"], "turn: fast is none of free, forward-only, arc, three-point, spot"),
        (["--drive", "turn=three-point"], "a three-point turn is a U-turn"),
        (["--drive", "reverse=perhaps"], "reverse: perhaps is neither true nor false"),
        (["--drive", "linear_weight=0"], "positive numbers"),
        (["--drive", "deadline=9"], "a deadline is for --drive retime=true"),
        (["--step", "1/1000000000"], "too many"),
        (["-o", "nowhere/file.csv"], "there is no folder nowhere"),
    ],
)
def test_what_makes_no_sense_is_said_in_a_sentence(here: Path, arguments: list[str], sentence: str) -> None:
    output, said = run("trajectory", mission(here), *arguments, code=2)
    assert output == ""
    assert sentence in said
    assert "Traceback" not in said


def test_steps_are_positive(here: Path) -> None:
    for step in ("0", "-1", "soon"):
        assert "Invalid value for '--step'" in run("trajectory", mission(here), "--step", step, code=2)[1]


def test_pictures_of_other_kinds(here: Path) -> None:
    assert "its name ends in .svg" in run("draw", mission(here), "-o", "plan.bmp", code=2)[1]
    assert "only a trajectory moves" in run("draw", mission(here), "-o", "p.gif", "--show", "map", code=2)[1]
