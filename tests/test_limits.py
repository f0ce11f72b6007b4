"""Commands that are stopped: by limits, in every stage, and by signals, at any moment.

Other tests run beside these, so nothing is told of tenths of seconds: benchmarks/limits.py measures them.
"""

from __future__ import annotations

import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from mitlplan import planner
from mitlplan.cli_limits import began, held_to
from mitlplan.errors import OutOfTime
from mitlplan.mission import mission_from_mapping
from mitlplan.plan import Infeasible, LimitReached, Plan
from mitlplan.planner import plan, satisfiable
from mitlplan.search.fastest import Limits

EXAMPLES = Path(__file__).parents[1] / "examples"

sanitized = pytest.mark.skipif(
    "MITLPLAN_NATIVE" in os.environ, reason="the address sanitizer takes memory of its own"
)


def grid(size: int, spec: Any, **more: Any) -> dict[str, Any]:
    regions = {"a": [[size - 1, size - 1]], "b": [[0, size - 1]]}
    return {
        "mitlplan": 1,
        "workspace": {"grid": {"rows": size, "columns": size, "regions": regions, **more}},
        "robot": {"start": "r0c0"},
        "spec": spec,
    }


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A mission that takes long to read, and much memory."""
    file = tmp_path / "large.json"
    file.write_text(json.dumps(grid(2000, "F a & F b")), encoding="utf-8")
    return file


def started(*arguments: str | Path) -> subprocess.Popen[str]:
    return subprocess.Popen(  # noqa: S603  # the command line under test
        [sys.executable, "-m", "mitlplan", *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def program(body: str) -> subprocess.Popen[str]:
    """A program that listens to signals, says "begun", and does what is given within a command."""
    script = (
        "from mitlplan import cli, cli_answers, cli_signals\n"
        "cli_signals.listen()\n"
        "@cli.app.command('busy')\n"
        "def busy():\n"
        "    with cli_answers.errors_reported():\n"
        "        print('begun', flush=True)\n"
        f"{textwrap.indent(textwrap.dedent(body), ' ' * 8)}\n"
        "cli.app(['busy'])\n"
    )
    return subprocess.Popen(  # noqa: S603
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def until_it_listens(process: subprocess.Popen[str]) -> None:
    """Python's own start is over once SIGTERM, which it leaves alone, is caught."""
    caught = 0
    while process.poll() is None and not caught >> (signal.SIGTERM - 1) & 1:
        status = Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
        found = re.search(r"SigCgt:\s+([0-9a-f]+)", status)
        caught = int(found[1], 16) if found else 0
        time.sleep(0.001)


MOMENTS = [0.0, *random.Random(7).sample([hundredths / 100 for hundredths in range(150)], 9)]


# ------------------------------------------------------------------------------------------------ signals


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("moment", MOMENTS)
def test_a_signal_at_any_moment(large: Path, tmp_path: Path, number: signal.Signals, moment: float) -> None:
    """From the first line of ours on, while libraries are loaded, and while the mission is read."""
    output = tmp_path / "plan.json"
    process = started("plan", large, "--format", "json", "--output", output)
    until_it_listens(process)
    time.sleep(moment)
    process.send_signal(number)
    written, messages = process.communicate(timeout=30)
    sentence = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}[number]
    assert (process.returncode, written, messages) == (128 + number, "", f"mitlplan: {sentence}\n")
    assert [file.name for file in tmp_path.iterdir()] == [large.name]


