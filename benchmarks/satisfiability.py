"""SAT and SMT as peers: python-sat and Z3, each on the best encoding we found after trying others.

*Walks* (families a and c): a variable for each moment and each cell that can be reached in exactly so many
moves; whoever is in a cell came from a neighbour, and no two neighbours of one cell at once, which keeps a
single robot a single robot with a few clauses a cell. The requirements become clauses over the moments, and
the horizon grows until the clauses can be satisfied; they are added layer by layer to one solver, what
belongs to one horizon under an assumption of its own.

*Visits* (family b): only the distances between goals matter, and Z3 gets them as difference constraints, the
solver that it has for such. For SAT they are written in the order encoding (Tamura et al. 2009): a variable
"visited by t" for each goal and moment, so that a horizon is nothing but assumptions.

What was tried and was slower stands beside :func:`least_walk` and :func:`visits_by_sat`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, count
from threading import Timer
from time import monotonic
from typing import Any, Protocol, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray

from mitlplan.workspace import Workspace

LIMIT = 10.0
"""Seconds for one answer; the solvers would not notice an alarm."""


class GivenUpError(Exception):
    """A contestant met a limit; the text says which."""


@dataclass(frozen=True, slots=True)
class See:
    """The label is shown at a moment from `first` to `last`, in moves; ``None``: until the end."""

    label: str
    first: int = 0
    last: int | None = None


@dataclass(frozen=True, slots=True)
class NotBefore:
    """The second label is not shown before the first was."""

    first: str
    then: str


@dataclass(frozen=True, slots=True)
class Respond:
    """Whenever the first label is shown, the second is at most `within` moves later, and before the end."""

    asked: str
    answered: str
    within: int


Requirement: TypeAlias = Union[See, NotBefore, Respond]
Clause: TypeAlias = Sequence[int]


class Solver(Protocol):
    """What both solvers offer: clauses of non-zero integers, and answers under assumptions."""

    def add(self, clause: Clause) -> None:
        """Take one clause more."""

    def satisfiable(self, assumptions: Clause) -> bool:
        """Whether all clauses and assumptions can hold at once.

        Raises
        ------
        GivenUpError
            :data:`LIMIT` seconds after the solver was made.
        """


class _Clock:
    """When an answer is due."""

    def __init__(self) -> None:
        self._due = monotonic() + LIMIT

    def left(self) -> float:
        """The seconds left.

        Raises
        ------
        GivenUpError
            If there are none.
        """
        seconds = self._due - monotonic()
        if seconds <= 0:
            raise GivenUpError(f"over {LIMIT:g} s")
        return seconds


class PythonSat:
    """Glucose, by python-sat."""

    def __init__(self) -> None:
        from pysat.solvers import Glucose4

        self._solver = Glucose4()
        self._clock = _Clock()

    def add(self, clause: Clause) -> None:
        """Take one clause more."""
        self._solver.add_clause(clause)

    def satisfiable(self, assumptions: Clause) -> bool:
        """Whether all clauses and assumptions can hold at once; see :class:`Solver`."""
        timer = Timer(self._clock.left(), self._solver.interrupt)
        timer.start()
        try:
            answer = self._solver.solve_limited(assumptions=list(assumptions), expect_interrupt=True)
        finally:
            timer.cancel()
        if answer is None:
            raise GivenUpError(f"over {LIMIT:g} s")
        return bool(answer)


class Z3:
    """Z3 with one of its specialised solvers: for clauses, unless another is named."""

    def __init__(self, logic: str = "QF_FD") -> None:
        import z3

        self.solver = z3.SolverFor(logic)
        self._clock = _Clock()
        self._known: dict[int, Any] = {}

    def _literal(self, number: int) -> Any:
        import z3

        if number not in self._known:
            variable = z3.Bool(f"v{abs(number)}")
            self._known[abs(number)] = variable
            self._known[-abs(number)] = z3.Not(variable)
        return self._known[number]

    def add(self, clause: Clause) -> None:
        """Take one clause more."""
        import z3

        self.solver.add(z3.Or([self._literal(number) for number in clause]))

    def satisfiable(self, assumptions: Clause) -> bool:
        """Whether all clauses and assumptions can hold at once; see :class:`Solver`."""
        import z3

        self.solver.set("timeout", max(1, int(self._clock.left() * 1000)))
        answer = self.solver.check(*map(self._literal, assumptions))
        if answer == z3.unknown:
            raise GivenUpError(f"over {LIMIT:g} s")
        return bool(answer == z3.sat)


@dataclass(eq=False)
class _Layers:
    """Where the robot can be after 0, 1, 2 ... moves, as variables of a solver."""

    workspace: Workspace
    solver: Solver
    layers: list[dict[int, int]]
    numbers: Iterator[int]
    before: list[list[int]]
    apart: list[tuple[int, int]]

    @classmethod
    def of(cls, workspace: Workspace, start: int, solver: Solver) -> _Layers:
        numbers = count(1)
        before: list[list[int]] = [[] for _ in range(workspace.cell_count)]
        after: list[list[int]] = [[] for _ in range(workspace.cell_count)]
        for source, target in zip(workspace.source.tolist(), workspace.target.tolist(), strict=True):
            before[target].append(source)
            after[source].append(target)
        apart = {pair for ways in after for pair in combinations(sorted(ways), 2)}
        first = {start: next(numbers)}
        solver.add([first[start]])
        return cls(workspace, solver, [first], numbers, before, sorted(apart))

    def grow(self) -> None:
        """One move more."""
        last = self.layers[-1]
        layer: dict[int, int] = {}
        for cell, sources in enumerate(self.before):
            come = [last[source] for source in sources if source in last]
            if come:
                layer[cell] = next(self.numbers)
                self.solver.add([-layer[cell], *come])
        for one, other in self.apart:
            if one in layer and other in layer:
                self.solver.add([-layer[one], -layer[other]])
        self.layers.append(layer)

    def showing(self, label: str, first: int, last: int) -> list[int]:
        """The variables of being where a label holds, at the moments from `first` to `last`."""
        return [
            number
            for layer in self.layers[first : last + 1]
            for cell, number in layer.items()
            if label in self.workspace.holds(cell)
        ]


def least_walk(workspace: Workspace, start: int, requirements: Sequence[Requirement], solver: Solver) -> int:
    """The least number of moves of a walk that meets the requirements by its end; there must be one.

    Also tried, on phi1 and phi4 with n = 8: one formula for the largest horizon, with a robot that may stop,
    and a search downwards (2 to 3 times as long on phi1, as long on phi4); CaDiCaL 1.5 and 1.9 and MiniSat
    (about as long), Lingeling, MapleChrono and MergeSat (3 to 8 times); Z3's general solver (1.2 to 3 times
    its finite domains); with Z3, coordinates as integers and steps of length 1 (167 ms for n = 6). A variable
    for each node of the hand-made product would leave the solver nothing to do: who writes down its layers
    has searched it breadth-first.
    """
    layers = _Layers.of(workspace, start, solver)
    while True:
        horizon = len(layers.layers) - 1
        assumption = next(layers.numbers)
        possible = True
        for requirement in requirements:
            for clause in _clauses(layers, requirement, horizon):
                possible = possible and len(clause) > 0
                solver.add([-assumption, *clause])
        if possible and solver.satisfiable([assumption]):
            return horizon
        solver.add([-assumption])
        layers.grow()


def _clauses(layers: _Layers, requirement: Requirement, horizon: int) -> Iterator[list[int]]:
    match requirement:
        case See(label, first, last):
            yield layers.showing(label, first, horizon if last is None else min(last, horizon))
        case NotBefore(first_label, then):
            for moment in range(horizon + 1):
                for early in layers.showing(then, moment, moment):
                    yield [-early, *layers.showing(first_label, 0, moment)]
        case Respond(asked, answered, within):
            for moment in range(horizon + 1):
                answers = layers.showing(answered, moment, min(moment + within, horizon))
                for question in layers.showing(asked, moment, moment):
                    yield [-question, *answers]


# ---------------------------------------------------------------------------- visits: distances matter


def visits_by_sat(distances: NDArray[np.int64], within: int) -> int | None:
    """The shortest walk from the start (row 0) past all goals, if it takes at most `within` moves.

    The walk by cells and moments of :func:`least_walk` takes seconds on these grids where this takes
    milliseconds.
    """
    least = int(distances[0].max(initial=0))
    if least > within:
        return None
    solver = PythonSat()
    goals = distances.shape[1]
    numbers = count(1)
    by = [[next(numbers) for _ in range(within + 1)] for _ in range(goals)]
    for goal in range(goals):
        for moment in range(within):
            solver.add([-by[goal][moment], by[goal][moment + 1]])
        if distances[0, goal] > 0:
            solver.add([-by[goal][int(distances[0, goal]) - 1]])
    for one, other in combinations(range(goals), 2):
        first = next(numbers)
        for early, late, ordered in ((one, other, first), (other, one, -first)):
            way = int(distances[early + 1, late])
            for moment in range(within + 1):
                clause = [-ordered, -by[late][moment]]
                solver.add([*clause, by[early][moment - way]] if moment >= way else clause)

    def possible(horizon: int) -> bool:
        return solver.satisfiable([moments[horizon] for moments in by])

    if not possible(within):
        return None
    most = within
    while least < most:
        middle = (least + most) // 2
        if possible(middle):
            most = middle
        else:
            least = middle + 1
    return most


def visits_by_z3(distances: NDArray[np.int64], within: int) -> int | None:
    """The same with a time for each goal: of two one comes first, and the way between them lies between.

    Z3's difference logic, a smaller bound after each answer; its optimizer takes as long up to 6 goals and
    twice as long at 14.
    """
    import z3

    goals = distances.shape[1]
    times = [z3.Int(f"t{goal}") for goal in range(goals)]
    question = Z3("QF_IDL")
    for goal, time in enumerate(times):
        question.solver.add(time >= int(distances[0, goal]), time <= within)
    for one, other in combinations(range(goals), 2):
        there, back = int(distances[one + 1, other]), int(distances[other + 1, one])
        question.solver.add(z3.Or(times[other] - times[one] >= there, times[one] - times[other] >= back))
    best = None
    while question.satisfiable([]):
        model = question.solver.model()
        best = max(model[time].as_long() for time in times)
        question.solver.add(*(time <= best - 1 for time in times))
    return best
