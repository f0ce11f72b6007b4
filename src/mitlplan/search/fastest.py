"""The fastest run: the native search, driven from Python.

The native search works for a fraction of a second at a time and comes back, so that Ctrl-C, progress and
limits of time need no callback inside its loop.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias, Union

import numpy as np

from mitlplan import _core
from mitlplan.search.schedule import Path
from mitlplan.search.tables import KINDS, Tables

SLICE = 0.1
"""Seconds the native search works before it comes back."""

MEGABYTE = 1_000_000


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
    started: float = 0.0

    def begin(self) -> Limits:
        """The same limits, with the clock started."""
        return Limits(self.seconds, self.megabytes, self.progress, time.monotonic())

    def remaining(self) -> float | None:
        """The seconds left."""
        return None if self.seconds is None else self.seconds - (time.monotonic() - self.started)

    def over(self) -> bool:
        """Whether no time is left."""
        remaining = self.remaining()
        return remaining is not None and remaining <= 0


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


def drive(
    search: _core.Search, tables: Tables, limits: Limits, most_states: int | None = None
) -> Stopped | None:
    """Runs a native search to its end, or until a limit stops it."""
    while True:
        remaining = limits.remaining()
        if remaining is None:
            status = search.run(SLICE)
        else:
            status = search.run(max(0.0, min(SLICE, remaining)), limit=max(0.0, remaining))
        if status in (1, 2):
            return None
        bound = Fraction(search.lower_bound, tables.scale)
        if status == 3:
            reason = f"the memory limit of {limits.megabytes} MB was reached"
            return Stopped(f"{reason} after {search.stored} states", bound, search.stored)
        elapsed = time.monotonic() - limits.started
        if limits.seconds is not None and elapsed >= limits.seconds:
            reason = f"the time limit of {limits.seconds:g} s was reached"
            return Stopped(f"{reason} after {search.stored} states", bound, search.stored)
        if most_states is not None and search.stored > most_states:
            return Stopped(f"the search was given up after {search.stored} states", bound, search.stored)
        if limits.progress is not None:
            limits.progress(Progress(search.stored, bound, elapsed))
