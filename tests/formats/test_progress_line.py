from __future__ import annotations

import io
from fractions import Fraction

from mitlplan.formats.progress_line import ProgressLine


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def run(stream: io.StringIO, seconds: int) -> str:
    """Ten reports a second."""
    now = 0.0
    line = ProgressLine(stream, clock=lambda: now)
    for tick in range(10 * seconds):
        now = tick / 10
        line.show(1000 * tick, Fraction(tick, 20) if tick > 15 else None, now)
    line.clear()
    return stream.getvalue()


def test_a_quick_search_says_nothing() -> None:
    assert run(io.StringIO(), 1) == ""
    assert run(Terminal(), 1) == ""


def test_a_log_gets_a_line_every_few_seconds() -> None:
    assert run(io.StringIO(), 12).splitlines() == [
        "searching: 10000 states, 1 s",
        "searching: 60000 states, no plan before 3, 6 s",
        "searching: 110000 states, no plan before 11/2, 11 s",
    ]


def test_a_terminal_has_one_line_that_is_cleared_at_the_end() -> None:
    shown = run(Terminal(), 2)
    assert "\n" not in shown
    assert shown.startswith("\r\x1b[Ksearching: 10000 states, 1 s\r\x1b[K")
    assert shown.endswith("\r\x1b[K")