@pytest.mark.parametrize(
    "body",
    [
        pytest.param("sum(range(10**12))", id="a library that computes, with the interpreter's lock"),
        pytest.param(
            """
            while True:
                try:
                    while True:
                        pass
                except BaseException:
                    pass
            """,
            id="a library that swallows every exception",
        ),
        pytest.param(
            """
            class Deaf:
                def __del__(self):
                    while True:
                        pass
            Deaf()
            """,
            id="a destructor, which cannot pass on an exception",
        ),
    ],
)
@pytest.mark.parametrize(("number", "word"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")])
def test_who_does_not_listen_is_ended(body: str, number: signal.Signals, word: str) -> None:
    # After the destructor the program would end by itself: nothing may come of that either.
    process = program(f"{textwrap.dedent(body)}\nwhile True: pass")
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    process.send_signal(number)
    _, messages = process.communicate(timeout=30)
    assert (process.returncode, messages) == (128 + number, f"mitlplan: {word}\n")


def test_what_was_begun_is_cleared_away(tmp_path: Path) -> None:
    """SIGTERM in the midst of writing."""
    process = program(f"""
        import os, pathlib, time
        from mitlplan.formats.output import write_whole
        pathlib.Path.replace = lambda *_: (print('writing', flush=True), time.sleep(30))
        write_whole(pathlib.Path({str(tmp_path / "plan.json")!r}), 'half')
    """)
    assert process.stdout is not None
    assert [process.stdout.readline(), process.stdout.readline()] == ["begun\n", "writing\n"]
    assert len(list(tmp_path.iterdir())) == 1
    process.send_signal(signal.SIGTERM)
    _, messages = process.communicate(timeout=30)
    assert (process.returncode, messages) == (143, "mitlplan: terminated\n")
    assert list(tmp_path.iterdir()) == []


def test_signals_that_were_turned_off_stay_so() -> None:
    process = subprocess.run(  # noqa: S603
        [
            *("sh", "-c", 'trap "" INT; exec "$0" "$@"', sys.executable, "-c"),
            "import os; from mitlplan.cli_signals import *; listen(); os.kill(os.getpid(), 2); print(1)",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert process.stdout == "1\n"


# ------------------------------------------------------------------------------------------------- limits


def ended(*arguments: str | Path) -> tuple[int, str]:
    process = started(*arguments)
    written, messages = process.communicate(timeout=50)
    assert "Traceback" not in messages
    return process.returncode, written + messages


def heavy_formula() -> str:
    return " & ".join(f"(F[0,{i}] (a | b)) | G[{i},{2 * i + 1}] (b & F[1,{i + 2}] a)" for i in range(1, 900))


@pytest.mark.parametrize("stage", ["reading", "translation", "satisfiable"])
def test_a_time_limit_holds_in_every_stage(large: Path, tmp_path: Path, stage: str) -> None:
    file = tmp_path / "formula.json"
    file.write_text(json.dumps(grid(6, heavy_formula())), encoding="utf-8")
    command = {
        "reading": ("plan", large),
        "translation": ("plan", file),
        "satisfiable": ("satisfiable", heavy_formula()),
    }[stage]
    code, said = ended(*command, "--time-limit", "1")
    assert code == 3
    assert "the time limit of 1 s was reached" in said


def test_the_last_word_on_time() -> None:
    process = program("""
        from mitlplan.cli_limits import held_to
        from mitlplan.search.fastest import Limits
        held_to(Limits(seconds=0.5).begin(), lambda: sum(range(10**12)), str)
    """)
    _, messages = process.communicate(timeout=30)
    assert (process.returncode, messages) == (3, "mitlplan: the time limit of 0.5 s was reached\n")


@sanitized
@pytest.mark.parametrize("form", ["text", "json"])
def test_a_memory_limit_holds_while_reading(large: Path, tmp_path: Path, form: str) -> None:
    output = tmp_path / "plan"
    code, said = ended("plan", large, "--memory-limit", "60", "--format", form, "--output", output)
    assert (code, said) == (3, "")
    assert "the memory limit of 60 MB was reached" in output.read_text(encoding="utf-8")


@sanitized
@pytest.mark.parametrize("megabytes", [1, 2, 3])
@pytest.mark.parametrize(
    "command",
    [
        ("plan", EXAMPLES / "patrol-berlin.yaml"),
        ("plan", EXAMPLES / "paper" / "phi1.yaml"),
        ("satisfiable", "G F[0,2] a & F b"),
    ],
)
def test_with_next_to_no_memory_there_is_a_sentence(command: tuple[str | Path, ...], megabytes: int) -> None:
    """Libraries that are loaded, and Python itself, then fail in ways of their own."""
    assert ended(*command, "--memory-limit", str(megabytes))[0] in (0, 3)


@sanitized
def test_no_more_memory_is_no_crash(large: Path) -> None:
    """Here the shell sets the bound; where nobody does, what the machine has to give is one."""
    process = subprocess.run(  # noqa: S603
        [
            *("sh", "-c", 'ulimit -d 400000; exec "$0" "$@"', sys.executable, "-m", "mitlplan"),
            *("plan", str(large)),
        ],
        capture_output=True,
        text=True,
        check=False,
        timeout=50,
    )
    assert (process.returncode, process.stdout) == (3, "")
    assert process.stderr == (
        "mitlplan: out of memory; nothing is known (--memory-limit stops the search earlier)\n"
    )


def test_the_clock_of_a_command_starts_with_its_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """And where the command line is called within another program, with the call."""
    before = time.monotonic()
    assert began() >= before
    monkeypatch.setattr("mitlplan.cli_limits.listens", lambda: True)
    assert began() < before


# ---------------------------------------------------------------------------------------------- the library


@pytest.fixture
def nothing_changes() -> Iterator[None]:
    """Limits of the process and its signals belong to the program that uses the library."""
    before = resource.getrlimit(resource.RLIMIT_DATA), signal.getsignal(signal.SIGALRM)
    yield
    assert before == (resource.getrlimit(resource.RLIMIT_DATA), signal.getsignal(signal.SIGALRM))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("nothing_changes")
def test_the_clock_may_have_started_before_the_call() -> None:
    mission = mission_from_mapping(grid(4, "F a & F b"))
    longer = plan(mission, time_limit=60, memory_limit=100, since=time.monotonic() - 3)
    assert isinstance(longer, Plan)
    late = time.monotonic() - 5
    for outcome in (
        plan(mission, time_limit=4, since=late),
        satisfiable("F a", time_limit=4, since=late),
    ):
        assert isinstance(outcome, LimitReached)
        assert outcome.reason == "the time limit of 4 s was reached"


@pytest.mark.usefixtures("nothing_changes")
def test_only_programs_are_held() -> None:
    assert held_to(Limits(0.01, 1).begin(), lambda: bytes(5_000_000), lambda _: b"") == bytes(5_000_000)


@pytest.mark.parametrize("error", [OutOfTime, MemoryError])
def test_a_plan_in_hand_is_given_away(monkeypatch: pytest.MonkeyPatch, error: type[BaseException]) -> None:
    def over(*_: object) -> None:
        raise error

    monkeypatch.setattr(planner, "slack_of", over)
    outcome = plan(mission_from_mapping(grid(4, "F a & F b")))
    assert isinstance(outcome, Plan)
    assert outcome.checked


def test_a_plan_that_parks_is_given_away_without_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    def over(*_: object) -> None:
        raise OutOfTime

    monkeypatch.setattr(planner, "fastest_loop", over)
    outcome = plan(mission_from_mapping(grid(4, "F G a", waiting=True)), time_limit=60)
    assert isinstance(outcome, Plan)
    assert outcome.checked
    assert (outcome.makespan, outcome.bound) == (6, Fraction(0))


def test_a_proof_stays_one_without_its_reasons(monkeypatch: pytest.MonkeyPatch) -> None:
    class Slow(planner._Planning):
        def outcome(self, *, fastest: bool = True) -> Any:
            if not fastest:
                raise OutOfTime
            return super().outcome()

    monkeypatch.setattr(planner, "_Planning", Slow)
    outcome = plan(mission_from_mapping(grid(4, {"soon": "F[0,2] a", "visit": "F b"})))
    assert isinstance(outcome, Infeasible)
    assert outcome.conflict == ("soon", "visit")
