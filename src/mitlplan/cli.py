"""The command line: read arguments, call one function, print its answer.

Results go to stdout and everything else to stderr; the exit code says which kind of answer it was: 0 a plan
(or yes), 1 a proof that there is none (or no), 2 bad input, 3 a limit stopped it, 130 interrupted, 143
terminated, and 70 an error of ours. Heavy libraries are imported by the commands that need them: help comes
at once.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TextIO

import typer

from mitlplan import cli_draw, cli_models, cli_reach, cli_trajectory
from mitlplan.cli_answers import FOUND, NONE, deliver, errors_reported, progress_shown, say, write_out
from mitlplan.cli_limits import LIMIT, began, held_to
from mitlplan.cli_options import (
    Construction,
    ConstructionOption,
    Horizon,
    MemoryLimit,
    MissionFile,
    Output,
    TimeLimit,
    Until,
    UntilChoice,
    positive_option,
    read_mission,
)

if TYPE_CHECKING:
    from mitlplan.engine import Engine
    from mitlplan.mission import Mission
    from mitlplan.plan import Outcome
    from mitlplan.planner import Answer
    from mitlplan.search.fastest import Limits

app = typer.Typer(
    name="mitlplan",
    help="Robot plans that meet their deadlines.",
    epilog="Exit codes: 0 found or yes, 1 proved impossible or no, 2 bad input, 3 a limit, 130 interrupted.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class Form(str, Enum):
    """How an answer is written."""

    text = "text"
    json = "json"
    csv = "csv"


class WitnessForm(str, Enum):
    """How the answer of a decision procedure is written."""

    text = "text"
    json = "json"


class EngineChoice(str, Enum):
    """What searches."""

    zones = "zones"
    reach = "reach"
    uppaal = "uppaal"


WitnessFormOption = Annotated[WitnessForm, typer.Option("--format", help="How the answer is written.")]
FormulaText = Annotated[str, typer.Argument(metavar="FORMULA", help="A formula, in quotes.")]


def main() -> None:
    """Run the command line; never returns."""
    app()


def _version(wanted: bool) -> None:
    if wanted:
        from mitlplan import __version__

        write_out(f"mitlplan {__version__}\n")
        raise typer.Exit(FOUND)


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass


# ------------------------------------------------------------------------------------------------ commands


@app.command("plan")
def plan_command(
    mission: MissionFile,
    form: Annotated[Form, typer.Option("--format", help="How the answer is written.")] = Form.text,
    output: Output = None,
    construction: ConstructionOption = Construction.compact,
    engine: Annotated[
        EngineChoice,
        typer.Option(
            help="What searches: the planner's own, or on the exported model reach or UPPAAL's verifyta."
        ),
    ] = EngineChoice.zones,
    until: Until = None,
    horizon: Horizon = None,
    epsilon: Annotated[
        str | None,
        typer.Option(
            metavar="SECONDS",
            callback=positive_option,
            help="How near to come to a makespan that none attains.",
        ),
    ] = None,
    time_limit: TimeLimit = None,
    memory_limit: MemoryLimit = None,
) -> None:
    """Find the fastest plan for a mission, or prove that there is none."""
    with errors_reported():
        from mitlplan.formats.output import check_writable
        from mitlplan.plan import LimitReached
        from mitlplan.search.fastest import Limits

        if output is not None:
            check_writable(output)
        search = _search(engine, construction)
        with progress_shown() as progress:
            limits = Limits(time_limit, memory_limit, progress, began())

            def work() -> Outcome:
                begin = time.perf_counter()
                read = read_mission(mission, until, horizon, epsilon)
                reading = time.perf_counter() - begin
                return _with_reading(search(read, limits), reading)

            outcome = held_to(limits, work, LimitReached)
        deliver(_written(outcome, form, to_terminal=output is None), output)
        code = _code(outcome)
    raise typer.Exit(code)


@app.command("check")
def check_command(
    mission: MissionFile,
    plan: Annotated[
        Path, typer.Argument(metavar="PLAN.json", help="A plan, as plan --format json writes it.")
    ],
    until: Until = None,
    horizon: Horizon = None,
) -> None:
    """Check a plan by the independent judge: can the robot go so, and is the mission then satisfied?"""
    with errors_reported():
        from mitlplan.check import check
        from mitlplan.errors import PlanFileError
        from mitlplan.formats.plan_json import read_plan
        from mitlplan.plan import Plan

        read = read_mission(mission, until, horizon)
        outcome = read_plan(plan)
        if not isinstance(outcome, Plan):
            raise PlanFileError(f"{plan}: there is no plan in it to check: {outcome.reason}")
        fault = check(read, outcome)
        write_out("satisfied\n" if fault is None else f"violated: {fault}\n")
    raise typer.Exit(FOUND if fault is None else NONE)


@app.command("schema")
def schema_command(output: Output = None) -> None:
    """Print the JSON Schema of mission files, for editors."""
    with errors_reported():
        from mitlplan.mission import schema

        deliver(json.dumps(schema(), indent=2) + "\n", output)


@app.command("satisfiable")
def satisfiable_command(
    formula: FormulaText,
    form: WitnessFormOption = WitnessForm.text,
    until: UntilChoice = UntilChoice.standard,
    time_limit: TimeLimit = None,
    memory_limit: MemoryLimit = None,
) -> None:
    """Is there any signal that satisfies a formula? Print one, or prove that there is none."""
    with errors_reported():
        from mitlplan.planner import satisfiable

        words = _Words(witness="satisfiable", none="unsatisfiable", witness_code=FOUND, none_code=NONE)
        code = _decide(satisfiable, (formula,), words, form, until, time_limit, memory_limit)
    raise typer.Exit(code)


@app.command("valid")
def valid_command(
    formula: FormulaText,
    form: WitnessFormOption = WitnessForm.text,
    until: UntilChoice = UntilChoice.standard,
    time_limit: TimeLimit = None,
    memory_limit: MemoryLimit = None,
) -> None:
    """Does every signal satisfy a formula? Prove it, or print a signal that does not."""
    with errors_reported():
        from mitlplan.planner import valid

        words = _Words(witness="not valid", none="valid", witness_code=NONE, none_code=FOUND)
        code = _decide(valid, (formula,), words, form, until, time_limit, memory_limit)
    raise typer.Exit(code)


@app.command("equivalent")
def equivalent_command(
    formula: FormulaText,
    other: Annotated[str, typer.Argument(metavar="OTHER", help="Another formula, in quotes.")],
    form: WitnessFormOption = WitnessForm.text,
    until: UntilChoice = UntilChoice.standard,
    time_limit: TimeLimit = None,
    memory_limit: MemoryLimit = None,
) -> None:
    """Do two formulas mean the same? Prove it, or print a signal that tells them apart."""
    with errors_reported():
        from mitlplan.planner import equivalent

        words = _Words(witness="not equivalent", none="equivalent", witness_code=NONE, none_code=FOUND)
        code = _decide(equivalent, (formula, other), words, form, until, time_limit, memory_limit)
    raise typer.Exit(code)


# ------------------------------------------------------------------------------------------------ searching


def _search(engine: EngineChoice, construction: Construction) -> Callable[[Mission, Limits], Outcome]:
    """What finds a plan; that a tool is missing is found out at once."""
    if construction is Construction.published:
        say(
            "mitlplan: warning: the published construction is unsound: what it finds may violate the "
            "mission, what it misses may satisfy it"
        )
        if engine is EngineChoice.zones:
            # Its model is no network of transducers in lock step, which that engine is made for.
            engine = EngineChoice.reach
    match engine:
        case EngineChoice.zones:
            from mitlplan.planner import plan

            return lambda mission, limits: plan(
                mission,
                construction="seed" if construction is Construction.seed else "compact",
                time_limit=limits.seconds,
                memory_limit=limits.megabytes,
                progress=limits.progress,
                since=limits.started,
            )
        case EngineChoice.reach:
            from mitlplan.search.reach import reach

            return _by(reach, engine, construction)
        case EngineChoice.uppaal:
            from functools import partial

            from mitlplan.formats.verifyta import fastest_trace, find_verifyta

            return _by(partial(fastest_trace, verifyta=find_verifyta()), engine, construction)


def _by(
    engine: Engine, choice: EngineChoice, construction: Construction
) -> Callable[[Mission, Limits], Outcome]:
    from mitlplan.engine import plan_by

    return lambda mission, limits: plan_by(
        engine, mission, name=choice.value, construction=construction.value, limits=limits
    )


# ------------------------------------------------------------------------------------------------ answering


def _with_reading(outcome: Outcome, seconds: float) -> Outcome:
    statistics = outcome.statistics
    return replace(outcome, statistics=replace(statistics, seconds={"read": seconds, **statistics.seconds}))


def _written(outcome: Outcome, form: Form, *, to_terminal: bool) -> str:
    match form:
        case Form.json:
            from mitlplan.formats.plan_json import plan_to_json

            return plan_to_json(outcome)
        case Form.csv:
            from mitlplan.formats.plan_csv import plan_to_csv

            return plan_to_csv(outcome)
        case Form.text:
            from mitlplan.formats.plan_text import plan_to_text

            width = shutil.get_terminal_size((100, 24)).columns
            return plan_to_text(outcome, colours=to_terminal and _colours_wanted(sys.stdout), width=width)


def _colours_wanted(stream: TextIO) -> bool:
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def _code(outcome: Outcome) -> int:
    from mitlplan.plan import Infeasible, LimitReached, Plan

    match outcome:
        case Plan():
            return FOUND if outcome.fault is None else NONE
        case Infeasible():
            return NONE
        case LimitReached():
            return LIMIT


@dataclass(frozen=True, slots=True)
class _Words:
    """What a witness and the proof that there is none mean for the question that was asked."""

    witness: str
    none: str
    witness_code: int
    none_code: int


def _decide(
    question: Callable[..., Answer],
    texts: tuple[str, ...],
    words: _Words,
    form: WitnessForm,
    until: UntilChoice,
    time_limit: float | None,
    memory_limit: int | None,
) -> int:
    from mitlplan.formats.witness import Witness, decision_to_json, decision_to_text
    from mitlplan.logic.parse import parse
    from mitlplan.plan import LimitReached
    from mitlplan.planner import Satisfiable
    from mitlplan.search.fastest import Limits

    with progress_shown() as progress:
        limits = Limits(time_limit, memory_limit, progress, began())

        def work() -> Answer:
            return question(
                *(parse(text) for text in texts),
                until=until.value,
                time_limit=time_limit,
                memory_limit=memory_limit,
                progress=progress,
                since=limits.started,
            )

        answer = held_to(limits, work, LimitReached)
    witness, reason = None, ""
    match answer:
        case Satisfiable(signal=signal):
            word, code = words.witness, words.witness_code
            stretches = [(segment.start, segment.holds) for segment in signal.segments]
            witness = Witness(tuple(stretches), signal.end, signal.repeat_from)
        case LimitReached():
            word, code, reason = "limit", LIMIT, answer.reason
        case _:
            word, code = words.none, words.none_code
    write = decision_to_json if form is WitnessForm.json else decision_to_text
    write_out(write(word, reason, witness))
    return code


cli_models.register(app)
cli_reach.register(app)
cli_trajectory.register(app)
cli_draw.register(app)
