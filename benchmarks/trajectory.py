"""Measures the trajectories: what motions cost beside collocation, and how long it takes to follow a plan.

    python -m benchmarks.trajectory [motions | rectangles | u-turns | times | pictures]...

Without an argument everything is printed. ``pictures`` writes the pictures and tables of ``docs/trajectory``.
The collocation (CasADi and IPOPT) knows nothing of the closed forms; it is that of the tests.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mitlplan.draw import animation, picture, rendered
from mitlplan.formats.plan_json import plan_to_json
from mitlplan.formats.trajectory_csv import trajectory_to_csv
from mitlplan.mission import Mission, read
from mitlplan.plan import Plan, Step
from mitlplan.planner import plan
from mitlplan.trajectory import Profile, Robot, Style, Weights, follow, turn_left
from mitlplan.trajectory.boundary import connect, connect_forward
from mitlplan.trajectory.passage import choose, passage
from mitlplan.trajectory.pose import Pose
from mitlplan.trajectory.three_point import three_point
from mitlplan.workspace import Workspace, grid
from mitlplan.workspace.motion import Door, Rectangle

ROOT = Path(__file__).parent.parent
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
    """Seconds to follow plans, the first time and again, to sample them every 50 ms, to write and draw them.

    The last two columns are of the command ``mitlplan trajectory MISSION PLAN.json -o FILE``, in a process of
    its own: in all, and how much longer it takes than for the four cells of phi1, which is its start-up.
    """
    header = ("first", "again", "sample", "csv", "png", "command", "besides")
    print(f"{'plan':26} {'cells':>6} {'cost':>10}" + "".join(f"{name:>9}" for name in header))
    with TemporaryDirectory() as folder:
        small, large = PAGES / "phi1.yaml", Path(folder) / "walk.json"
        large.write_text(json.dumps(WALK))
        for title, file in (
            ("MovingAI random-32-32-20", PAGES / "random-32-32-20.yaml"),
            ("MovingAI Berlin_1_256", PAGES / "Berlin_1_256.yaml"),
            ("walk on a 60 x 60 grid", large),
        ):
            mission = read(file)
            found = _walk(1000, 60) if file == large else _plan(mission)
            seconds, cost = _measured(mission.workspace, found)
            seconds += _commanded({file: found, small: _plan(read(small))}, Path(folder))
            row = "".join(f"{value:9.3f}" for value in seconds)
            print(f"{title:26} {len(found.steps):6} {cost:10.3f}{row}")


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


def _commanded(plans: Mapping[Path, Plan], folder: Path) -> list[float]:
    """Seconds of the command for the first plan, and beyond those for the second, run in turns."""
    best = dict.fromkeys(plans, math.inf)
    for _, (mission, found) in product(range(5), plans.items()):
        file, table = folder / "plan.json", folder / "plan.csv"
        file.write_text(plan_to_json(found))
        command = [sys.executable, "-m", "mitlplan", "trajectory", str(mission), str(file), "-o", str(table)]
        taken = _seconds(partial(subprocess.run, command, check=True))
        best[mission] = min(best[mission], taken)
    whole, start_up = best.values()
    return [whole, whole - start_up]


def _seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


WALK = {
    "mitlplan": 1,
    "workspace": {"grid": {"rows": 60, "columns": 60, "regions": {"goal": [[8, 5]]}}},
    "robot": {"start": [30, 30]},
    "spec": "F goal",
}


def _walk(count: int, size: int) -> Plan:
    """A walk over a grid with every kind of turn, which comes to the goal of WALK."""
    random = np.random.default_rng(0)
    cells = [(size // 2, size // 2)]
    while len(cells) < count:
        down, right = ((0, 1), (1, 0), (0, -1), (-1, 0))[int(random.integers(4))]
        row, column = cells[-1][0] + down, cells[-1][1] + right
        if 0 <= row < size and 0 <= column < size:
            cells.append((row, column))
    return _timed([(f"r{row}c{column}", ("goal",) * ((row, column) == (8, 5))) for row, column in cells])


def _timed(cells: Sequence[tuple[str, tuple[str, ...]]]) -> Plan:
    """The plan through these cells, with what holds in them, a second for each move."""
    last = len(cells) - 1
    steps = tuple(
        Step(cell, Fraction(place), Fraction(min(place + 1, last)), holds)
        for place, (cell, holds) in enumerate(cells)
    )
    return Plan(steps, Fraction(last))


def _plan(mission: Mission) -> Plan:
    found = plan(mission)
    assert isinstance(found, Plan)
    return found


def pictures() -> None:
    """The pictures, plans and tables of the documentation."""
    for name, kind, step in (
        ("phi1", "svg", Fraction(1, 20)),
        ("phi2", "svg", Fraction(1, 20)),
        ("random-32-32-20", "png", Fraction(1, 10)),
        ("Berlin_1_256", "png", Fraction(1, 2)),
    ):
        mission = read(PAGES / f"{name}.yaml")
        found = _plan(mission)
        found = replace(found, statistics=replace(found.statistics, seconds={}))
        trajectory = follow(found, mission.workspace)
        (PAGES / f"{name}.json").write_text(plan_to_json(found))
        (PAGES / f"{name}.csv").write_text(trajectory_to_csv(trajectory, step))
        (PAGES / f"{name}.{kind}").write_bytes(rendered(picture(mission.workspace, found, trajectory), kind))
        if name == "phi1":
            (PAGES / "phi1.gif").write_bytes(animation(mission.workspace, trajectory, radius=0.15))
    world = grid(2, 2, regions={"A": [(1, 0)], "B": [(0, 1)]})
    around = _timed([("r0c0", ()), ("r0c1", ("B",)), ("r1c1", ()), ("r1c0", ("A",))])
    (PAGES / "phi1-round.svg").write_bytes(rendered(picture(world, around, follow(around, world)), "svg"))
    back = _timed([("r0c0", ()), ("r0c1", ()), ("r0c0", ())])
    large = follow(back, grid(1, 2), robot=Robot(radius=Fraction(2, 5)))
    (PAGES / "large-robot.svg").write_bytes(rendered(picture(grid(1, 2), None, large), "svg"))
    _picture_of_a_robot()


def _picture_of_a_robot() -> None:
    """The example whose moves take their times from the robot, on the map without headings."""
    mission = read(ROOT / "examples" / "robot.yaml")
    found = _plan(mission)
    model = mission.robot
    assert model is not None
    driven = follow(found, mission.workspace, robot=model.robot, driving=model.driving, heading=model.heading)
    (PAGES / "robot.png").write_bytes(rendered(picture(model.ground, None, driven), "png"))


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
