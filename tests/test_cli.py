from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from mitlplan import mission as mission_module
from mitlplan import planner
from mitlplan.cli import app
from mitlplan.mission import Mission
from mitlplan.plan import Infeasible, LimitReached, Outcome, Plan, Step

EXAMPLES = Path(__file__).parents[1] / "examples"
PHI1 = str(EXAMPLES / "paper" / "phi1.yaml")
PLAN = Plan((Step("pos0", Fraction(0), Fraction(0)),), Fraction(0), bound=Fraction(0), checked=True)

PHI1_CSV = """\
step,cell,enter,leave,holds,slack,next
0,pos0,0,1,,0,1
1,pos1,1,2,B,0,2
2,pos0,2,3,,0,3
3,pos3,3,3,A,0,
"""


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments], prog_name="mitlplan")


def started(*arguments: str | Path, **options: Any) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "mitlplan", *map(str, arguments)]
    return subprocess.Popen(command, text=True, **options)  # noqa: S603


@pytest.fixture
def answered(monkeypatch: pytest.MonkeyPatch) -> Callable[[Outcome | BaseException], list[dict[str, Any]]]:
    """Lets the planner give an answer of the test's choice; returns what it was asked."""

    def answer_with(outcome: Outcome | BaseException) -> list[dict[str, Any]]:
        asked: list[dict[str, Any]] = []

        def plan(mission: Mission, **options: Any) -> Outcome:
            asked.append({"mission": mission, **options})
            if isinstance(outcome, BaseException):
                raise outcome
            return outcome

        monkeypatch.setattr(planner, "plan", plan)
        return asked

    return answer_with


# -------------------------------------------------------------------------------------------------- plan


def test_a_plan_as_text() -> None:
    result = run("plan", PHI1)
    assert result.exit_code == 0
    assert result.stderr == ""
    assert [" ".join(line.split()) for line in result.stdout.splitlines()][:7] == [
        "time cell stay holds slack",
        "0 pos0 1 0",
        "1 pos1 1 B 0",
        "2 pos0 1 0",
        "3 pos3 0 A 0",
        "done at 3",
        "makespan 3 (fastest, 3 moves, checked)",
    ]


def test_a_plan_as_csv() -> None:
    result = run("plan", PHI1, "--format", "csv")
    assert (result.exit_code, result.stdout, result.stderr) == (0, PHI1_CSV, "")


def test_a_plan_as_json() -> None:
    result = run("plan", PHI1, "--format", "json")
    answer = json.loads(result.stdout)
    assert (answer["status"], answer["makespan"], answer["checked"]) == ("plan", "3", True)
    assert [step["cell"] for step in answer["steps"]] == ["pos0", "pos1", "pos0", "pos3"]


def test_no_plan_has_a_code_of_its_own() -> None:
    result = run("plan", EXAMPLES / "rescue-infeasible.yaml", "--format", "json")
    answer = json.loads(result.stdout)
    assert result.exit_code == 1
    assert (answer["status"], answer["conflict"]) == ("infeasible", ["find", "keep clear"])


@pytest.mark.parametrize(
    ("outcome", "code", "text"),
    [
        (PLAN, 0, "makespan 0 (fastest, 0 moves, checked)\n"),
        (Infeasible("too far"), 1, "No plan: too far\n"),
        (LimitReached("60 seconds are over"), 3, "Stopped: 60 seconds are over\n"),
    ],
)
def test_each_answer_has_its_code(
    answered: Callable[..., object], outcome: Outcome, code: int, text: str
) -> None:
    answered(outcome)
    result = run("plan", PHI1)
    assert result.exit_code == code
    assert re.search(
        re.escape(text) + r"compact: 0 locations, 0 edges, 0 zones, \d+\.\d\d s\n$", result.stdout
    )
    assert result.stderr == ""


def test_the_time_is_told_by_stage() -> None:
    seconds = {}
    for mission in ("paper/phi1.yaml", "paper/phi2.yaml", "rescue-infeasible.yaml"):
        answer = json.loads(run("plan", EXAMPLES / mission, "--format", "json").stdout)
        seconds[mission] = answer["statistics"]["seconds"]
    assert list(seconds["paper/phi1.yaml"]) == ["read", "translate", "search", "check", "slack"]
    assert list(seconds["paper/phi2.yaml"]) == ["read", "translate", "loops", "check", "slack"]
    assert list(seconds["rescue-infeasible.yaml"]) == ["read", "translate", "search", "loops", "conflict"]


