"""Tours against every loop of small maps, and what is said to recur against signals."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush
from itertools import pairwise

import pytest

from mitlplan.compose import compose
from mitlplan.errors import FormulaError
from mitlplan.logic import formula as f
from mitlplan.logic.core import Core, holds
from mitlplan.logic.interval import Interval
from mitlplan.logic.normalize import normalize
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.search.fastest import Exhausted, Limits, fastest_run
from mitlplan.search.lasso import lassos
from mitlplan.search.tables import tabulate
from mitlplan.tour import PlannedLoop, Visit, recurring, shortest_tour
from mitlplan.workspace import Move, graph, grid
from mitlplan.workspace.workspace import Workspace
from mitlplan_fuzz.missions import SeededChoices, draw_formula

NAMES = ("A", "B", "C")


def core_of(text: str) -> Core:
    return normalize(parse(text), "standard", horizon="infinite")


# --- What recurs -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "visits", "throughout", "from_start"),
    [
        ("F A", [], "true", "true"),
        ("G F A", [("A", None)], "true", "true"),
        ("G F[0,3] A & F[0,5] B", [("A", 3)], "true", "true"),
        ("G (!C & F[0,3] (A & F[1,4] B))", [("A", 3), ("B", 7)], "!C", "!C"),
        ("F G F[1,2] A", [("A", 1)], "true", "true"),
        ("F[0,9] G !C", [], "!C", "true"),
        ("G[4,inf) F[0,1] A", [("A", 1)], "true", "true"),
        ("G (A -> F[0,2] B)", [], "true", "true"),
        ("G F[0,2] G[0,1] A", [("A", 2)], "true", "true"),
        ("G (A U[0,2] B)", [("B", 2)], "A | B", "A | B"),
        ("A & G F (A | B)", [("A | B", None)], "true", "true"),
    ],
)
def test_what_recurs(
    text: str, visits: list[tuple[str, int | None]], throughout: str, from_start: str
) -> None:
    shown = recurring(core_of(text))
    expected = [Visit(core_of(label), None if time is None else Fraction(time)) for label, time in visits]
    assert sorted(shown.visits, key=repr) == sorted(expected, key=repr)
    assert (shown.throughout, shown.from_start) == (core_of(throughout), core_of(from_start))


def random_signal(choices: random.Random) -> Signal:
    lengths = [choices.randint(1, 3) for _ in range(choices.randint(1, 5))]
    starts = [Fraction(sum(lengths[:index])) for index in range(len(lengths) + 1)]
    segments = tuple(
        Segment(start, frozenset(name for name in NAMES if choices.random() < 0.6)) for start in starts[:-1]
    )
    return Signal(segments, starts[-1], choices.choice(starts[:-1]))


def recurring_formula(choices: random.Random) -> f.Formula:
    """A formula of the kind that says what recurs."""
    parts: list[f.Formula] = []
    for _ in range(choices.randint(1, 2)):
        inner = draw_formula(SeededChoices(choices), NAMES, depth=2)
        wait = Interval(Fraction(0), choices.choice([None, Fraction(2), Fraction(4)]))
        shape = choices.randrange(4)
        parts.append(
            f.Always(f.Eventually(inner, wait))
            if shape == 0
            else f.Always(f.And((f.Atom("A"), f.Eventually(f.And((f.Atom("B"), inner)), wait))))
            if shape == 1
            else f.Eventually(f.Always(inner))
            if shape == 2
            else f.Always(f.Until(f.Atom("A"), inner, wait))
        )
    return f.And(tuple(parts)) if len(parts) > 1 else parts[0]


@pytest.mark.parametrize("first", range(0, 2000, 1000))
def test_what_is_said_to_recur_does(first: int) -> None:
    satisfied = said = 0
    for seed in range(first, first + 1000):
        choices = random.Random(seed)
        try:
            formula = recurring_formula(choices)
            core = normalize(formula, "standard", horizon="infinite")
        except FormulaError:
            continue
        for _ in range(4):
            signal = random_signal(choices)
            if not satisfies(formula, signal):
                continue
            satisfied += 1
            shown = recurring(core)
            said += bool(shown.visits)
            assert not signal_fault(shown.visits, shown.throughout, shown.from_start, signal), f"seed {seed}"
    assert min(satisfied, said) > 100, (satisfied, said)


def signal_fault(visits: Sequence[Visit], throughout: Core, from_start: Core, signal: Signal) -> str | None:
    assert signal.repeat_from is not None
    period = signal.end - signal.repeat_from
    again = [segment for segment in signal.segments if segment.start >= signal.repeat_from]
    if not all(holds(throughout, segment.holds) for segment in again):
        return "throughout"
    if not all(holds(from_start, segment.holds) for segment in signal.segments):
        return "from the start"
    ends = [*(segment.start for segment in again[1:]), signal.end]
    for visit in visits:
        times = [
            (segment.start, end)
            for segment, end in zip(again, ends, strict=True)
            if holds(visit.label, segment.holds)
        ]
        if not times:
            return f"{visit} is not made"
        times.append((times[0][0] + period, times[0][1] + period))
        away = max(after - left for (_, left), (after, _) in pairwise(times))
        if visit.within is not None and away > visit.within:
            return f"{visit} is away for {away}"
    return None


# --- Shortest tours ----------------------------------------------------------------------------------------


def random_workspace(choices: random.Random) -> Workspace:
    names = [f"c{number}" for number in range(choices.randint(2, 7))]
    unit = choices.random() < 0.4
    moves = []
    for name in names:
        for other in choices.sample(names, choices.randint(1, min(3, len(names)))):
            least = Fraction(1 if unit else choices.randint(1, 5), choices.choice([1, 1, 2]))
            moves.append(Move(name, other, [least, least + choices.choice([0, 0, 1])]))
    labels = {name: [label for label in NAMES if choices.random() < 0.3] for name in names}
    return graph(labels, moves, waiting=choices.random() < 0.5)


@dataclass(frozen=True)
class World:
    """A workspace as a dictionary of moves."""

    moves: dict[int, dict[int, Fraction]]

    @classmethod
    def of(cls, workspace: Workspace, allowed: Core) -> World:
        moves: dict[int, dict[int, Fraction]] = {cell: {} for cell in range(workspace.cell_count)}
        for move in range(workspace.move_count):
            origin, target = int(workspace.source[move]), int(workspace.target[move])
            if holds(allowed, workspace.holds(origin)) and holds(allowed, workspace.holds(target)):
                time = workspace.least_time(move)
                moves[origin][target] = min(time, moves[origin].get(target, time))
        return cls(moves)

    def least(self, start: int, goal: int, wanted: Sequence[frozenset[int]], moved: bool) -> Fraction | None:
        """The least time of a walk to `goal` through all sets of cells, with a move at least if asked."""

        def met(cell: int) -> frozenset[int]:
            return frozenset(number for number, cells in enumerate(wanted) if cell in cells)

        queue: list[tuple[Fraction, int, bool, list[int]]] = [
            (Fraction(0), start, not moved, sorted(met(start)))
        ]
        done = set()
        while queue:
            time, cell, free, seen = heappop(queue)
            if cell == goal and free and len(seen) == len(wanted):
                return time
            if (cell, free, tuple(seen)) in done:
                continue
            done.add((cell, free, tuple(seen)))
            for target, duration in self.moves[cell].items():
                heappush(queue, (time + duration, target, True, sorted({*seen, *met(target)})))
        return None


def least_loop(workspace: Workspace, start: int, labels: Sequence[Core], allowed: Core) -> Fraction | None:
    """The least makespan of a loop whose round shows all labels, entered in every cell in turn."""
    world = World.of(workspace, allowed)
    cells = range(workspace.cell_count)
    wanted = [frozenset(cell for cell in cells if holds(label, workspace.holds(cell))) for label in labels]
    found = []
    for entry in cells:
        to = world.least(start, entry, (), moved=False)
        around = world.least(entry, entry, wanted, moved=True)
        if to is not None and around is not None:
            found.append(to + around)
    return min(found, default=None)


def loop_fault(workspace: Workspace, start: int, labels: Sequence[Core], loop: PlannedLoop) -> str | None:
    prefix, cycle = loop
    stays = [*prefix, *cycle, cycle[0]]
    if stays[0][0] != start:
        return "it does not begin at the start"
    world = World.of(workspace, core_of("true"))
    for (cell, duration), (after, _) in pairwise(stays):
        if world.moves[cell].get(after) != duration:
            return f"no move from {cell} to {after} in {duration}"
    if not all(any(holds(label, workspace.holds(cell)) for cell, _ in cycle) for label in labels):
        return "a label is not shown"
    return None


MISSIONS = [
    ("G F A", ["A"], "true"),
    ("G F A & G F B", ["A", "B"], "true"),
    ("G F A & G F B & G F C", ["A", "B", "C"], "true"),
    ("G F (A & !B) & G F (B | C)", ["A & !B", "B | C"], "true"),
    ("G F A & G F B & G !C", ["A", "B"], "!C"),
]


@pytest.mark.parametrize("first", range(0, 200, 100))
@pytest.mark.parametrize(("text", "labels", "allowed"), MISSIONS)
def test_the_shortest_tour_is_the_least_of_all_loops(
    text: str, labels: list[str], allowed: str, first: int
) -> None:
    cores = [core_of(label) for label in labels]
    with_prefix = 0
    for seed in range(first, first + 100):
        choices = random.Random(seed)
        workspace = random_workspace(choices)
        start = choices.randrange(workspace.cell_count)
        expected = least_loop(workspace, start, cores, core_of(allowed))
        tour = shortest_tour(workspace, (start,), core_of(text), Limits())
        assert tour.possible == (expected is not None), f"seed {seed}"
        if expected is None:
            continue
        assert tour.bound == expected, f"seed {seed}"
        prefix, cycle = tour.loops[0]
        assert sum(duration for _, duration in (*prefix, *cycle)) == expected
        assert all(loop_fault(workspace, start, cores, loop) is None for loop in tour.loops), f"seed {seed}"
        with_prefix += bool(prefix)
    assert with_prefix > 3


@pytest.mark.parametrize("first", range(0, 300, 100))
def test_a_proof_that_there_is_no_loop_holds(first: int) -> None:
    """Where the deadlines alone rule out every loop, the zone graph has none, and the robot cannot park."""
    proofs = loops = 0
    for seed in range(first, first + 100):
        choices = random.Random(seed)
        workspace = random_workspace(choices)
        start = choices.randrange(workspace.cell_count)
        bounds = [choices.randint(1, 6) for _ in NAMES[: choices.randint(2, 3)]]
        core = core_of(
            " & ".join(f"G F[0,{bound}] {name}" for name, bound in zip(NAMES, bounds, strict=False))
        )
        tour = shortest_tour(workspace, (start,), core, Limits())
        if tour.possible:
            loops += 1
            continue
        proofs += 1
        network = compose(workspace, (start,), core)
        parked = fastest_run(tabulate(network), Limits(), parkings=True)
        assert isinstance(parked, Exhausted), f"seed {seed}"
        assert isinstance(lassos(tabulate(network, objective=False), Limits()), Exhausted), f"seed {seed}"
    assert min(proofs, loops) > 5


def test_a_round_just_quick_enough_is_no_proof() -> None:
    """Between leaving A and coming back lie 2 * 9 moves less the one stay in A."""
    hall = grid(1, 10, regions={"A": [(0, 0)], "B": [(0, 9)]})

    def patrol(bound: str) -> Core:
        return core_of(f"G F[0,{bound}] A & G F[0,{bound}] B")

    assert shortest_tour(hall, (0,), patrol("17"), Limits()).possible
    assert not shortest_tour(hall, (0,), patrol("33/2"), Limits()).possible


def test_labels_in_many_cells_have_no_tour() -> None:
    hall = grid(4, 4, regions={"A": [(row, column) for row in range(4) for column in range(3)]})
    tour = shortest_tour(hall, (0,), core_of("G F A"), Limits())
    assert (tour.bound, tour.loops, tour.possible) == (0, (), True)
