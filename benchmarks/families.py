"""What is measured: missions in families that grow, each with the peers that can answer it.

Grids have B at the top right, A at the bottom left and the robot at the top left; one move takes one second,
and there is no waiting, unless said. Random choices come from a fixed seed: every run measures the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from benchmarks.peers import Peer, Visits, on_distances, on_product, on_walks, subset_programming
from benchmarks.product import (
    Finish,
    Product,
    Recipe,
    build,
    fetch,
    ordered,
    respond,
    visit,
    windows_by_counting,
    windows_by_parity,
)
from benchmarks.satisfiability import NotBefore, Respond, See
from mitlplan.mission import Mission, mission_for, read
from mitlplan.workspace import Box, Workspace, grid
from mitlplan.workspace.grid import on_terrain
from mitlplan.workspace.movingai import read_terrain

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
MAPS = (EXAMPLES / "maps", Path(__file__).parent / "maps")

Expected: TypeAlias = Union[Fraction, Literal["infeasible", "unknown"]]
"""The least makespan in seconds, as far as theory tells; where it does not, the contestants must agree."""


@dataclass(frozen=True, eq=False)
class Instance:
    """A mission to be planned by all contestants.

    Parameters
    ----------
    name, size
        Instances of one name differ in size; where a contestant meets its limit, larger ones are not tried.
    """

    name: str
    size: str
    mission: Mission
    expected: Expected
    peers: tuple[Peer, ...] = ()


def on(
    workspace: Workspace, start: int, *spec: str, horizon: Literal["infinite", "finite"] = "infinite"
) -> Mission:
    """A mission with requirements that nobody named."""
    named = {f"requirement {number}": text for number, text in enumerate(spec, start=1)}
    return mission_for(workspace, named, start=workspace.names[start], horizon=horizon)


def by_hand(workspace: Workspace, start: int, made: tuple[Recipe, Finish]) -> tuple[Peer, ...]:
    """The peers on a hand-made product."""

    def make() -> Product:
        recipe, finish = made
        return build(workspace, start, recipe, finish)

    return on_product(make)


# ---------------------------------------------------------------------------------------- the examples


def examples() -> Iterator[Instance]:
    """The mission files of ``examples``, and the warehouse with every time 1000/7 as long."""
    fetching: tuple[tuple[str, Expected, int], ...] = (
        ("warehouse", Fraction(154), 160),
        ("warehouse-infeasible", "infeasible", 153),
    )
    for name, expected, by in fetching:
        one = read(EXAMPLES / f"{name}.yaml")
        made = fetch("p2", "bay", cells=one.workspace.cell_count, by=(None, by), within=80)
        yield Instance(name, "", one, expected, by_hand(one.workspace, one.start, made))
    yield slow_warehouse()
    finding: tuple[tuple[str, Expected, int], ...] = (
        ("rescue", Fraction(110), 55),
        ("rescue-infeasible", "infeasible", 50),
    )
    for name, expected, by in finding:
        one = read(EXAMPLES / f"{name}.yaml")
        cells = one.workspace.cell_count
        made = fetch("victim", "safe", cells=cells, avoid="fire", by=(by, None), within=60)
        yield Instance(name, "", one, expected, by_hand(one.workspace, one.start, made))
    patrols: tuple[tuple[str, Expected], ...] = (
        ("patrol-berlin", Fraction(756)),
        ("patrol-berlin-infeasible", "infeasible"),
    )
    for name, expected in patrols:
        yield Instance(name, "", read(EXAMPLES / f"{name}.yaml"), expected)


SLOWER = Fraction(1000, 7)


def slow_warehouse() -> Instance:
    """The warehouse with every time 1000/7 as long: the same work, if work does not grow with numbers."""
    workspace = terrain_map(
        "warehouse-10-20-10-2-1",
        {"p2": [(31, 80)], "bay": [(31, 157)]},
        move_time=SLOWER,
        waiting=True,
    )
    start = workspace.index_of("r31c3")
    assert start is not None
    one = on(
        workspace,
        start,
        "!bay U p2",
        f"F[0,{160 * SLOWER}] bay",
        f"G (p2 -> F[0,{80 * SLOWER}] bay)",
    )
    made = fetch("p2", "bay", cells=workspace.cell_count, by=(None, 160), within=80)
    return Instance("warehouse x 1000/7", "", one, 154 * SLOWER, by_hand(workspace, start, made))


def terrain_map(
    name: str,
    regions: dict[str, Any],
    *,
    tiles: int = 1,
    move_time: Fraction = Fraction(1),
    waiting: bool = False,
) -> Workspace:
    """A MovingAI map, `tiles` times beside itself and below."""
    terrain = np.tile(terrain_of(name), (tiles, tiles))
    return on_terrain(terrain, move_time=move_time, waiting=waiting, regions=regions)


def terrain_of(name: str) -> NDArray[np.uint8]:
    """The terrain of one of the maps."""
    file = next(folder / f"{name}.map" for folder in MAPS if (folder / f"{name}.map").exists())
    return read_terrain(file)


# ----------------------------------------------------------------------------- a: the paper's formulas


def corners(size: int) -> Workspace:
    """The grid of the paper's example, larger."""
    return grid(size, size, regions={"A": [(size - 1, 0)], "B": [(0, size - 1)]})