def test_the_options_reach_the_planner(answered: Callable[..., list[dict[str, Any]]]) -> None:
    asked = answered(PLAN)
    options = ["--until", "closed", "--horizon", "finite", "--epsilon", "1/7", "--time-limit", "2.5"]
    assert run("plan", PHI1, *options, "--memory-limit", "100", "--construction", "compact").exit_code == 0
    (question,) = asked
    mission = question["mission"]
    assert (mission.until, mission.horizon, mission.epsilon) == ("closed", "finite", Fraction(1, 7))
    assert (question["time_limit"], question["memory_limit"]) == (2.5, 100)
    assert question["construction"] == "compact"


def test_without_options_the_mission_decides(answered: Callable[..., list[dict[str, Any]]]) -> None:
    asked = answered(PLAN)
    run("plan", PHI1)
    mission = asked[0]["mission"]
    assert (mission.until, mission.horizon, mission.epsilon) == ("standard", "infinite", Fraction(1, 1000))
    assert (asked[0]["time_limit"], asked[0]["memory_limit"]) == (None, None)


@pytest.mark.parametrize(
    "options",
    [
        ["--format", "xml"],
        ["--until", "open"],
        ["--horizon", "7"],
        ["--construction", "clever"],
        ["--time-limit", "0"],
        ["--time-limit", "-1"],
        ["--time-limit", "nan"],
        ["--time-limit", "inf"],
        ["--time-limit", "soon"],
        ["--memory-limit", "0"],
        ["--epsilon", "0"],
        ["--epsilon", "-1"],
        ["--epsilon", "1e400"],
        ["--epsilon", "little"],
        ["--fast"],
        ["another"],
    ],
)
def test_bad_usage_is_refused_before_anything_is_read(
    answered: Callable[..., list[dict[str, Any]]], options: list[str]
) -> None:
    asked = answered(PLAN)
    result = run("plan", PHI1, *options)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Usage: mitlplan plan" in result.stderr
    assert asked == []


# -------------------------------------------------------------------------------------------- output file


def test_an_output_file_takes_the_place_of_stdout(tmp_path: Path) -> None:
    file = tmp_path / "plan.csv"
    result = run("plan", PHI1, "--format", "csv", "--output", file)
    assert (result.exit_code, result.stdout) == (0, "")
    assert file.read_text(encoding="utf-8") == PHI1_CSV
    assert list(tmp_path.iterdir()) == [file]


def test_an_output_file_without_a_folder_is_refused_before_the_search(
    answered: Callable[..., list[dict[str, Any]]], tmp_path: Path
) -> None:
    asked = answered(PLAN)
    file = tmp_path / "no" / "plan.csv"
    result = run("plan", PHI1, "-o", file)
    assert result.exit_code == 2
    assert result.stderr == f"mitlplan: cannot write {file}: there is no folder {file.parent}\n"
    assert asked == []


# ------------------------------------------------------------------------------------------- what goes wrong


def test_a_bad_mission(tmp_path: Path) -> None:
    file = tmp_path / "mission.yaml"
    file.write_text("mitlplan: 1\nworkspaces: {}\n", encoding="utf-8")
    result = run("plan", file)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"mitlplan: {file}:2:1: unknown key 'workspaces'; did you mean 'workspace'?\n"


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (KeyboardInterrupt(), 130, "mitlplan: interrupted\n"),
        (
            MemoryError(),
            3,
            "mitlplan: out of memory; nothing is known (--memory-limit stops the search earlier)\n",
        ),
        (
            OverflowError("2**63 ticks"),
            2,
            "mitlplan: the times of this mission are too large or too finely divided: 2**63 ticks\n",
        ),
    ],
)
def test_what_stops_a_search(
    answered: Callable[..., object], error: BaseException, code: int, message: str
) -> None:
    answered(error)
    result = run("plan", PHI1)
    assert (result.exit_code, result.stdout, result.stderr) == (code, "", message)


def test_an_error_of_ours_is_no_proof(answered: Callable[..., object]) -> None:
    answered(AssertionError("impossible"))
    result = run("plan", PHI1)
    assert result.exit_code == 70
    assert "AssertionError: impossible" in result.stderr
    assert result.stderr.endswith("mitlplan: this is an error in mitlplan; please report it\n")


