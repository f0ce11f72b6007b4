"""The program `mitlplan-fuzz`: read arguments, run, print what was found.

What was found goes to stdout and everything else to stderr. Exit codes: 0 nothing was found, also if Ctrl-C
put an end to it; 1 something was; 2 bad input.
"""

from __future__ import annotations

import shlex
import sys
import time
from typing import Annotated

import typer

FIRST_SEED = 1_000_000
"""Beyond the seeds of the ordinary tests."""

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main() -> None:
    """Run the command line; never returns."""
    app(prog_name="mitlplan-fuzz")


@app.command()
def fuzz_command(
    seconds: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", min=0, help="Stop after so long; of readers, so long for each."),
    ] = None,
    cases: Annotated[int | None, typer.Option(metavar="COUNT", min=0, help="Stop after so many.")] = None,
    seed: Annotated[int, typer.Option(metavar="SEED", min=0, help="The first case.")] = FIRST_SEED,
    jobs: Annotated[int, typer.Option(metavar="COUNT", min=1, help="How many processes.")] = 1,
    readers: Annotated[
        bool, typer.Option("--readers", help="Fuzz the readers of files instead, guided by coverage.")
    ] = False,
    reader: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Only this reader; may be given again.")
    ] = None,
) -> None:
    """Ask engine, brute force, judge, rtamt and the paper's construction about random missions.

    Without --seconds and --cases it goes on until Ctrl-C.
    """
    if readers or reader:
        raise typer.Exit(_fuzz_readers(reader or [], 60.0 if seconds is None else seconds, seed))
    raise typer.Exit(_fuzz_missions(seed, seconds, cases, jobs))


def _fuzz_missions(seed: int, seconds: float | None, cases: int | None, jobs: int) -> int:
    from mitlplan_fuzz.oracles.rtamt_voice import NO_RTAMT, rtamt_is_there
    from mitlplan_fuzz.runner import Finding, Tally, fuzz

    line = _Line()
    begin = time.monotonic()

    def found(finding: Finding) -> None:
        line.clear()
        command = shlex.join(["mitlplan-fuzz", "--seed", str(finding.seed), "--cases", "1"])
        sys.stdout.write(
            "\n".join([f"# {command}", *(f"# {one}" for one in _lines(finding.sentences)), finding.case, ""])
        )
        sys.stdout.flush()

    def progress(tally: Tally) -> None:
        passed = time.monotonic() - begin
        each = f", {1000 * passed * jobs / tally.done:.0f} ms each" if tally.done else ""
        line.show(f"{tally.done} cases, {len(tally.findings)} disagreements{each}, {passed:.0f} s")

    if not rtamt_is_there():
        line.say(NO_RTAMT)
    tally = fuzz(seed, seconds=seconds, cases=cases, jobs=jobs, found=found, progress=progress)
    line.clear()
    if tally.interrupted:
        line.say("interrupted")
    line.say(
        f"{tally.done} cases from seed {seed} on, in {time.monotonic() - begin:.0f} s: "
        f"{len(tally.findings)} disagreements"
    )
    line.say("opinions: " + ", ".join(f"{voice} {count}" for voice, count in sorted(tally.votes.items())))
    if tally.gave_up:
        line.say(
            f"the engine gave up on {len(tally.gave_up)}: seeds {', '.join(map(str, sorted(tally.gave_up)))}"
        )
    return 1 if tally.findings else 0


def _lines(sentences: tuple[str, ...]) -> list[str]:
    return [line for sentence in sentences for line in sentence.splitlines()]


def _fuzz_readers(names: list[str], seconds: float, seed: int) -> int:
    from mitlplan_fuzz.readers import NO_ATHERIS, TARGETS, atheris_is_there, fuzz_reader

    line = _Line()
    unknown = [name for name in names if name not in TARGETS]
    if unknown:
        line.say(f"mitlplan-fuzz: there is no reader {unknown[0]}; there are {', '.join(TARGETS)}")
        return 2
    if not atheris_is_there():
        line.say(f"mitlplan-fuzz: {NO_ATHERIS}")
        return 2
    findings = 0
    try:
        for name in names or TARGETS:
            report = fuzz_reader(name, max(1, round(seconds)), seed, line.show)
            line.clear()
            line.say(f"{name}: {report.executions} inputs, {len(report.findings)} findings")
            findings += len(report.findings) or bool(report.message)
            for file in report.findings:
                sys.stdout.write(
                    shlex.join(["python", "-m", "mitlplan_fuzz.readers", name, str(file)]) + "\n"
                )
            if report.message:
                sys.stdout.write(report.message + "\n")
            sys.stdout.flush()
    except KeyboardInterrupt:
        line.clear()
        line.say("interrupted")
    return 1 if findings else 0


class _Line:
    """Progress on stderr: a line that is written over on a terminal, a line every few seconds in a log."""

    BETWEEN_IN_LOG = 10.0

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()
        self._due = time.monotonic() + (0 if self._terminal else self.BETWEEN_IN_LOG)

    def show(self, text: str) -> None:
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + (0.2 if self._terminal else self.BETWEEN_IN_LOG)
        sys.stderr.write(f"\r\x1b[K{text}" if self._terminal else f"{text}\n")
        sys.stderr.flush()

    def clear(self) -> None:
        if self._terminal:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def say(self, text: str) -> None:
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()
