"""Measures the trajectories: what motions cost beside collocation, and how long it takes to follow a plan.

    python -m benchmarks.trajectory [motions | rectangles | u-turns | times | pictures]...

Without an argument everything is printed. ``pictures`` writes the pictures and tables of ``docs/trajectory``.
The collocation (CasADi and IPOPT) knows nothing of the closed forms; it is that of the tests.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from mitlplan.draw import animation, picture, rendered
from mitlplan.formats.plan_json import plan_to_json
from mitlplan.formats.trajectory_csv import trajectory_to_csv
from mitlplan.mission import read
from mitlplan.plan import Plan, Step
from mitlplan.planner import plan
from mitlplan.trajectory import Profile, Robot, Style, Weights, follow, turn_left
from mitlplan.trajectory.boundary import connect, connect_forward
from mitlplan.trajectory.passage import choose, passage
from mitlplan.trajectory.pose import Pose
from mitlplan.trajectory.three_point import three_point
from mitlplan.workspace import Workspace, grid, movingai
from mitlplan.workspace.motion import Door, Rectangle

ROOT = Path(__file__).parent.parent
MAPS = ROOT / "examples" / "maps"
PAGES = ROOT / "docs" / "trajectory"
EQUAL = Weights()
BACK = math.pi


def motions() -> None:
    """The elementary motions of the unit cell in one second, beside collocation."""
    from tests.trajectory.elementary import ELEMENTARY

    print(f"{'motion':42} {'cost':>14} {'collocation':>14} {'gap':>9}")
    for one in ELEMENTARY:
        found = one.collocated()
        print(f"{one.name:42} {one.cost:14.9f} {found:14.9f} {one.cost - found:+9.0e}")
    quarter = turn_left(0.5, 0.5, EQUAL)
    assert quarter is not None
    for profile in (Profile.CUBIC, Profile.QUINTIC):
        print(f"quarter turn, {profile.name.lower() + ' profile':28} {quarter.smoothed(profile).cost:14.9f}")


def rectangles() -> None:
    """Quarter turns from a short side of a rectangle: when the free optimum leaves the cell."""
    print(f"{'aspect':>6} {'free':>11} {'outside':>9} {'least u':>9} {'forward-only':>13} {'arc':>11}")
    moments = np.linspace(0.0, 1.0, 20001)
    for aspect in (1.0, 1.5, 1.75, 1.79, 1.8, 2.0, 3.0, 5.0):
        free, forward, arc = (
            turn_left(aspect / 2, 0.5, EQUAL, style) for style in (Style.FREE, Style.FORWARD_ONLY, Style.ARC)
        )
        assert free is not None
        assert forward is not None
        assert arc is not None
        course = free.course(moments)
        outside = max(0.0, float(course.y.max()) - 0.5)
        print(
            f"{aspect:6} {free.cost:11.7f} {outside:9.6f} {course.u.min():9.5f} "
            f"{forward.cost:13.7f} {arc.cost:11.7f}"
        )


def u_turns() -> None:
    """U-turns in the unit cell: what they cost, and how near they come to the walls."""
    cell = Rectangle(0.0, 0.0, 1.0, 1.0)
    entry, leave = Door(-0.5, 0.0, 0.0, 1.0), Door(-0.5, 0.0, BACK, 1.0)
    way = passage(cell, Pose(-0.5, 0.0, 0.0), Pose(-0.5, 0.0, BACK), (entry, leave))
    from tests.trajectory.elementary import through_the_centre

    print(f"{'U-turn':14} {'cost':>11} {'clearance':>10} {'speed':>8} {'turn rate':>10}")
    for style in (Style.THREE_POINT, Style.FORWARD_ONLY, Style.SPOT):
        choice = choose(way, style, EQUAL, Profile.EVEN)
        assert choice is not None
        print(
            f"{style.value:14} {choice.motion.cost:11.7f} {choice.clearance:10.5f} "
            f"{choice.speed:8.4f} {choice.turn_rate:10.4f}"
        )
    print(f"three points, through the centre itself, by collocation: {through_the_centre():.7f}")


def times() -> None:
    """Seconds to follow plans, the first time and again, to sample them every 50 ms, and to draw them."""
    header = ("first", "again", "sample", "csv", "png")
    print(f"{'plan':26} {'cells':>6} {'cost':>10}" + "".join(f"{name:>9}" for name in header))
    for name, workspace, found in plans():
        seconds, cost = _measured(workspace, found)
        row = "".join(f"{value:9.3f}" for value in seconds)
        print(f"{name:26} {len(found.steps):6} {cost:10.3f}{row}")


def _measured(workspace: Workspace, found: Plan) -> tuple[list[float], float]:
    for cache in (choose, connect, connect_forward, three_point):
        cache.cache_clear()
    first = _seconds(lambda: follow(found, workspace))
    trajectory = follow(found, workspace)
    step = Fraction(1, 20)
    again = [
        lambda: follow(found, workspace),
        lambda: trajectory.sample(step),
        lambda: trajectory_to_csv(trajectory, step),
        lambda: rendered(picture(workspace, found, trajectory), "png"),
    ]
    return [first, *(min(_seconds(work) for _ in range(3)) for work in again)], trajectory.cost


def _seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def plans() -> Iterator[tuple[str, Workspace, Plan]]:
    """Fastest plans to a goal so many moves away, and a walk over a grid with every kind of turn."""
    yield "MovingAI random-32-32-20", *_way_on("random-32-32-20.map", (0, 0), 31)
    yield "MovingAI Berlin_1_256", *_way_on("Berlin_1_256.map", (20, 20), 299)
    yield "walk on a 60 x 60 grid", grid(60, 60), _walk(1000, 60)


def _way_on(file: str, start: tuple[int, int], moves: int) -> tuple[Workspace, Plan]:
    """The fastest plan to the last of the cells that are so many moves away."""
    bare = movingai(MAPS / file)
    begin = bare.index_of(f"r{start[0]}c{start[1]}")
    assert begin is not None
    name = bare.names[int(np.flatnonzero(_away_from(bare, begin) == moves)[-1])]
    row, column = (int(part) for part in name[1:].split("c"))
    workspace = movingai(MAPS / file, regions={"goal": [(row, column)]})
    found = plan(workspace, "F goal", start=start)
    assert isinstance(found, Plan)
    return workspace, found


def _away_from(workspace: Workspace, begin: int) -> Any:
    """For each cell how many moves away it is."""
    ends = (np.ones(workspace.move_count), (workspace.source, workspace.target))
    shape = (workspace.cell_count, workspace.cell_count)
    return dijkstra(csr_array(ends, shape=shape), indices=begin, unweighted=True)


def _walk(count: int, size: int) -> Plan:
    random = np.random.default_rng(0)
    cells = [(size // 2, size // 2)]
    while len(cells) < count:
        down, right = ((0, 1), (1, 0), (0, -1), (-1, 0))[int(random.integers(4))]
        row, column = cells[-1][0] + down, cells[-1][1] + right
        if 0 <= row < size and 0 <= column < size:
            cells.append((row, column))
    moments = [Fraction(place) for place in range(count)]
    steps = tuple(
        Step(f"r{row}c{column}", enter, min(enter + 1, moments[-1]))
        for (row, column), enter in zip(cells, moments, strict=True)
    )
    return Plan(steps, moments[-1])


def pictures() -> None:
    """The pictures, plans and tables of the documentation."""
    for name in ("phi1", "phi2"):
        mission = read(PAGES / f"{name}.yaml")
        found = plan(mission)
        assert isinstance(found, Plan)
        trajectory = follow(found, mission.workspace)
        (PAGES / f"{name}.json").write_text(plan_to_json(found))
        (PAGES / f"{name}.csv").write_text(trajectory_to_csv(trajectory, Fraction(1, 20)))
        (PAGES / f"{name}.svg").write_bytes(rendered(picture(mission.workspace, found, trajectory), "svg"))
        if name == "phi1":
            (PAGES / "phi1.gif").write_bytes(animation(mission.workspace, trajectory, radius=0.15))
    world, around = grid(2, 2, regions={"A": [(1, 0)], "B": [(0, 1)]}), _round_the_square()
    (PAGES / "phi1-round.svg").write_bytes(rendered(picture(world, around, follow(around, world)), "svg"))
    large = follow(_there_and_back(), grid(1, 2), robot=Robot(radius=Fraction(2, 5)))
    (PAGES / "large-robot.svg").write_bytes(rendered(picture(grid(1, 2), None, large), "svg"))
    _picture_of_a_robot()
    for name, workspace, found in plans():
        if name.startswith("MovingAI"):
            file = PAGES / f"{name.split()[1]}.png"
            file.write_bytes(rendered(picture(workspace, found, follow(found, workspace)), "png"))


def _picture_of_a_robot() -> None:
    """The example whose moves take their times from the robot, on the map without headings."""
    mission = read(MAPS.parent / "robot.yaml")
    found = plan(mission)
    assert isinstance(found, Plan)
    model = mission.robot
    assert model is not None
    driven = follow(found, mission.workspace, robot=model.robot, driving=model.driving, heading=model.heading)
    (PAGES / "robot.png").write_bytes(rendered(picture(model.ground, None, driven), "png"))


def _round_the_square() -> Plan:
    cells = [("r0c0", ()), ("r0c1", ("B",)), ("r1c1", ()), ("r1c0", ("A",))]
    moments = [Fraction(place) for place in range(4)]
    steps = tuple(
        Step(cell, enter, min(enter + 1, moments[-1]), holds)
        for (cell, holds), enter in zip(cells, moments, strict=True)
    )
    return Plan(steps, moments[-1])


def _there_and_back() -> Plan:
    steps = (
        Step("r0c0", Fraction(0), Fraction(1)),
        Step("r0c1", Fraction(1), Fraction(2)),
        Step("r0c0", Fraction(2), Fraction(2)),
    )
    return Plan(steps, Fraction(2))


PARTS: dict[str, Callable[[], None]] = {
    "motions": motions,
    "rectangles": rectangles,
    "u-turns": u_turns,
    "times": times,
    "pictures": pictures,
}


def main() -> None:
    """Do the parts that are asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "part", nargs="*", choices=[*PARTS, []], help="what to do; everything but pictures if none"
    )
    asked = parser.parse_args().part
    for name in asked or [part for part in PARTS if part != "pictures"]:
        print(f"== {name}")
        PARTS[name]()


if __name__ == "__main__":
    main()
