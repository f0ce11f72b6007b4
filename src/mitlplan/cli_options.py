"""What several groups of commands share: exit codes, options, and a line of progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from mitlplan.search.fastest import Progress

FOUND, NONE, BAD_INPUT, LIMIT, OUR_ERROR = 0, 1, 2, 3, 70

Reported = Callable[[], AbstractContextManager[None]]
"""Turns whatever goes wrong into a sentence and the exit code that belongs to it."""


def _finite_option(seconds: float | None) -> float | None:
    if seconds is not None and not 0 < seconds < float("inf"):
        raise typer.BadParameter("a positive number of seconds is expected")
    return seconds


Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write here instead of to stdout.")
]
TimeLimit = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", callback=_finite_option, help="Stop so long after the start."),
]
MemoryLimit = Annotated[
    int | None, typer.Option(metavar="MB", min=1, help="Stop when the work holds so much.")
]


@contextmanager
def progress_shown() -> Iterator[Callable[[Progress], None]]:
    """Whom to tell of progress: a line on stderr, which goes away at the end."""
    import sys

    from mitlplan.formats.progress_line import ProgressLine

    line = ProgressLine(sys.stderr)
    try:
        yield lambda progress: line.show(progress.states, progress.lower_bound, progress.seconds)
    finally:
        line.clear()
