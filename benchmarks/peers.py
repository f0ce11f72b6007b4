"""The peers: other ways to the same answers, each on the best encoding we know.

On a hand-made product: Dijkstra's algorithm of scipy and of rustworkx, and, since a move is always 1 there,
scipy's breadth-first search, which is the faster tool for that. For missions that only visit goals, the
distances between the goals say everything: dynamic programming over the sets of visited goals (Held, Karp
1962), and a walk through them for OR-tools CP-SAT, HiGHS, python-sat and Z3. The last two also seek the walk
itself, cell by cell, where the distances do not say everything. A peer prepares and then solves; the two
are timed apart, because a product could be kept from mission to mission. What is not installed is left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from importlib.util import find_spec
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from benchmarks.product import Product, TooLargeError
from benchmarks.satisfiability import (
    Z3,
    PythonSat,
    Requirement,
    Solver,
    least_walk,
    visits_by_sat,
    visits_by_z3,
)
from mitlplan.workspace import Workspace

Answer: TypeAlias = "Fraction | None"
"""The least makespan in seconds, or that there is no plan."""

Solve: TypeAlias = Callable[[], Answer]

MOST_RUSTWORKX_EDGES = 6_000_000
"""rustworkx keeps an object for each node and is filled from Python lists."""

MOST_RUSTWORKX_PATHS = 20_000
"""Nodes up to which rustworkx is asked for paths; beyond, its lengths alone are several times quicker."""


@dataclass(frozen=True, slots=True)
class Peer:
    """Another way to the answer.

    Parameters
    ----------
    name
        As the table shows it.
    prepare
        Builds what is searched and returns the search.
    """

    name: str
    prepare: Callable[[], Solve]


UNREACHED = 1 << 40
"""More moves than any walk has."""

MakeProduct: TypeAlias = Callable[[], Product]


def on_product(make: MakeProduct) -> tuple[Peer, ...]:
    """The searches for shortest paths on a hand-made product."""
    peers = [
        Peer("scipy Dijkstra", lambda: _scipy_dijkstra(make())),
        Peer("scipy breadth-first", lambda: _scipy_breadth_first(make())),
    ]
    if find_spec("rustworkx") is not None:
        peers.append(Peer("rustworkx Dijkstra", lambda: _rustworkx_dijkstra(make())))
    return tuple(peers)


def _back(predecessors: NDArray[np.int32], start: int, node: int) -> NDArray[np.int64]:
    path = [node]
    while path[-1] != start:
        path.append(int(predecessors[path[-1]]))
    return np.array(path[::-1])


def _answer(product: Product, path: NDArray[np.int64]) -> Answer:
    moves = product.finish(len(path) - 1, lambda: path)
    return None if moves is None else moves * product.tick


def _scipy_dijkstra(product: Product) -> Solve:
    def solve() -> Answer:
        if product.start is None or len(product.goals) == 0:
            return None
        lengths, before = dijkstra(product.graph, indices=[product.start], return_predecessors=True)
        goal = int(product.goals[np.argmin(lengths[0, product.goals])])
        if not np.isfinite(lengths[0, goal]):
            return None
        return _answer(product, _back(before[0], product.start, goal))

    return solve


def _scipy_breadth_first(product: Product) -> Solve:
    def solve() -> Answer:
        if product.start is None or len(product.goals) == 0:
            return None
        order, predecessors = breadth_first_order(product.graph, product.start)
        reached = np.flatnonzero((order >= product.goals[0]) & (order <= product.goals[-1]))
        if len(reached) == 0:
            return None
        return _answer(product, _back(predecessors, product.start, int(order[reached[0]])))

    return solve


def _rustworkx_dijkstra(product: Product) -> Solve:
    import rustworkx

    if product.graph.nnz > MOST_RUSTWORKX_EDGES:
        raise TooLargeError
    entries = product.graph.tocoo()
    # With a single target rustworkx stops there: every goal leads to one node more.
    sink = product.nodes
    graph = rustworkx.PyDiGraph()
    graph.add_nodes_from(range(sink + 1))
    graph.add_edges_from_no_data(list(zip(entries.row.tolist(), entries.col.tolist(), strict=True)))
    graph.add_edges_from_no_data([(goal, sink) for goal in product.goals.tolist()])
    start = product.start

    def path() -> NDArray[np.int64]:
        assert start is not None
        found = rustworkx.digraph_dijkstra_shortest_paths(graph, start, sink, default_weight=1.0)
        return np.array(found[sink][:-1] if sink in found else [], dtype=np.int64)

    def solve() -> Answer:
        if start is None:
            return None
        if product.nodes <= MOST_RUSTWORKX_PATHS:
            nodes = path()
            return _answer(product, nodes) if len(nodes) > 0 else None
        lengths = rustworkx.dijkstra_shortest_path_lengths(graph, start, lambda _: 1.0, goal=sink)
        if sink not in lengths:
            return None
        moves = product.finish(round(lengths[sink]) - 1, path)
        return None if moves is None else moves * product.tick

    return solve


# --------------------------------------------------------------- visiting goals: only distances matter


@dataclass(frozen=True, eq=False)
class Visits:
    """A mission that visits every goal, each a single cell, by a time that all share.

    Parameters
    ----------
    start, goals
        Cells.
    within
        Moves.
    """

    workspace: Workspace
    start: int
    goals: tuple[int, ...]
    within: int

    def distances(self) -> NDArray[np.int64]:
        """Moves from the start (row 0) and from each goal to each goal."""
        workspace = self.workspace
        moves = workspace.source, workspace.target
        graph = csr_array((np.ones(workspace.move_count), moves), shape=(workspace.cell_count,) * 2)
        far = dijkstra(graph, indices=[self.start, *self.goals], unweighted=True)[:, list(self.goals)]
        return np.where(np.isfinite(far), far, UNREACHED).astype(np.int64)

    def answer(self, moves: int | None) -> Answer:
        """The makespan, if it is in time."""
        if moves is None or moves > self.within:
            return None
        return moves * self.workspace.least_time(0)


def on_distances(visits: Visits) -> tuple[Peer, ...]:
    """The peers that need only the distances between the goals; these are computed while the clock runs."""
    peers = [
        Peer("subset DP", lambda: lambda: visits.answer(subset_programming(visits.distances()))),
        Peer("HiGHS", lambda: lambda: visits.answer(_highs(visits.distances(), visits.within))),
    ]
    if find_spec("ortools") is not None:
        peers.append(
            Peer("CP-SAT", lambda: lambda: visits.answer(_cp_sat(visits.distances(), visits.within)))
        )
    if find_spec("pysat") is not None:
        peers.append(
            Peer(
                "python-sat", lambda: lambda: visits.answer(visits_by_sat(visits.distances(), visits.within))
            )
        )
    if find_spec("z3") is not None:
        peers.append(
            Peer("Z3", lambda: lambda: visits.answer(visits_by_z3(visits.distances(), visits.within)))
        )
    return tuple(peers)


def on_walks(workspace: Workspace, start: int, *requirements: Requirement) -> tuple[Peer, ...]:
    """The peers that seek the walk itself, cell by cell; all moves take equally long, and there is a walk."""

    def peer(name: str, make: Callable[[], Solver]) -> Peer:
        def solve() -> Answer:
            return least_walk(workspace, start, requirements, make()) * workspace.least_time(0)

        return Peer(name, lambda: solve)

    peers = []
    if find_spec("pysat") is not None:
        peers.append(peer("python-sat", PythonSat))
    if find_spec("z3") is not None:
        peers.append(peer("Z3", Z3))
    return tuple(peers)


def subset_programming(distances: NDArray[np.int64]) -> int:
    """The shortest walk from the start past every goal: best[set, last], sets in order of their size.

    Examples
    --------
    >>> subset_programming(np.array([[1, 5], [0, 2], [2, 0]]))
    3
    """
    count = distances.shape[1]
    sets = np.arange(1 << count)
    size = np.array([number.bit_count() for number in sets.tolist()])
    best = np.full((len(sets), count), UNREACHED, dtype=np.int64)
    for last in range(count):
        best[1 << last, last] = distances[0, last]
    for level in range(2, count + 1):
        of_level = sets[size == level]
        for last in range(count):
            chosen = of_level[of_level >> last & 1 == 1]
            before = best[chosen ^ (1 << last)] + distances[1:, last]
            best[chosen, last] = before.min(axis=1)
    return int(best[-1].min())


def _cp_sat(distances: NDArray[np.int64], within: int) -> int | None:
    """A circuit through the start (0) and the goals, the arcs back to the start free of charge."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    count = distances.shape[1]
    arcs, cost = [], []
    for source in range(count + 1):
        for target in range(count + 1):
            if source == target:
                continue
            taken = model.new_bool_var("")
            arcs.append((source, target, taken))
            if target > 0:
                cost.append(int(distances[source, target - 1]) * taken)
    model.add_circuit(arcs)
    model.add(sum(cost) <= within)
    model.minimize(sum(cost))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    status = solver.solve(model)
    if status == cp_model.INFEASIBLE:
        return None
    if status != cp_model.OPTIMAL:
        raise RuntimeError(f"CP-SAT says {solver.status_name(status)}")
    return round(solver.objective_value)


