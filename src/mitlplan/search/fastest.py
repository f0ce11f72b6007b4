"""The fastest run: the native search, driven from Python.

The native search works for a fraction of a second at a time and comes back, so that Ctrl-C, progress and
limits of time need no callback inside its loop.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeAlias, Union

import numpy as np

from mitlplan import _core
from mitlplan.errors import OutOfTime
from mitlplan.search.schedule import Path
from mitlplan.search.tables import KINDS, Tables

SLICE = 0.1
"""Seconds the native search works before it comes back."""

MEGABYTE = 1_000_000

FOUND, EXHAUSTED, OUT_OF_MEMORY = 1, 2, 3
"""How a native search stands; 0 is that it is not done."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a search has got.

    Parameters
    ----------
    states
        Zones stored.
    lower_bound
        No plan is faster, in seconds; ``None`` before anything is known.
    seconds
        Since the search began.
    """

    states: int
    lower_bound: Fraction | None
    seconds: float


@dataclass(frozen=True, slots=True)
class Limits:
    """When to stop searching: seconds and megabytes, ``None`` for no limit; and whom to tell of progress."""

    seconds: float | None = None
    megabytes: int | None = None
    progress: Callable[[Progress], None] | None = None
    started: float | None = None

    def begin(self) -> Limits:
        """The same limits, with the clock started if it does not run yet."""
        return self if self.started is not None else replace(self, started=time.monotonic())

    @property
    def elapsed(self) -> float:
        """The seconds since the clock was started."""
        return 0.0 if self.started is None else time.monotonic() - self.started

    def remaining(self) -> float | None:
        """The seconds left."""
        return None if self.seconds is None else self.seconds - self.elapsed

    def over(self) -> bool:
        """Whether no time is left."""
        remaining = self.remaining()
        return remaining is not None and remaining <= 0

    def look(self) -> None:
        """Raise :class:`~mitlplan.errors.OutOfTime` if no time is left."""
        if self.over():
            raise OutOfTime

    @property
    def out_of_time(self) -> str:
        """What is said when the time is over."""
        return f"the time limit of {self.seconds or 0:g} s was reached"

    @property
    def out_of_memory(self) -> str:
        """What is said when there is no more memory."""
        if self.megabytes is None:
            return "there was no more memory"
        return f"the memory limit of {self.megabytes} MB was reached"


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """A run that reaches the goal first, at `time` seconds; not attained if bounds along it are strict.

    `bytes` is the memory that the search used for its `states`.
    """

    path: Path
    time: Fraction
    attained: bool
    states: int
    bytes: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Exhausted:
    """There is no run: every state was looked at; `bytes` as in :class:`Found`."""

    states: int
    bytes: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Stopped:
    """A limit stopped the search; no run is faster than `lower_bound` seconds."""

    reason: str
    lower_bound: Fraction | None
    states: int


Result: TypeAlias = Union[Found, Exhausted, Stopped]


def fastest_run(
    tables: Tables,
    limits: Limits,
    *,
    endings: bool = True,
    parkings: bool = True,
    horizon: Fraction | None = None,
) -> Result:
    """The run of the network that reaches a goal at the least time.

    Parameters
    ----------
    endings, parkings
        Which steps are goals: after which nothing is owed, and after which the robot may stay for ever.
    horizon
        Goals later than this, in seconds, are of no interest.
    """
    search = _core.Search(
        tables.arrays,
        endings=endings,
        parkings=parkings,
        horizon=-1 if horizon is None else int(horizon * tables.scale),
        memory=0 if limits.megabytes is None else limits.megabytes * MEGABYTE,
    )
    stopped = drive(search, tables, limits)
    if stopped is not None:
        return stopped
    goal = search.goal
    if search.found:
        steps, last = search.path()
        path = Path(np.asarray(steps).reshape(-1, tables.components), KINDS[last])
        return Found(path, Fraction(goal[0], tables.scale), not goal[1], search.stored, search.bytes)
    return Exhausted(search.stored, search.bytes)


def run(search: _core.Search | _core.Reachability, limits: Limits) -> int:
    """Let a native search work for a slice of time; how it then stands."""
    remaining = limits.remaining()
    try:
        if remaining is None:
            return search.run(SLICE)
        return search.run(max(0.0, min(SLICE, remaining)), limit=max(0.0, remaining))
    except MemoryError:
        # What it has proved so far stands.
        return OUT_OF_MEMORY


def drive(
    search: _core.Search, tables: Tables, limits: Limits, most_states: int | None = None
) -> Stopped | None:
    """Runs a native search to its end, or until a limit stops it."""
    while True:
        status = run(search, limits)
        if status in (FOUND, EXHAUSTED):
            return None
        bound = Fraction(search.lower_bound, tables.scale)
        if status == OUT_OF_MEMORY:
            return Stopped(f"{limits.out_of_memory} after {search.stored} states", bound, search.stored)
        if limits.over():
            return Stopped(f"{limits.out_of_time} after {search.stored} states", bound, search.stored)
        if most_states is not None and search.stored > most_states:
            return Stopped(f"the search was given up after {search.stored} states", bound, search.stored)
        if limits.progress is not None:
            limits.progress(Progress(search.stored, bound, limits.elapsed))
