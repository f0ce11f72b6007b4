"""Exact times for the joint steps of a path, and how late each may happen.

Every guard and invariant met on the way is a difference constraint between two steps: the one that reads
the clock and the one that reset it. The native half collects and solves them; here infinitesimals become
real numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mitlplan import _core
from mitlplan.search.tables import Tables

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


Columns: TypeAlias = tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int64], NDArray[np.uint8]]
"""Sources, targets, weights and strictness of constraints, as the native half takes them."""


def differences(tables: Tables, path: Path) -> Columns:
    """The constraints that the guards and invariants along `path` put on the times of its steps."""
    steps = np.ascontiguousarray(path.steps, dtype=np.int32).reshape(-1)
    return _core.differences(tables.arrays, steps, path.last)


def listed(constraints: Columns) -> list[Difference]:
    """The distinct constraints, one by one."""
    rows = zip(*(column.tolist() for column in constraints), strict=True)
    return [
        Difference(source, target, weight, bool(strict))
        for source, target, weight, strict in dict.fromkeys(rows)
    ]


def columns(constraints: Sequence[Difference], factor: int = 1) -> Columns:
    """The constraints as the native half takes them, the weights multiplied by `factor`."""
    return (
        np.array([one.source for one in constraints], dtype=np.int32),
        np.array([one.target for one in constraints], dtype=np.int32),
        np.array([one.weight * factor for one in constraints], dtype=np.int64),
        np.array([one.strict for one in constraints], dtype=np.uint8),
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
    constraints = differences(tables, path)
    count = len(path.steps)
    times = _core.earliest_times(count, *constraints)
    factor = 1
    if any(infinitesimals for _, infinitesimals in times):
        distinct = listed(constraints)
        factor = infinitesimals_a_tick(times, distinct, epsilon * tables.scale)
        constraints = columns(distinct, factor)
    scale = tables.scale * factor
    ticks = [time * factor + infinitesimals for time, infinitesimals in times]
    asked = list(range(count)) if asked is None else list(asked)
    latest = _core.latest_times(
        np.array(ticks, dtype=np.int64), *constraints, np.array(asked, dtype=np.int32)
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
