"""How far a search has got, on stderr: silent for the first second, so that quick answers stay clean.

On a terminal one line is written over and over; in a log a line is added every few seconds.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction
from typing import TextIO

_SILENT = 1.0
_BETWEEN_ON_TERMINAL = 0.2
_BETWEEN_IN_LOG = 5.0
_CLEAR = "\r\x1b[K"


class ProgressLine:
    """Writes to `stream`; `clock` gives seconds from any origin."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._clock = clock
        self._terminal = stream.isatty()
        self._due = clock() + _SILENT
        self._written = False

    def show(self, states: int, lower_bound: Fraction | None, seconds: float) -> None:
        """Say how many states were explored, and below what no plan can be."""
        now = self._clock()
        if now < self._due:
            return
        self._due = now + (_BETWEEN_ON_TERMINAL if self._terminal else _BETWEEN_IN_LOG)
        self._written = True
        bound = "" if lower_bound is None else f", no plan before {lower_bound}"
        line = f"searching: {states} states{bound}, {seconds:.0f} s"
        self._stream.write(f"{_CLEAR}{line}" if self._terminal else f"{line}\n")
        self._stream.flush()

    def clear(self) -> None:
        """Leave the terminal's line free for what comes next."""
        if self._terminal and self._written:
            self._stream.write(_CLEAR)
            self._stream.flush()
