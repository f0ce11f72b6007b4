"""The end of a program that is asked to stop and does not, because it is deep in some library.

Only the native half can see to it (``native/last_word.hpp``): where the interpreter's lock is held, no Python
runs. It lives in this room because no other may import the native module; no search knows of it.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from dataclasses import dataclass

from mitlplan import _core


@dataclass(frozen=True, slots=True)
class Word:
    """What happens some seconds after a signal that nobody has answered.

    Parameters
    ----------
    number
        The signal.
    patience
        How many seconds.
    code, sentence
        The exit code, and what is said on stderr.
    """

    number: int
    patience: float
    code: int
    sentence: str


@dataclass(frozen=True, slots=True)
class LastWord:
    """The other end of the line to those who end the process."""

    descriptor: int

    def answered(self) -> None:
        """Call off what the signals so far would lead to."""
        os.write(self.descriptor, b"\0")


def have_the_last_word(words: Sequence[Word]) -> LastWord:
    """Let signals end this process; takes the wakeup descriptor of :mod:`signal`, for good."""
    heard, told = os.pipe()
    os.set_blocking(told, False)
    _core.have_the_last_word(
        heard, [(word.number, word.patience, word.code, f"{word.sentence}\n") for word in words]
    )
    signal.set_wakeup_fd(told, warn_on_full_buffer=False)
    return LastWord(told)
