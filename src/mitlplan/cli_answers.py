"""How a command ends: its answer on stdout or in a file, a sentence on stderr, and an exit code."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mitlplan import cli_signals
from mitlplan.cli_limits import LIMIT, room
from mitlplan.errors import MitlplanError, OutputError

if TYPE_CHECKING:
    from mitlplan.search.fastest import Progress

FOUND, NONE, BAD_INPUT, OUR_ERROR = 0, 1, 2, 70


def deliver(text: str, output: Path | None) -> None:
    """Write an answer whole: to a file, or to stdout."""
    from mitlplan.formats.output import write_whole

    if output is None:
        write_out(text)
    else:
        write_whole(output, text)


def write_out(text: str) -> None:
    """Write to stdout, whose reader may have gone away."""
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read has seen enough. What is still buffered must go somewhere when Python ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        raise OutputError(f"cannot write the answer: {error.strerror}") from None


def say(message: str) -> None:
    """Write a line to stderr."""
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


@contextmanager
def errors_reported() -> Iterator[None]:
    """Turn whatever goes wrong into a sentence and the exit code that belongs to it."""
    try:
        with cli_signals.raised(), room(None):
            yield
    except (typer.Exit, typer.BadParameter):
        raise  # has its code and its sentence already
    except MitlplanError as error:
        say(f"mitlplan: {error}")
        raise typer.Exit(BAD_INPUT) from None
    except OverflowError as error:
        say(f"mitlplan: the times of this mission are too large or too finely divided: {error}")
        raise typer.Exit(BAD_INPUT) from None
    except MemoryError:
        say("mitlplan: out of memory; nothing is known (--memory-limit stops the search earlier)")
        raise typer.Exit(LIMIT) from None
    except cli_signals.Signalled as stopped:
        cli_signals.end(stopped.number)
    except KeyboardInterrupt:
        say(cli_signals.sentence(signal.SIGINT))
        raise typer.Exit(cli_signals.code(signal.SIGINT)) from None
    except Exception:  # noqa: BLE001  # an error of ours must not leave with the code that means "infeasible"
        say(f"{traceback.format_exc()}mitlplan: this is an error in mitlplan; please report it")
        raise typer.Exit(OUR_ERROR) from None


@contextmanager
def progress_shown() -> Iterator[Callable[[Progress], None]]:
    """Whom to tell of progress: a line on stderr, which goes away at the end."""
    from mitlplan.formats.progress_line import ProgressLine

    line = ProgressLine(sys.stderr)
    try:
        yield lambda progress: line.show(progress.states, progress.lower_bound, progress.seconds)
    finally:
        line.clear()