def test_warnings_are_messages(answered: Callable[..., object], monkeypatch: pytest.MonkeyPatch) -> None:
    answered(PLAN)
    read = mission_module.read

    def read_with_warning(*arguments: Any, **options: Any) -> Mission:
        return replace(read(*arguments, **options), warnings=("an until that never holds",))

    monkeypatch.setattr(mission_module, "read", read_with_warning)
    result = run("plan", PHI1)
    assert result.exit_code == 0
    assert result.stderr == f"{PHI1}: warning: an until that never holds\n"


def test_progress_is_a_message(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mitlplan.formats.progress_line._SILENT", -1.0)

    def plan(_: Mission, *, progress: Callable[[planner.Progress], None], **__: Any) -> Outcome:
        for states in (10, 20, 30):
            progress(planner.Progress(states, Fraction(7, 2), 2.0))
        return PLAN

    monkeypatch.setattr(planner, "plan", plan)
    result = run("plan", PHI1)
    assert result.stderr == "searching: 10 states, no plan before 7/2, 2 s\n"
    assert "searching" not in result.stdout


# ------------------------------------------------------------------------------------------- other commands


def test_a_plan_that_was_written_passes_the_check(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    for name in ("phi1", "phi2", "phi3", "phi4"):
        mission = EXAMPLES / "paper" / f"{name}.yaml"
        assert run("plan", mission, "--format", "json", "-o", plan).exit_code == 0
        result = run("check", mission, plan)
        assert (result.exit_code, result.stdout, result.stderr) == (0, "satisfied\n", "")


def test_a_plan_that_does_not_pass(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    run("plan", PHI1, "--format", "json", "-o", plan)
    text = plan.read_text(encoding="utf-8")
    plan.write_text(text.replace('"enter": "1"', '"enter": "1/2"'), encoding="utf-8")
    result = run("check", PHI1, plan)
    assert (result.exit_code, result.stderr) == (1, "")
    assert result.stdout == "violated: steps[0] (pos0): the robot leaves at 1, but enters pos1 at 1/2\n"


def test_the_check_takes_the_same_overrides(tmp_path: Path) -> None:
    mission, plan = tmp_path / "mission.yaml", tmp_path / "plan.json"
    text = Path(PHI1).read_text(encoding="utf-8").replace('"F A"', '"!A U A"')
    mission.write_text(text, encoding="utf-8")
    run("plan", mission, "--format", "json", "-o", plan)
    assert run("check", mission, plan).exit_code == 0
    assert run("check", mission, plan, "--until", "closed").exit_code == 1


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            '{"mitlplan": 1, "status": "infeasible", "reason": "too far"}',
            ": there is no plan in it to check: too far",
        ),
        ("[1,", ":1:4: this is no JSON: Expecting value"),
    ],
)
def test_a_plan_file_that_is_none(tmp_path: Path, content: str, message: str) -> None:
    plan = tmp_path / "plan.json"
    plan.write_text(content, encoding="utf-8")
    result = run("check", PHI1, plan)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"mitlplan: {plan}{message}\n")


def test_the_schema_is_printed() -> None:
    result = run("schema")
    assert result.exit_code == 0
    assert json.loads(result.stdout) == mission_module.schema()


def test_a_formula_that_can_hold() -> None:
    result = run("satisfiable", "F[1,2] A")
    assert result.exit_code == 0
    assert result.stdout.startswith("satisfiable\nfrom 0: ")


def test_a_formula_that_cannot_hold() -> None:
    result = run("satisfiable", "F[1,2] A & G !A", "--format", "json")
    assert result.exit_code == 1
    answer = {"mitlplan": 1, "status": "unsatisfiable", "reason": None, "witness": None}
    assert json.loads(result.stdout) == answer


def test_the_other_decisions() -> None:
    assert run("valid", "F[0,2] A -> F[0,3] A").stdout == "valid\n"
    result = run("valid", "F[0,3] A -> F[0,2] A")
    assert result.exit_code == 1
    assert result.stdout.startswith("not valid\nfrom 0: ")
    assert run("equivalent", "F A", "!G !A").exit_code == 0
    assert run("equivalent", "A U B", "A U (A & B)").exit_code == 1
    assert run("equivalent", "A U B", "A U (A & B)", "--until", "closed").exit_code == 0


