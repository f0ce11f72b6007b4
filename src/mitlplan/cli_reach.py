"""The command `reach`: the fastest trace of a UPPAAL model, with no UPPAAL needed.

The file is read (:mod:`mitlplan.formats.uppaal_read`), its query or another one is asked of the native
search, and the trace comes out with exact times, in the time units of the model. Exit codes are those of
`plan`: 0 reached, 1 proved unreachable, 3 a limit, or nothing known.
"""

from __future__ import annotations

import time
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mitlplan.cli_answers import FOUND, NONE, deliver, errors_reported, progress_shown
from mitlplan.cli_limits import LIMIT, began, held_to
from mitlplan.cli_options import MemoryLimit, Output, TimeLimit

if TYPE_CHECKING:
    from mitlplan.automata.timed_automaton import Network, Query
    from mitlplan.formats.uppaal_read import UppaalModel


class TraceForm(str, Enum):
    """How a trace is written."""

    text = "text"
    json = "json"


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""

    @app.command("reach")
    def reach_command(
        model: Annotated[Path, typer.Argument(metavar="MODEL.xml", help="A UPPAAL model.")],
        query: Annotated[
            str, typer.Option(metavar="QUERY", help="E<> ... or inf{...}: t, instead of the model's first.")
        ] = "",
        form: Annotated[
            TraceForm, typer.Option("--format", help="How the trace is written.")
        ] = TraceForm.text,
        any_trace: Annotated[
            bool, typer.Option("--any", help="Be content with any trace, not only the fastest.")
        ] = False,
        output: Output = None,
        time_limit: TimeLimit = None,
        memory_limit: MemoryLimit = None,
    ) -> None:
        """Find the fastest trace of a UPPAAL model to what its query names, or prove that there is none."""
        with errors_reported():
            from mitlplan.automata.timed_automaton import Network
            from mitlplan.formats.output import check_writable
            from mitlplan.formats.trace_output import reachable_to_json, reachable_to_text, status
            from mitlplan.search.fastest import Limits, Stopped
            from mitlplan.search.reach import Reachable, reach

            if output is not None:
                check_writable(output)
            begin = time.perf_counter()
            with progress_shown() as progress:
                limits = Limits(time_limit, memory_limit, progress, began())

                def work() -> tuple[Network, Reachable]:
                    nonlocal begin
                    network, asked = _read(model, query)
                    begin = time.perf_counter()
                    return network, reach(network, asked, limits, fastest=not any_trace)

                network, answer = held_to(
                    limits, work, lambda reason: (Network(()), Stopped(reason, None, 0))
                )
            if form is TraceForm.json:
                text = reachable_to_json(network, answer, time.perf_counter() - begin)
            else:
                text = reachable_to_text(network, answer)
            deliver(text, output)
            code = {"reached": FOUND, "unreachable": NONE}.get(status(answer), LIMIT)
        raise typer.Exit(code)


def _read(file: Path, query: str) -> tuple[Network, Query]:
    from mitlplan.errors import ModelError
    from mitlplan.formats.uppaal_query import read_query
    from mitlplan.formats.uppaal_read import read_uppaal
    from mitlplan.formats.uppaal_tree import MOST_BYTES

    try:
        with file.open("rb") as stream:
            text = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise ModelError(f"cannot be read: {error.strerror}", file=str(file)) from None
    model = read_uppaal(text, file=str(file))
    asked = read_query(query or _first(model), model)
    if asked.clock is not None and asked.clock in _disturbed(model.network):
        raise ModelError(
            f"inf is told of clocks that run from the start, and {asked.clock} is reset or stopped; ask E<>",
            file=str(file),
        )
    return model.network, asked


def _disturbed(network: Network) -> frozenset[str]:
    """The clocks that do not tell the time that has passed."""
    reset = (edge.resets for automaton in network.automata for edge in automaton.edges)
    stopped = (location.stopped for automaton in network.automata for location in automaton.locations)
    return frozenset[str]().union(*reset, *stopped)


def _first(model: UppaalModel) -> str:
    from mitlplan.errors import ModelError

    if not model.queries:
        raise ModelError('there is no query in the model; name one: --query "E<> P.done"', file=model.file)
    return model.queries[0]
