"""Signals: what is true when.

A signal is piecewise constant and right-continuous: each segment holds its set of propositions on
``[start, end)``. After the last segment it either repeats a final stretch for ever, or is unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise


@dataclass(frozen=True, slots=True)
class Segment:
    """The propositions that hold from `start` to the next segment's start."""

    start: Fraction
    holds: frozenset[str]


@dataclass(frozen=True, slots=True)
class Signal:
    """A signal on ``[0, inf)`` or, if it does not repeat, on the closed ``[0, end]``.

    Parameters
    ----------
    segments
        In order of time, the first starting at 0; the last start may equal `end` when the signal does not
        repeat (a label known at that instant only).
    end
        Where the last segment ends; unless the signal repeats, the last instant that is known.
    repeat_from
        ``None``, or the time to which the signal jumps back at `end`: for t >= repeat_from its value at
        ``t + (end - repeat_from)`` equals its value at t.
    """

    segments: tuple[Segment, ...]
    end: Fraction
    repeat_from: Fraction | None = None

    def __post_init__(self) -> None:
        starts = [segment.start for segment in self.segments]
        if not starts or starts[0] != 0:
            raise ValueError("a signal starts at time 0")
        if any(later <= earlier for earlier, later in pairwise(starts)):
            raise ValueError("the segments of a signal are in order of time")
        if self.repeat_from is None:
            if self.end < starts[-1]:
                raise ValueError("a signal ends after its last segment has started")
        elif not (0 <= self.repeat_from < self.end and starts[-1] < self.end):
            raise ValueError("the part of a signal that repeats has a positive duration")
