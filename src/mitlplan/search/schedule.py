"""Exact times for the joint steps of a path, and how late each may happen.

Every guard and invariant met on the way is a difference constraint between two steps: the one that reads
the clock and the one that reset it. The native half solves them; here they are collected, and
infinitesimals become real numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan import _core
from mitlplan.search.tables import KINDS, Tables

STANDS_STILL = -1


@dataclass(frozen=True, eq=False)
class Path:
    """The joint steps from time 0 on.

    Parameters
    ----------
    steps
        int32, shape (steps, components): the edge of each component, the map's first (``STANDS_STILL`` if the
        robot makes no move). The first step is the one at time 0.
    last
        The kind of the last step: its edges of transducers are edges of that kind.
    """

    steps: NDArray[np.int32]
    last: str


@dataclass(frozen=True, slots=True)
class Difference:
    """``t[target] - t[source] >= weight``, or ``>`` if strict; in ticks."""

    source: int
    target: int
    weight: int
    strict: bool


@dataclass(frozen=True, slots=True)
class Schedule:
    """When each step happens, in seconds, and how much later it may (``None``: without limit)."""

    times: tuple[Fraction, ...]
    slack: tuple[Fraction | None, ...]


def differences(tables: Tables, path: Path) -> Iterator[Difference]:
    """The constraints that the guards and invariants along `path` put on the times of its steps."""
    arrays = tables.arrays
    guard_start = arrays["guard_start"]
    constraints = list(
        zip(
            arrays["guard_clock"].tolist(),
            arrays["guard_upper"].tolist(),
            arrays["guard_strict"].tolist(),
            arrays["guard_value"].tolist(),
            strict=True,
        )
    )
    reset_start, reset_clock = arrays["reset_start"], arrays["reset_clock"].tolist()
    reset_at = [0] * int(arrays["clocks"])

    def guarded(guard: int, step: int) -> Iterator[Difference]:
        for clock, upper, strict, value in constraints[guard_start[guard] : guard_start[guard + 1]]:
            origin = reset_at[clock]
            if upper:
                yield Difference(step, origin, -value, bool(strict))
            else:
                yield Difference(origin, step, value, bool(strict))

    count = len(path.steps)
    for step, edges in enumerate(path.steps.tolist()):
        kind = path.last if step == count - 1 else KINDS[0]
        taken = [
            (KINDS[0] if component == 0 else kind, edge)
            for component, edge in enumerate(edges)
            if edge != STANDS_STILL
        ]
        if step > 0:
            yield Difference(step - 1, step, 0, strict=True)
        for kind_of_edge, edge in taken:
            yield from guarded(int(arrays[f"{kind_of_edge}_guard"][edge]), step)
        if edges[0] == STANDS_STILL:
            here = _location_after(arrays, path, step, 0, STANDS_STILL)
            yield from guarded(int(arrays["location_still"][here]), step)
        if step == count - 1:
            return
        for kind_of_edge, edge in taken:
            resets = int(arrays[f"{kind_of_edge}_resets"][edge])
            for clock in reset_clock[reset_start[resets] : reset_start[resets + 1]]:
                reset_at[clock] = step
        for component, edge in enumerate(edges):
            location = _location_after(arrays, path, step, component, edge)
            yield from guarded(int(arrays["location_invariant"][location]), step + 1)


def _location_after(arrays: Any, path: Path, step: int, component: int, edge: int) -> int:
    while edge == STANDS_STILL:
        step -= 1
        edge = int(path.steps[step, component])
    return int(arrays["move_target"][edge])


Columns: TypeAlias = tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int64], NDArray[np.uint8]]


def columns(constraints: Iterable[Difference], factor: int = 1) -> Columns:
    """The constraints as the native half takes them, the weights multiplied by `factor`."""
    listed = list(dict.fromkeys(constraints))
    return (
        np.array([one.source for one in listed], dtype=np.int32),
        np.array([one.target for one in listed], dtype=np.int32),
        np.array([one.weight * factor for one in listed], dtype=np.int64),
        np.array([one.strict for one in listed], dtype=np.uint8),
    )


def schedule(tables: Tables, path: Path, epsilon: Fraction, asked: Sequence[int] | None = None) -> Schedule:
    """The earliest times along `path`; with strict bounds the end is within `epsilon` of its infimum.

    Parameters
    ----------
    epsilon
        In seconds.
    asked
        The steps whose slack is wanted; all by default. The others get ``None``.
    """
    constraints = list(dict.fromkeys(differences(tables, path)))
    count = len(path.steps)
    times = _core.earliest_times(count, *columns(constraints))
    scale = tables.scale * infinitesimals_a_tick(times, constraints, epsilon * tables.scale)
    factor = scale // tables.scale
    ticks = [time * factor + infinitesimals for time, infinitesimals in times]
    asked = list(range(count)) if asked is None else list(asked)
    latest = _core.latest_times(
        np.array(ticks, dtype=np.int64), *columns(constraints, factor), np.array(asked, dtype=np.int32)
    )
    slack: list[Fraction | None] = [None] * count
    for step, time in zip(asked, latest, strict=True):
        if step == 0:
            slack[0] = Fraction(0)
        elif time >= 0:
            slack[step] = Fraction(time - ticks[step], scale)
    return Schedule(tuple(Fraction(tick, scale) for tick in ticks), tuple(slack))


def infinitesimals_a_tick(
    times: Sequence[tuple[int, int]], constraints: Sequence[Difference], epsilon: Fraction
) -> int:
    """How many infinitesimals make a tick, so that constraints hold and the end is within `epsilon` ticks."""
    if all(infinitesimals == 0 for _, infinitesimals in times):
        return 1
    needed = max(1, -(-times[-1][1] * epsilon.denominator // epsilon.numerator))
    for one in constraints:
        late, early = times[one.target], times[one.source]
        spare = late[0] - early[0] - one.weight
        short = early[1] + one.strict - late[1]
        # spare * needed >= short, where spare is a positive number of ticks.
        if short > 0:
            needed = max(needed, -(-short // spare))
    return needed
