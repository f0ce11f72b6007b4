"""Compressed maps against the maps themselves: the same answers, and plans that the judge passes."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice

import pytest

from mitlplan.check import check
from mitlplan.compose import compose
from mitlplan.endless import _expanded, _round_of
from mitlplan.logic.core import Core
from mitlplan.logic.normalize import normalize
from mitlplan.mission import Mission, Requirement
from mitlplan.plan import Loop, Plan, Step
from mitlplan.search.fastest import Exhausted, Found, Limits, Stopped, fastest_run
from mitlplan.search.lasso import Lasso, lassos, timetable
from mitlplan.search.schedule import STANDS_STILL, schedule
from mitlplan.search.tables import Tables, tabulate
from mitlplan.workspace import Move, graph, grid
from mitlplan.workspace.compress import Compressed, PlannedStay, compress, look_alike
from mitlplan.workspace.workspace import Workspace
from mitlplan_fuzz.missions import SeededChoices, draw_formula, text_of

EPSILON = Fraction(1, 1000)
LIMITS = Limits(megabytes=4)
"""Loops of the larger maps are not always sought to the end."""


@dataclass(frozen=True)
class Case:
    """A mission on a map that can be compressed, and on the small map."""

    mission: Mission
    core: Core
    small: Compressed

    def tables(self, *, objective: bool = True) -> tuple[Tables, Tables]:
        """Of the large and of the small map."""
        horizon = self.mission.horizon
        large = compose(self.mission.workspace, (self.mission.start,), self.core, horizon=horizon)
        small = compose(self.small.workspace, self.small.starts, self.core, horizon=horizon)
        return tabulate(large, objective=objective), tabulate(small, objective=objective)

    def fault(self, stays: list[PlannedStay], makespan: Fraction, loop: Loop | None) -> str | None:
        """What the independent check finds wrong with a plan."""
        workspace = self.mission.workspace
        now = Fraction(0)
        steps = []
        for cell, duration in stays:
            holds = tuple(sorted(workspace.holds(cell)))
            steps.append(Step(workspace.names[cell], now, now + duration, holds))
            now += duration
        if loop is not None and loop.period is None:
            steps[-1] = replace(steps[-1], leave=None)
        return check(
            self.mission, Plan(tuple(steps), makespan, loop, attained=now == makespan, epsilon=EPSILON)
        )


def random_workspace(choices: random.Random) -> Workspace:
    """A small world in which the robot may wait and every move takes as long."""
    time = choices.choice([1, 1, 2, Fraction(1, 2)])
    if choices.random() < 0.5:
        rows, columns = choices.randint(1, 3), choices.randint(3, 4)
        cells = [(row, column) for row in range(rows) for column in range(columns)]
        regions = {name: choices.sample(cells, choices.randint(1, 2)) for name in "AB"}
        taken = {cell for cells in regions.values() for cell in cells}
        blocked = [cell for cell in cells if cell not in taken and choices.random() < 0.1]
        return grid(rows, columns, move_time=time, waiting=True, blocked=blocked, regions=regions)
    names = [f"c{number}" for number in range(choices.randint(3, 8))]
    labels = [choices.choice([[], [], [], ["A"], ["B"], ["A", "B"]]) for _ in names]
    moves = [
        Move(name, other, time)
        for name in names
        for other in choices.sample(names, choices.randint(0, min(3, len(names))))
    ]
    return graph(dict(zip(names, labels, strict=True)), moves or [Move("c0", "c1", time)], waiting=True)


def random_case(seed: int) -> Case | None:
    """The case of that number, ``None`` if its map does not become smaller."""
    choices = random.Random(seed)
    workspace = random_workspace(choices)
    start = choices.randrange(workspace.cell_count)
    formula = draw_formula(SeededChoices(choices), ("A", "B"), depth=3)
    horizon = choices.choice(["infinite", "infinite", "finite"])
    core = normalize(formula, "standard", horizon=horizon)
    predicates = compose(workspace, (start,), core, horizon=horizon).predicates
    small = compress(workspace, look_alike(workspace, predicates.values()), (start,))
    spec = (Requirement("spec", text_of(formula), formula),)
    mission = Mission(workspace=workspace, start=start, spec=spec, horizon=horizon)
    return None if small is None else Case(mission, core, small)


def cases(first: int, count: int) -> Iterator[tuple[int, Case]]:
    for seed in range(first, first + count):
        case = random_case(seed)
        if case is not None:
            yield seed, case


def answer(result: object) -> tuple[object, ...]:
    assert not isinstance(result, Stopped)
    return (type(result), *((result.time, result.attained) if isinstance(result, Found) else ()))


@pytest.mark.parametrize("first", range(0, 300, 150))
def test_finite_and_parking_plans_are_the_same(first: int) -> None:
    found = 0
    for seed, case in cases(first, 150):
        large, small = case.tables()
        for endings, parkings in ((True, False), (False, True), (True, True)):
            if case.mission.horizon == "finite" and parkings:
                continue
            of_large = fastest_run(large, Limits(), endings=endings, parkings=parkings)
            of_small = fastest_run(small, Limits(), endings=endings, parkings=parkings)
            assert answer(of_large) == answer(of_small), f"seed {seed}"
            if isinstance(of_small, Found):
                found += 1
                assert plan_fault(case, small, of_small) is None, f"seed {seed}"
    assert found > 50


def plan_fault(case: Case, tables: Tables, found: Found) -> str | None:
    """What is wrong with the plan of the small map on the large one."""
    moves = [step for step, row in enumerate(found.path.steps) if row[0] != STANDS_STILL]
    times = schedule(tables, found.path, EPSILON, []).times
    cells = tables.arrays["move_target"][found.path.steps[moves, 0]].tolist()
    ends = [*(times[step] for step in moves[1:]), times[-1]]
    stays = [(cell, end - times[step]) for cell, step, end in zip(cells, moves, ends, strict=True)]
    expanded = case.small.expand(stays)
    parks = found.path.last == "parking"
    return case.fault(expanded, found.time, Loop(len(expanded) - 1, None) if parks else None)


@pytest.mark.parametrize("first", range(10_000, 10_300, 150))
def test_loops_are_the_same(first: int) -> None:
    counts = {True: 0, False: 0}
    for seed, case in cases(first, 150):
        if case.mission.horizon == "finite":
            continue
        parks = isinstance(fastest_run(case.tables()[1], Limits()), Found)
        large, small = case.tables(objective=False)
        of_large, of_small = lassos(large, LIMITS), lassos(small, LIMITS)
        if isinstance(of_large, Stopped) or isinstance(of_small, Stopped):
            continue
        there_are = not isinstance(of_large, Exhausted)
        # A loop through plain cells alone is missing on the small map, but then the robot may as well park.
        if there_are == isinstance(of_small, Exhausted):
            assert there_are
            assert parks, f"seed {seed}"
        if not isinstance(of_small, Exhausted):
            counts[True] += 1
            faults = [loop_fault(case, small, lasso) for lasso in islice(of_small, 5)]
            assert not any(faults), f"seed {seed}: {faults}"
        counts[False] += not there_are
    assert min(counts.values()) > 3, counts


def loop_fault(case: Case, tables: Tables, lasso: Lasso) -> str | None:
    """What is wrong with a loop of the small map on the large one."""
    times = timetable(tables, lasso, EPSILON)
    if times is None:
        return None
    loop = _expanded(case.small, _round_of(tables, lasso, times))
    prefix, cycle = ([(stay.cell, stay.duration) for stay in stays] for stays in (loop.prefix, loop.cycle))
    period = sum((duration for _, duration in cycle), Fraction(0))
    return case.fault([*prefix, *cycle], loop.makespan, Loop(len(prefix), period))
