"""Measures the planner beside its peers and writes docs/performance.md.

    python -m benchmarks.performance [--family NAME]... [--limit SECONDS] [--output FILE]

Process start, imports and the reading of mission files are not counted; everything from the mission in memory
to the checked plan is.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.contest import OURS, Row, WrongAnswerError, hold, ratio_in_turns
from benchmarks.families import (
    EXAMPLES,
    ROOT,
    Instance,
    examples,
    goals,
    large,
    paper,
    responses,
    slow_warehouse,
    terrain_of,
)
from benchmarks.memory import measured
from benchmarks.networks import networks, networks_part, races, two_at_once
from benchmarks.report import Section, ratio, write
from mitlplan.mission import read
from mitlplan.plan import Plan
from mitlplan.planner import plan

SIZES = (2, 4, 8, 16, 32, 64, 128, 256, 512)
EVERY_SIZE = range(2, 65)


def example_missions() -> Iterator[Instance]:
    """The missions of ``examples``."""
    yield from examples()


def paper_grids() -> Iterator[Instance]:
    """The paper's formulas, n = 2 to 512."""
    for name in ("phi1", "phi3", "phi4", "phi4, peers count", "phi2"):
        for size in SIZES:
            yield paper(name, size)


def many_goals() -> Iterator[Instance]:
    """2 to 14 goals by a deadline."""
    import numpy as np

    maps = {"16 x 16": np.ones((16, 16), dtype=np.uint8)}
    for name in ("random-32-32-20", "warehouse-10-20-10-2-1"):
        maps[name] = terrain_of(name)
    for name, terrain in maps.items():
        for feasible in (True, False):
            for count in range(2, 15, 2):
                yield goals(terrain, name, count, feasible=feasible)


def bounded_responses() -> Iterator[Instance]:
    """1 to 3 bounded responses on grids of 8 to 64."""
    for count in (1, 2, 3):
        for size in (8, 16, 32, 64):
            yield responses(count, size)


def large_maps() -> Iterator[Instance]:
    """Maps of 512 x 512 and more."""
    yield large("Berlin_1_256", 1)
    yield large("Berlin_1_256", 2)
    yield large("empty", 1, size=512)
    yield large("32room_000", 1)
    yield large("32room_000", 2)


FAMILIES: dict[str, tuple[str, Callable[[], Iterator[Instance]]]] = {
    "examples": ("Examples", example_missions),
    "paper": ("The paper's formulas on n x n grids", paper_grids),
    "goals": ("k goals by one deadline", many_goals),
    "responses": ("k bounded responses", bounded_responses),
    "large": ("Large maps", large_maps),
}

NETWORKS = "networks"
"""The family that has no missions."""


def main(arguments: list[str]) -> None:
    """Measures, and writes the page."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.performance", description="Measure the planner."
    )
    parser.add_argument(
        "--family", action="append", choices=[*FAMILIES, NETWORKS], help="only this one; may be repeated"
    )
    parser.add_argument("--limit", type=float, default=30.0, help="seconds for one contestant and instance")
    parser.add_argument("--rounds", type=int, default=15, help="runs at most; the median counts")
    parser.add_argument(
        "--budget", type=float, default=2.0, help="seconds after which no further round begins"
    )
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "performance.md")
    chosen = parser.parse_args(arguments)
    load = os.getloadavg()
    # Imports and caches are filled by a mission that nobody counts.
    hold(paper("phi4", 3), limit=30, rounds=2, budget=10, absent={})
    sections = []
    families = chosen.family or [*FAMILIES, NETWORKS]
    for family in families:
        if family == NETWORKS:
            continue
        title, instances = FAMILIES[family]
        rows = list(contests(instances(), chosen.limit, chosen.rounds, chosen.budget))
        sections.append(Section(family, title, rows))
    command = " ".join(["python -m benchmarks.performance", *arguments])
    facts = {}
    if "paper" in families:
        facts["shown"] = str(least_makespans())
    if "examples" in families:
        plain = read(EXAMPLES / "warehouse.yaml")
        facts["slower"] = ratio(ratio_in_turns(slow_warehouse().mission, plain, rounds=2 * chosen.rounds))
    memory = [] if chosen.family else list(measured())
    parts = []
    if NETWORKS in families:
        rows = list(races(networks(), rounds=chosen.rounds, budget=chosen.budget))
        parts.append(networks_part(rows, two_at_once()))
    write(
        chosen.output,
        sections,
        command=command,
        rounds=chosen.rounds,
        load=load,
        facts=facts,
        memory=memory,
        parts=parts,
    )
    print(f"written: {chosen.output}")


def contests(instances: Iterator[Instance], limit: float, rounds: int, budget: float) -> Iterator[Row]:
    """The rows of a table; a contestant that gave up on one instance is not tried on larger ones."""
    absent: dict[tuple[str, str], str] = {}
    for instance in instances:
        missing = {name: why for (family, name), why in absent.items() if family == instance.name}
        row = hold(instance, limit=limit, rounds=rounds, budget=budget, absent=missing)
        for name, times in row.times.items():
            if times.given_up is not None and name not in missing:
                absent[instance.name, name] = "not tried: " + times.given_up
        ours = row.ours
        seconds = f"{ours.total:.4f} s" if ours.given_up is None else ours.given_up
        print(f"{instance.name} {instance.size}: {row.answer}, {seconds}", flush=True)
        yield row


def least_makespans() -> int:
    """Plans phi1, phi3 and phi4 for every n from 2 to 64: 3 (n-1); how many missions that was.

    Raises
    ------
    WrongAnswerError
        If one takes another time.
    """
    count = 0
    for size in EVERY_SIZE:
        for name in ("phi1", "phi3", "phi4"):
            instance = paper(name, size)
            outcome = plan(instance.mission)
            if not isinstance(outcome, Plan) or outcome.makespan != 3 * (size - 1):
                raise WrongAnswerError(f"{name} with n = {size}: {OURS} says {outcome}")
            count += 1
    return count


if __name__ == "__main__":
    main(sys.argv[1:])
