"""Missions whose searches take long, each in its own way."""

from __future__ import annotations

import random
from typing import Any

GOALS = 8
MANY = 12

HARD = {
    # The bound of the best tour says little about claims that start a clock.
    "many goals": " & ".join(f"F (g{k} & F[2,30] g{(k + 1) % MANY})" for k in range(MANY)),
    # Seven delay lines: a single state has a million successors.
    "many successors": " & ".join(f"G[0,200] (g{k} -> F[10,25] g{k + 1})" for k in range(GOALS - 1))
    + " & F g0",
    # The search for a loop, in which states are told apart exactly.
    "loops": " & ".join(f"G (g{k} -> F[3,60] g{(k + 1) % 4})" for k in range(4)) + " & G F g0",
}


def long_mission(name: str, size: int = 20) -> dict[str, Any]:
    """A mission file on an empty grid, with cells strewn over it."""
    places = [[row, column] for row in range(size) for column in range(size)]
    random.Random(1).shuffle(places)
    return {
        "mitlplan": 1,
        "workspace": {
            "grid": {
                "rows": size,
                "columns": size,
                "waiting": False,
                "regions": {f"g{k}": [places[k]] for k in range(MANY)},
            }
        },
        "robot": {"start": "r0c0"},
        "spec": HARD[name],
    }
