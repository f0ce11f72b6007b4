"""How late each step of a path may happen, against the definition taken literally."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from mitlplan import _core

Constraint = tuple[int, int, int]
"""``t[target] - t[source] >= weight``, as (source, target, weight)."""


def literally(planned: list[int], constraints: list[Constraint], step: int) -> int:
    """The earlier steps as planned, the rest unbounded; then every bound that follows, until none changes."""
    latest: list[float] = [*planned[:step], *([float("inf")] * (len(planned) - step))]
    while True:
        before = list(latest)
        for source, target, weight in constraints:
            if source >= step:
                latest[source] = min(latest[source], latest[target] - weight)
        if latest == before:
            return -1 if latest[step] == float("inf") else int(latest[step])


def natively(planned: list[int], constraints: list[Constraint], asked: list[int]) -> list[int]:
    source, target, weight = np.array(constraints, dtype=np.int64).reshape(-1, 3).T
    return list(
        _core.latest_times(
            np.array(planned, dtype=np.int64),
            source.astype(np.int32),
            target.astype(np.int32),
            np.ascontiguousarray(weight),
            np.zeros(len(constraints), dtype=np.uint8),
            np.array(asked, dtype=np.int32),
        )
    )


def random_path(random: Random) -> tuple[list[int], list[Constraint]]:
    planned = [0]
    while len(planned) < random.randint(1, 12):
        planned.append(planned[-1] + random.randint(1, 4))
    steps = len(planned)
    constraints = [(k, k + 1, random.randint(0, planned[k + 1] - planned[k])) for k in range(steps - 1)]
    for _ in range(random.randint(0, 2 * steps)):
        source, target = random.randrange(steps), random.randrange(steps)
        constraints.append((source, target, planned[target] - planned[source] - random.randint(0, 5)))
    random.shuffle(constraints)
    return planned, constraints


def test_random_paths() -> None:
    for seed in range(2000):
        planned, constraints = random_path(Random(seed))
        asked = list(range(len(planned)))
        expected = [literally(planned, constraints, step) for step in asked]
        assert natively(planned, constraints, asked) == expected, seed


def test_only_what_is_asked_is_answered_in_that_order() -> None:
    # Steps 1 apart at least, and the last one at most 10 after the first.
    constraints = [(0, 1, 1), (1, 2, 1), (2, 0, -10)]
    assert natively([0, 1, 2], constraints, [2, 1, 0]) == [10, 9, -1]


def test_planned_times_that_break_a_constraint_are_refused() -> None:
    with pytest.raises(ValueError, match="the planned times break a constraint"):
        natively([0, 1, 2], [(0, 1, 1), (1, 2, 1), (2, 0, -1)], [1])