def _highs(distances: NDArray[np.int64], within: int) -> int | None:
    """The same walk as a mixed integer program: a unit of flow is left at each goal (Gavish, Graves 1978)."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    count = distances.shape[1]
    arcs = [(s, t) for s in range(count + 1) for t in range(1, count + 1) if s != t]
    number = len(arcs)
    cost = np.array([distances[s, t - 1] for s, t in arcs], dtype=float)
    # Columns: which arcs are taken, then the flow on each.
    rows: list[tuple[NDArray[np.float64], float, float]] = []

    def row(least: float, most: float) -> NDArray[np.float64]:
        coefficients = np.zeros(2 * number)
        rows.append((coefficients, least, most))
        return coefficients

    into = [row(1, 1) for _ in range(count)]
    out = [row(1, 1), *(row(0, 1) for _ in range(count))]
    kept = [row(1, 1) for _ in range(count)]
    for index, (s, t) in enumerate(arcs):
        into[t - 1][index] = 1
        out[s][index] = 1
        kept[t - 1][number + index] = 1
        if s > 0:
            kept[s - 1][number + index] = -1
        limited = row(-np.inf, 0)
        limited[number + index], limited[index] = 1, -(count if s == 0 else count - 1)
    row(-np.inf, within)[:number] = cost
    matrix, least, most = (np.array(part) for part in zip(*rows, strict=True))
    solved = milp(
        np.append(cost, np.zeros(number)),
        integrality=np.append(np.ones(number), np.zeros(number)),
        bounds=Bounds(0, np.append(np.ones(number), np.full(number, count))),
        constraints=LinearConstraint(matrix, least, most),
    )
    if solved.status == 2:
        return None
    if solved.status != 0:
        raise RuntimeError(f"HiGHS says {solved.message}")
    return round(solved.fun)
