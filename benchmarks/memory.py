"""How much memory a plan takes: each mission in a process of its own, whose peak the system keeps.

python -m benchmarks.memory MISSION
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from benchmarks.families import ROOT, Instance, goals, large, paper, responses, terrain_of
from benchmarks.satisfiability import GivenUpError
from mitlplan.compose import compose, core_of
from mitlplan.planner import plan
from mitlplan.search.fastest import Limits, Stopped, fastest_run
from mitlplan.search.tables import tabulate

MISSIONS: dict[str, Callable[[], Instance]] = {
    "phi1, n = 64": lambda: paper("phi1", 64),
    "phi1, n = 512": lambda: paper("phi1", 512),
    "phi4, n = 512": lambda: paper("phi4", 512),
    "phi2, n = 512": lambda: paper("phi2", 512),
    "14 goals, warehouse-10-20-10-2-1": lambda: goals(
        terrain_of("warehouse-10-20-10-2-1"), "warehouse-10-20-10-2-1", 14, feasible=True
    ),
    "14 goals, 16 x 16, infeasible": lambda: goals(
        np.ones((16, 16), dtype=np.uint8), "16 x 16", 14, feasible=False
    ),
    "3 responses, n = 64": lambda: responses(3, 64),
    "large, Berlin_1_256, 512 x 512": lambda: large("Berlin_1_256", 2),
    "large, empty, 512 x 512": lambda: large("empty", 1, size=512),
    "large, 32room_000, 512 x 512": lambda: large("32room_000", 1),
    "large, 32room_000, 1024 x 1024": lambda: large("32room_000", 2),
}


@dataclass(frozen=True, slots=True)
class Memory:
    """What was measured of one mission; all in bytes.

    Parameters
    ----------
    before, peak
        The most that the process held before the plan was asked for, with the map in memory, and after.
    states, stored
        How many states the search for the plan stores, and in how much; 0 where only loops are sought.
    """

    before: int
    peak: int
    states: int
    stored: int


def measured() -> Iterator[tuple[str, Memory]]:
    """All missions, one after the other."""
    for name in MISSIONS:
        yield name, Memory(**json.loads(said([sys.executable, "-m", "benchmarks.memory", name])))


_OVER = 124
"""What ``timeout`` answers when it has stopped a command."""


def said(command: Sequence[str], *, limit: float = 600) -> str:
    """What a program prints, run so that its peak of memory is its own.

    The system counts what a process held before it became another program, hence a program between the two.

    Raises
    ------
    GivenUpError
        If it takes more than `limit` seconds.
    """
    done = subprocess.run(  # noqa: S603 (our own program, or whichever peer the user has)
        ["timeout", f"{limit:g}", *command],  # noqa: S607
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode == _OVER:
        raise GivenUpError(f"over {limit:g} s")
    done.check_returncode()
    return done.stdout


def peak() -> int:
    """The most that this process has held, in bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _of(instance: Instance) -> Memory:
    mission = instance.mission
    before = peak()
    plan(mission)
    after = peak()
    if instance.name == "phi2":
        return Memory(before, after, 0, 0)
    # The same search once more, for what it says of itself.
    network = compose(mission.workspace, (mission.start,), core_of(mission), horizon=mission.horizon)
    found = fastest_run(tabulate(network), Limits().begin(), parkings=False)
    assert not isinstance(found, Stopped), "there was no limit"
    return Memory(before, after, found.states, found.bytes)


if __name__ == "__main__":
    print(json.dumps(asdict(_of(MISSIONS[sys.argv[1]]()))))
