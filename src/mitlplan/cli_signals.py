"""What Ctrl-C and SIGTERM do to a command: it ends at once, with a sentence and an exit code of its own.

Three stages. Before a command begins and after it has ended there is nothing to clear away, and the process
ends where it stands. Within a command an exception is raised, so that files and processes that were begun are
taken away again. And where this is not heard in time, because a library computes or swallows it, the native
half ends the process (:mod:`mitlplan.search.last_word`). Only what Python does before the first line of ours
is beyond reach.

Signals belong to programs: nothing here happens where the package is used as a library.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from types import FrameType

    from mitlplan.search.last_word import LastWord

PATIENCE = 0.35
"""Seconds for an exception to be heard. Half a second is promised."""

_SENTENCES = {
    signal.SIGINT: "mitlplan: interrupted",
    signal.SIGTERM: "mitlplan: terminated",
}


class Signalled(KeyboardInterrupt):
    """A signal has come, Ctrl-C or another; to everyone who clears away they are the same.

    A class of its own for Ctrl-C, too: when KeyboardInterrupt itself leaves code that runs by `exec`, as that
    of dataclasses does, Python ends with a signal later on, whoever has caught it meanwhile.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        super().__init__(sentence(number))


def sentence(number: int) -> str:
    """What is said when a signal ends a command."""
    return _SENTENCES[signal.Signals(number)]


def code(number: int) -> int:
    """The exit code that shells give to whom a signal ends."""
    return 128 + number


def listen() -> None:
    """Hear signals from now on; those that whoever started the program has turned off stay so."""
    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
        if signal.getsignal(number) == usual:
            signal.signal(number, end)
    sys.unraisablehook = _only_errors


def listens() -> bool:
    """Whether this process is a program of ours, to which signals and limits belong."""
    return sys.unraisablehook is _only_errors


def end(number: int, _frame: FrameType | None = None) -> NoReturn:
    """Say what has happened and end here, without the time that Python takes to put everything away."""
    os.write(2, f"{sentence(number)}\n".encode())
    os._exit(code(number))


def _raise(number: int, _frame: FrameType | None) -> NoReturn:
    for each in _SENTENCES:
        # One is enough: a second must not disturb what the first has set off.
        signal.signal(each, signal.SIG_IGN)
    raise Signalled(number)


@contextmanager
def raised() -> Iterator[None]:
    """Within, signals become :class:`Signalled`."""
    heard = [number for number in _SENTENCES if signal.getsignal(number) is end]
    if not heard:
        yield
        return
    last_word()
    for number in heard:
        signal.signal(number, _raise)
    try:
        yield
    finally:
        for number in heard:
            signal.signal(number, end)


def last_word(more: Sequence[tuple[int, float, int, str]] = ()) -> LastWord:
    """See to it that signals end the process; `more` are (signal, seconds, exit code, sentence)."""
    from mitlplan.search.last_word import Word, have_the_last_word

    ours = [Word(number, PATIENCE, code(number), sentence(number)) for number in _SENTENCES]
    return have_the_last_word([*ours, *(Word(*each) for each in more)])


def _only_errors(what: sys.UnraisableHookArgs) -> None:
    # An exception that a destructor cannot pass on is lost. The last word stands in for those of ours.
    if issubclass(what.exc_type, Exception):
        sys.__unraisablehook__(what)
