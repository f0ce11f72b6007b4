"""Random worlds of rectangles, and plans on them."""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate

import numpy as np
from hypothesis import strategies as st

from mitlplan.plan import Loop, Plan, Step
from mitlplan.workspace import UNLIMITED, Workspace
from mitlplan.workspace.names import ListedNames

STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))


def lattice(widths: list[float], heights: list[float], *, waiting: bool = True) -> Workspace:
    """Columns and rows of rectangles; any stay of a second or more may be followed by a move."""
    rows, columns = len(heights), len(widths)
    x = np.cumsum([0.0, *widths])
    y = np.cumsum([0.0, *heights])
    cells = [(row, column) for row in range(rows) for column in range(columns)]
    moves = sorted(
        (row * columns + column, (row + up) * columns + column + right)
        for row, column in cells
        for up, right in STEPS
        if 0 <= row + up < rows and 0 <= column + right < columns
    )
    ends = np.array(moves, dtype=np.int32).reshape(-1, 2)
    return Workspace(
        names=ListedNames([f"r{row}c{column}" for row, column in cells]),
        label_sets=(frozenset(),),
        label_of=np.zeros(len(cells), dtype=np.int32),
        source=ends[:, 0],
        target=ends[:, 1],
        durations=(Fraction(1, 10),),
        least=np.zeros(len(moves), dtype=np.int32),
        most=np.full(len(moves), UNLIMITED, dtype=np.int32),
        waiting=waiting,
        positions=np.array([((x[c] + x[c + 1]) / 2, (y[r] + y[r + 1]) / 2) for r, c in cells]),
        sizes=np.array([(widths[c], heights[r]) for r, c in cells]),
    )


def plan_of(cells: list[str], stays: list[Fraction], *, loop: int | None = None) -> Plan:
    """The cells in order; without a loop, a stay that is missing at the end is one of no length."""
    times = [Fraction(0), *accumulate(stays)]
    steps = tuple(
        Step(cell, enter, leave)
        for cell, enter, leave in zip(cells, times, [*times[1:], times[-1]], strict=False)
    )
    makespan = times[len(cells)] if len(times) > len(cells) else times[-1]
    if loop is None:
        return Plan(steps, makespan)
    return Plan(steps, makespan, loop=Loop(loop, makespan - steps[loop].enter))


sizes = st.lists(st.sampled_from([0.5, 1.0, 1.3, 2.5]), min_size=2, max_size=4)
stays = st.fractions(min_value=Fraction(1, 3), max_value=5, max_denominator=12)


@st.composite
def plans(draw: st.DrawFn, *, loops: bool = False) -> tuple[Workspace, Plan]:
    """A lattice and a walk on it; one that loops goes the same way back."""
    widths, heights = draw(sizes), draw(sizes)
    workspace = lattice(widths, heights)
    row, column = draw(st.integers(0, len(heights) - 1)), draw(st.integers(0, len(widths) - 1))
    walk = [(row, column)]
    for _ in range(draw(st.integers(1, 7))):
        around = [(walk[-1][0] + up, walk[-1][1] + right) for up, right in STEPS]
        inside = [(r, c) for r, c in around if 0 <= r < len(heights) and 0 <= c < len(widths)]
        walk.append(draw(st.sampled_from(inside)))
    if loops:
        walk += walk[-2:0:-1]
    names = [f"r{r}c{c}" for r, c in walk]
    times = draw(st.lists(stays, min_size=len(names), max_size=len(names)))
    if loops:
        return workspace, plan_of(names, times, loop=0)
    return workspace, plan_of(names, times[: len(names) - draw(st.integers(0, 1))])