def paper(name: str, size: int) -> Instance:
    """One of the paper's formulas on a grid; the intervals grow with it, 4 to 4 (n-1) and 2 to 2 (n-1).

    With n = 2 these are the paper's own, as in ``examples/paper``. All but phi2 take 3 (n-1).
    """
    workspace = corners(size)
    half, whole = 2 * (size - 1), 4 * (size - 1)
    expected = Fraction(3 * (size - 1))
    label = f"n = {size}"
    match name:
        case "phi1":
            walks = on_walks(workspace, 0, NotBefore("B", "A"), See("A"))
            peers = (*by_hand(workspace, 0, ordered()), *walks)
            return Instance(name, label, on(workspace, 0, "!A U B", "F A"), expected, peers)
        case "phi2":
            # A is n-1 away, and from then on every second move ends there.
            one = on(workspace, 0, f"G F[0,{max(2, size)}] A")
            return Instance(name, label, one, "unknown")
        case "phi3":
            walks = on_walks(workspace, 0, See("A", last=whole), See("B", last=whole))
            peers = (*by_hand(workspace, 0, visit("A", "B", within=whole)), *walks)
            one = on(workspace, 0, f"F[0,{whole}] A", f"F[0,{whole}] B")
            return Instance(name, label, one, expected, peers)
        case "phi4" | "phi4, peers count":
            one = on(workspace, 0, f"F[{half},{whole}] A", f"F[0,{half}] B")
            if name == "phi4":
                walks = on_walks(workspace, 0, See("A", half, whole), See("B", last=half))
                peers = (*by_hand(workspace, 0, windows_by_parity("A", (half, whole), "B")), *walks)
            else:
                peers = by_hand(workspace, 0, windows_by_counting("A", (half, whole), "B", half))
            return Instance(name, label, one, expected, peers)
    raise ValueError(name)


# ------------------------------------------------------------------------------ b: goals by a deadline


def reachable(workspace: Workspace, start: int) -> NDArray[np.int32]:
    """The cells that can be reached from `start`, in the order of their numbers."""
    graph = csr_array(
        (np.ones(workspace.move_count), (workspace.source, workspace.target)),
        shape=(workspace.cell_count,) * 2,
    )
    return np.sort(breadth_first_order(graph, start, return_predecessors=False))