def test_a_decision_that_a_limit_stops(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planner, "satisfiable", lambda *_, **__: LimitReached("60 seconds are over"))
    result = run("satisfiable", "F A")
    assert (result.exit_code, result.stdout) == (3, "limit: 60 seconds are over\n")


def test_a_formula_that_cannot_be_read() -> None:
    result = run("satisfiable", "F[0,2 A")
    assert result.exit_code == 2
    assert result.stderr == (
        "mitlplan: Expected `]` or `)` to end the interval, but found `A`.\n  F[0,2 A\n        ^\n"
        "  hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)\n"
    )


def test_help_and_version() -> None:
    shown = run("--help").stdout
    for command in ("plan", "check", "schema", "satisfiable", "valid", "equivalent"):
        assert f"  {command} " in shown
    assert "Exit codes: 0 found or yes" in shown
    assert run("--version").stdout.startswith("mitlplan")
    assert run("plan", "--help").exit_code == 0
    assert run("plans").exit_code == 2


# --------------------------------------------------------------------------------------- a process of its own


def test_help_waits_for_no_heavy_library() -> None:
    # Newer versions of typer themselves use pydantic to describe an option.
    modules = "numpy, scipy, lark, ruamel.yaml, rich, mitlplan.planner"
    script = (
        "import sys\nfrom mitlplan.cli import app\n"
        "try:\n    app(['plan', '--help'])\nexcept SystemExit:\n    pass\n"
        f"print([name for name in '{modules}'.split(', ') if name in sys.modules], file=sys.stderr)"
    )
    process = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)  # noqa: S603
    assert process.stderr == "[]\n"


def test_a_reader_that_goes_away_is_no_error() -> None:
    process = started("schema", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    assert process.wait(timeout=30) == 0
    assert process.stderr is not None
    assert process.stderr.read() == ""
    process.stderr.close()


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    ours, theirs = pty.openpty()
    yield ours, theirs
    os.close(ours)


@pytest.mark.parametrize(
    ("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)]
)
def test_colours_on_a_terminal(
    terminal: tuple[int, int], environment: dict[str, str], coloured: bool
) -> None:
    ours, theirs = terminal
    clean = {key: value for key, value in os.environ.items() if key != "NO_COLOR"}
    process = started("plan", PHI1, stdout=theirs, env={**clean, "TERM": "xterm", **environment})
    os.close(theirs)
    assert process.wait(timeout=30) == 0
    shown = os.read(ours, 100_000).decode()
    assert "makespan 3" in shown
    assert ("\x1b[" in shown) is coloured


def test_an_interrupt_ends_a_search_with_one_line(tmp_path: Path) -> None:
    script = tmp_path / "search.py"
    script.write_text(
        "import sys, time\n"
        "from mitlplan import planner\n"
        "from mitlplan.cli import app\n"
        "def plan(mission, *, progress, **_):\n"
        "    print('searching', flush=True)\n"
        "    while True:\n"
        "        time.sleep(0.05)\n"
        "planner.plan = plan\n"
        "app(sys.argv[1:])\n",
        encoding="utf-8",
    )
    process = subprocess.Popen(  # noqa: S603
        [sys.executable, script, "plan", PHI1], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "searching\n"
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, messages = process.communicate(timeout=30)
    assert time.monotonic() - sent < 5
    assert (process.returncode, messages) == (130, "mitlplan: interrupted\n")


# ------------------------------------------------------------------------------------ commands from elsewhere


def test_models_and_trajectories_are_commands_too() -> None:
    assert run("translate", PHI1, "--to", "tchecker").stdout.count("process:") >= 1
    assert run("trajectory", PHI1).exit_code == 2  # a graph has no geometry
    help_text = run("--help").stdout
    for command in ("plan", "check", "satisfiable", "translate", "trajectory", "draw"):
        assert f"\n  {command} " in help_text


def test_their_codes_are_kept() -> None:
    infeasible = run("trajectory", EXAMPLES / "warehouse-infeasible.yaml")
    assert (infeasible.exit_code, infeasible.stdout) == (1, "")
    neither = run("draw")
    assert neither.exit_code == 2
    assert "name a mission or a figure, and not both" in neither.stderr
    assert "error in mitlplan" not in infeasible.stderr + neither.stderr