def goals(terrain: NDArray[np.uint8], map_name: str, count: int, *, feasible: bool) -> Instance:
    """As many goals, a cell each, by one time for all: a tenth more than the optimum, or 1 less than it."""
    plain = on_terrain(terrain)
    start = 0
    random = np.random.default_rng(count)
    cells = [int(cell) for cell in random.choice(reachable(plain, start)[1:], count, replace=False)]
    names = [f"g{number}" for number in range(count)]
    places = np.argwhere(terrain)
    regions = {name: [tuple(places[cell].tolist())] for name, cell in zip(names, cells, strict=True)}
    workspace = on_terrain(terrain, regions=regions)
    optimum = subset_programming(Visits(plain, start, tuple(cells), 0).distances())
    within = optimum + optimum // 10 if feasible else optimum - 1
    visits = Visits(workspace, start, tuple(cells), within)
    # One requirement: with several, an infeasible mission is searched again for each, to name the conflict.
    one = on(workspace, start, " & ".join(f"F[0,{within}] {name}" for name in names))
    peers = on_distances(visits)
    if count <= 10 and workspace.cell_count << count <= 1 << 20:
        peers = (*by_hand(workspace, start, visit(*names, within=within)), *peers)
    return Instance(
        f"goals, {map_name}, {'T = 1.1 optimum' if feasible else 'T = optimum - 1'}",
        f"k = {count}",
        one,
        Fraction(optimum) if feasible else "infeasible",
        peers,
    )


# --------------------------------------------------------------------------------- c: bounded response


def responses(count: int, size: int) -> Instance:
    """``G(p -> F[0,2n] q)``, several, on the way to the far corner, up to the end of the mission.

    The p are whole rows, so each must be crossed; each q is a cell drawn at random further down.
    """
    random = np.random.default_rng(size * 16 + count)
    rows = [(number + 1) * size // (count + 1) for number in range(count)]
    regions: dict[str, Any] = {"goal": [(size - 1, size - 1)]}
    pairs = tuple((f"p{number}", f"q{number}") for number in range(count))
    for (asked, answered), row in zip(pairs, rows, strict=True):
        regions[asked] = Box(rows=(row, row), columns=(0, size - 1))
        regions[answered] = [(int(random.integers(row + 1, size)), int(random.integers(size)))]
    workspace = grid(size, size, regions=regions)
    within = 2 * size
    spec = ["F goal", *(f"G ({asked} -> F[0,{within}] {answered})" for asked, answered in pairs)]
    one = on(workspace, 0, *spec, horizon="finite")
    required = (See("goal"), *(Respond(asked, answered, within) for asked, answered in pairs))
    return Instance(
        f"responses, {count}",
        f"n = {size}",
        one,
        "unknown",
        (*by_hand(workspace, 0, respond(pairs, within, "goal")), *on_walks(workspace, 0, *required)),
    )


# --------------------------------------------------------------------------------------- d: large maps


def large(map_name: str, tiles: int, *, size: int | None = None) -> Instance:
    """Two regions of 1 % of the map in a given order and by a deadline, around a forbidden one of 1 %."""
    if size is None:
        terrain = np.tile(terrain_of(map_name), (tiles, tiles))
    else:
        terrain = np.ones((size, size), dtype=np.uint8)
    rows, columns = terrain.shape
    side = (rows // 10, columns // 10)

    def box(row: int, column: int) -> Box:
        return Box(rows=(row, row + side[0] - 1), columns=(column, column + side[1] - 1))

    regions = {
        "A": box(rows - side[0], 0),
        "B": box(rows // 10, columns - side[1]),
        "fire": box((rows - side[0]) // 2, (columns - side[1]) // 2),
    }
    workspace = on_terrain(terrain, regions=regions)
    start = int(reachable(workspace, _first_of_largest(workspace))[0])
    within = 4 * (rows + columns)
    one = on(workspace, start, "!A U B", f"F[0,{within}] A", "G !fire", horizon="finite")

    def advance(state: object, label: frozenset[str]) -> object:
        recipe = ordered()[0]
        return "dead" if "fire" in label else recipe[1](state, label)

    finish = visit("A", within=within)[1]
    peers = by_hand(workspace, start, (("unseen", advance), finish))
    return Instance(f"large, {map_name}", f"{rows} x {columns}", one, "unknown", peers)


def _first_of_largest(workspace: Workspace) -> int:
    from scipy.sparse.csgraph import connected_components

    graph = csr_array(
        (np.ones(workspace.move_count), (workspace.source, workspace.target)),
        shape=(workspace.cell_count,) * 2,
    )
    part = connected_components(graph)[1]
    return int(np.argmax(part == np.argmax(np.bincount(part))))
