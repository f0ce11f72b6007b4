"""Following a plan: motions joined in order, each stretched to the time that its cell has in the plan.

The robot starts at the centre of the first cell, crosses from cell to cell through the middle of the shared
edge at the planned instants, square to the edge, and stops at the centre of the last. How it faces at each
crossing, ahead or (if it may) backwards, is chosen by dynamic programming so that the sum of costs is least.
A stay that is longer than its move is a wait.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from mitlplan.errors import TrajectoryError
from mitlplan.plan import Plan, Step
from mitlplan.trajectory.motion import Motion, standing
from mitlplan.trajectory.passage import Choice, Passage, passage
from mitlplan.trajectory.pose import Pose
from mitlplan.trajectory.robot import (
    CHEAPEST_DRIVING,
    UNLIMITED_ROBOT,
    Driving,
    Robot,
    choices,
    least_time,
    obstacle,
)
from mitlplan.trajectory.timetable import Span
from mitlplan.trajectory.trajectory import Piece, Trajectory, Visit
from mitlplan.workspace.motion import Door, doors, rectangle_of
from mitlplan.workspace.workspace import Workspace


class Waiting(Enum):
    """What the robot does with the time that a stay has beyond its move."""

    ENTRY = "entry"
    """It stands where it entered."""
    CENTRE = "centre"
    """It stands at the centre of the cell."""
    SLOW = "slow"
    """It takes the whole stay for its way, which costs least."""


_AHEAD, _ASTERN = 0.0, math.pi
_Chain: TypeAlias = "tuple[_Driven, _Chain] | None"
"""What is done in the stays so far, the last first."""

_AMPLE = 10**6
"""So many times the time of a plan is enough for whatever can be driven."""

_TICKS = 10**6
"""Times that come of floats are rounded to this part of a second."""


@dataclass(frozen=True, slots=True)
class _Stay:
    """A visit with its doors.

    `time` is what the plan gives it; its own move takes `least` to `travel`, or None if that is all of it.
    """

    visit: Visit
    entry: Door | None
    leave: Door | None
    time: Fraction
    least: Fraction
    travel: Fraction | None


@dataclass(frozen=True, slots=True, eq=False)
class _Driven:
    """What is done in a stay: motions with their seconds and where they begin; the seconds they need."""

    parts: tuple[tuple[Motion, Fraction, Pose], ...]
    cost: float = 0.0
    need: float = 0.0


@dataclass(frozen=True, slots=True)
class _Route:
    """The stays of a plan; one that goes round for ever comes back to the way out of ``stays[start]``."""

    stays: tuple[_Stay, ...]
    start: int | None = None


def follow(
    plan: Plan,
    workspace: Workspace,
    *,
    robot: Robot = UNLIMITED_ROBOT,
    driving: Driving = CHEAPEST_DRIVING,
    waiting: Waiting = Waiting.ENTRY,
    start: tuple[float, float] | None = None,
    heading: float | None = None,
    stop_time: Fraction | None = None,
) -> Trajectory:
    """The cheapest trajectory that is in the cells of `plan` when it says so.

    Parameters
    ----------
    plan
        Whose moves the workspace allows.
    workspace
        With positions and sizes.
    robot
        Its limits.
    driving
        How it is driven.
    waiting
        What it does with the time that a stay has beyond its move.
    start
        Where in the first cell it starts, in metres; ``None``: at the centre.
    heading
        How it faces at first, in radians; ``None``: as is cheapest.
    stop_time
        Seconds for the way to the centre of the last cell, after the plan's last crossing; ``None``: half the
        travel time of the last move.

    Raises
    ------
    TrajectoryError
        If the robot cannot drive so: the sentence names the cell and the limit.
    WorkspaceError
        If the map has no geometry, or two cells in a row do not touch.

    Examples
    --------
    >>> from mitlplan.workspace import grid
    >>> steps = (Step("r0c0", Fraction(0), Fraction(1)), Step("r0c1", Fraction(1), Fraction(1)))
    >>> trajectory = follow(Plan(steps, makespan=Fraction(1)), grid(1, 2))
    >>> trajectory.end, trajectory.last_pose
    (Fraction(3, 2), Pose(x=1.5, y=0.5, heading=0.0))
    """
    route = _route(plan, workspace, stop_time)
    driver = _Driver(robot, driving, waiting, start, heading)
    driven = driver.drive(route)
    repeat_from = None if route.start is None else route.stays[route.start].visit.leave
    visits = tuple(stay.visit for stay in route.stays)
    return Trajectory(visits, tuple(_pieces(route, driven)), driving.weights, repeat_from)


def spans_of(
    plan: Plan,
    workspace: Workspace,
    *,
    robot: Robot = UNLIMITED_ROBOT,
    driving: Driving = CHEAPEST_DRIVING,
    start: tuple[float, float] | None = None,
    heading: float | None = None,
) -> list[Span]:
    """What each stay that is left by a move costs, and how long it may be, for :func:`retime`.

    Parameters
    ----------
    plan, workspace, robot, driving, start, heading
        As in :func:`follow`, but the times of the plan need not be enough for the robot: how it faces is what
        is cheapest for them, and what it can drive at all is given the time that it needs.

    Raises
    ------
    TrajectoryError, WorkspaceError
        As :func:`follow`.
    """
    route = _route(plan, workspace, None)
    ample = tuple(
        stay if stay.leave is None else replace(stay, time=_AMPLE * stay.time, travel=None)
        for stay in route.stays
    )
    driven = _Driver(robot, driving, Waiting.SLOW, start, heading).drive(replace(route, stays=ample))
    # The first cell of a loop is met again at the end of the route, where it is no step of the plan.
    stays = route.stays[: len(plan.steps)]
    return [
        Span(
            cost=done.parts[0][0].cost,
            least=max(stay.least, _rounded_up(done.need)),
            most=None if workspace.waiting else stay.travel,
        )
        for stay, done in zip(stays, driven, strict=False)
        if stay.leave is not None
    ]


# ------------------------------------------------------------------------------------------------- the route


def _route(plan: Plan, workspace: Workspace, stop_time: Fraction | None) -> _Route:
    steps, start = list(plan.steps), None
    if plan.loop is not None and plan.loop.period is not None:
        # The first cell of the loop is entered another way the second time, so the loop is closed behind it.
        start = plan.loop.start
        again = steps[start]
        steps.append(replace(again, enter=plan.makespan, leave=plan.makespan + _stay_length(again)))
    cells = [_index(workspace, step) for step in steps]
    onward = cells[1:] if start is None else [*cells[1:], cells[start + 1]]
    source, target = (np.array(ends, dtype=np.int32) for ends in (cells[: len(onward)], onward))
    ways = doors(workspace, source, target)
    entries = [None, *ways]
    stays = [
        _Stay(
            Visit(step.cell, rectangle_of(workspace, cell), step.enter, step.leave),
            entry,
            leave,
            _stay_length(step),
            *_move_times(workspace, cell, following),
        )
        for step, cell, following, entry, leave in zip(
            steps[: len(ways)], cells[: len(ways)], onward, entries[: len(ways)], ways, strict=True
        )
    ]
    if start is None:
        before = stays[-1].travel or stays[-1].time if stays else Fraction(2)
        last = steps[-1]
        ground = rectangle_of(workspace, cells[-1])
        stays.append(
            _Stay(
                Visit(last.cell, ground, last.enter, None),
                entries[-1],
                None,
                Fraction(0) if last.leave is None else _length(last),
                Fraction(0),
                before / 2 if stop_time is None else stop_time,
            )
        )
    return _Route(tuple(stays), start)


def _length(step: Step) -> Fraction:
    if step.leave is None:
        raise TrajectoryError(f"the plan leaves {step.cell} never, but goes on")
    if step.leave < step.enter:
        raise TrajectoryError(
            f"the plan leaves {step.cell} at {step.leave}, before it enters at {step.enter}"
        )
    return step.leave - step.enter


def _stay_length(step: Step) -> Fraction:
    if step.leave == step.enter:
        raise TrajectoryError(
            f"the plan leaves {step.cell} at {step.enter}, when it enters; a stay takes time"
        )
    return _length(step)


def _index(workspace: Workspace, step: Step) -> int:
    index = workspace.index_of(step.cell)
    if index is None:
        raise TrajectoryError(f"no cell is called {step.cell}; {workspace.advise(step.cell)}")
    return index


def _move_times(workspace: Workspace, cell: int, onward: int) -> tuple[Fraction, Fraction | None]:
    """The least and the longest time that the move takes, waiting aside; ``None``: as long as one likes."""
    moves = [move for move in workspace.moves_from(cell) if workspace.target[move] == onward]
    if not moves:
        names = workspace.names[cell], workspace.names[onward]
        raise TrajectoryError(f"the plan goes from {names[0]} to {names[1]}, but no move leads there")
    longest = [most for move in moves if (most := workspace.most_time(move)) is not None]
    least = min(workspace.least_time(move) for move in moves)
    return least, max(longest) if len(longest) == len(moves) else None


# ----------------------------------------------------------------------------------------------- the choices


@dataclass(frozen=True, slots=True)
class _Driver:
    """Chooses the motions for the stays."""

    robot: Robot
    driving: Driving
    waiting: Waiting
    place: tuple[float, float] | None
    heading: float | None

    def drive(self, route: _Route) -> tuple[_Driven, ...]:
        """The cheapest way of driving all stays, over how the robot faces at the doors."""
        facings = (_AHEAD, _ASTERN) if self.driving.reverse else (_AHEAD,)
        if route.start is None:
            return self._cheapest(route.stays, [facings] * len(route.stays))[1]
        closed: list[tuple[float, tuple[_Driven, ...]]] = []
        refusals: list[TrajectoryError] = []
        for facing in facings:
            # Who goes round leaves the loop's first cell facing as the first time.
            allowed = [facings] * len(route.stays)
            allowed[route.start] = allowed[-1] = (facing,)
            try:
                closed.append(self._cheapest(route.stays, allowed))
            except TrajectoryError as refusal:
                refusals.append(refusal)
        if not closed:
            raise refusals[0]
        return min(closed, key=lambda found: found[0])[1]

    def _cheapest(
        self, stays: Sequence[_Stay], allowed: Sequence[tuple[float, ...]]
    ) -> tuple[float, tuple[_Driven, ...]]:
        """Dynamic programming over the facing at each way out: the cost so far, and the way back."""
        best: dict[float, tuple[float, _Chain]] = {_AHEAD: (0.0, None)}
        for stay, facings in zip(stays, allowed, strict=True):
            reached: dict[float, tuple[float, _Chain]] = {}
            refused = ""
            for facing in facings if stay.leave else (_AHEAD,):
                for before, (cost, chain) in best.items():
                    driven = self._drive_stay(stay, before, facing)
                    if isinstance(driven, str):
                        refused = refused or driven
                    elif facing not in reached or cost + driven.cost < reached[facing][0]:
                        reached[facing] = cost + driven.cost, (driven, chain)
            if not reached:
                raise TrajectoryError(f"{stay.visit.cell}, entered at {stay.visit.enter}: {refused}")
            best = reached
        cost, chain = min(best.values(), key=lambda found: found[0])
        return cost, tuple(_unwound(chain))

    def _drive_stay(self, stay: _Stay, entering: float, leaving: float) -> _Driven | str:
        """What to do in a stay, or why nothing can be done."""
        begin = self._begin(stay, leaving) if stay.entry is None else _at(stay.entry, entering)
        goal = None if stay.leave is None else _at(stay.leave, leaving)
        open_doors = tuple(door for door in (stay.entry, stay.leave) if door is not None)
        if stay.entry is None and goal is None:
            time = max(stay.time, stay.travel or Fraction(1))
            return _Driven(((standing(), time, begin),))
        waits = stay.travel is not None and stay.travel < stay.time and self.waiting is Waiting.CENTRE
        if waits and goal is not None and stay.entry is not None:
            return self._by_centre(stay, begin, goal, open_doors)
        way = passage(stay.visit.ground, begin, goal, open_doors)
        chosen = self._choose(way, stay.time, stay.travel, goal is None)
        if isinstance(chosen, str):
            return chosen
        choice, time = chosen
        still = (standing(), stay.time - time, begin)
        moving = (choice.motion, time, begin)
        rest = (standing(), stay.time - time, begin.then(choice.motion.end))
        parts = (moving, rest) if goal is None else (still, moving)
        return _Driven(
            tuple(part for part in parts if part[1] > 0),
            choice.motion.cost_in(float(time)),
            least_time(choice, self.robot),
        )

    def _begin(self, stay: _Stay, leaving: float) -> Pose:
        ground = stay.visit.ground
        x, y = (ground.x, ground.y) if self.place is None else self.place
        if not ground.contains(x, y):
            raise TrajectoryError(f"the robot starts at ({x:g}, {y:g}), which is not in {stay.visit.cell}")
        if self.heading is not None or stay.leave is None:
            return Pose(x, y, self.heading or 0.0)
        east, north = stay.leave.x - x, stay.leave.y - y
        straight = abs(math.remainder(math.atan2(north, east) - stay.leave.heading, 2 * math.pi)) < 1e-9
        course = stay.leave.heading if straight else math.atan2(north, east)
        return Pose(x, y, course + leaving)

    def _choose(
        self, way: Passage, stay: Fraction, travel: Fraction | None, stopping: bool
    ) -> tuple[Choice, Fraction] | str:
        """The first motion that can be driven, and its time; a stop may take as long as it needs."""
        refused = "no motion stays inside"
        for number, choice in enumerate(choices(way, self.driving)):
            wanted = stay if travel is None or (self.waiting is Waiting.SLOW and not stopping) else travel
            need = least_time(choice, self.robot)
            wanted = max(wanted, _rounded_up(need))
            time = wanted if stopping else min(stay, wanted)
            obstacle_met = obstacle(choice, float(time), self.robot)
            if not obstacle_met:
                return choice, time
            if number == 0:
                refused = obstacle_met
        return refused

    def _by_centre(self, stay: _Stay, begin: Pose, goal: Pose, open_doors: tuple[Door, ...]) -> _Driven | str:
        """To the centre, a wait, and on; both halves at the same rate of cost."""
        assert stay.travel is not None
        found: list[Choice] = []
        middle = begin
        for target in (None, goal):
            way = passage(stay.visit.ground, middle, target, open_doors)
            fitting = (c for c in choices(way, self.driving) if not obstacle(c, math.inf, self.robot))
            choice = next(fitting, None)
            if choice is None:
                return "the robot does not fit through by way of the centre"
            found.append(choice)
            if target is None:
                middle = middle.then(choice.motion.end)
        roots = [math.sqrt(choice.motion.cost) for choice in found]
        need = max(
            least_time(c, self.robot) * sum(roots) / root for c, root in zip(found, roots, strict=True)
        )
        time = min(stay.time, max(stay.travel, _rounded_up(need)))
        first = Fraction(round(time * _TICKS * Fraction(roots[0] / sum(roots))), _TICKS)
        times = (first, time - first)
        for choice, given in zip(found, times, strict=True):
            if refused := obstacle(choice, float(given), self.robot):
                return refused
        wait = (standing(), stay.time - time, middle)
        parts = ((found[0].motion, times[0], begin), wait, (found[1].motion, times[1], middle))
        cost = sum(choice.motion.cost_in(float(given)) for choice, given in zip(found, times, strict=True))
        return _Driven(tuple(part for part in parts if part[1] > 0), cost)


def _rounded_up(seconds: float) -> Fraction:
    """A time that a limit asks for; without end, nothing can be said of it."""
    if math.isinf(seconds):
        return Fraction(0)
    return Fraction(math.ceil(seconds * _TICKS * (1 - 1e-9)), _TICKS)


def _at(door: Door, facing: float) -> Pose:
    return Pose(door.x, door.y, door.heading + facing)


def _unwound(chain: _Chain) -> list[_Driven]:
    found = []
    while chain is not None:
        driven, chain = chain
        found.append(driven)
    return found[::-1]


def _pieces(route: _Route, driven: Sequence[_Driven]) -> Iterator[Piece]:
    """The motions in their places, headings counted on from one to the next."""
    heading: float | None = None
    for number, (stay, done) in enumerate(zip(route.stays, driven, strict=True)):
        begin = stay.visit.enter
        for motion, time, pose in done.parts:
            turns = 0 if heading is None else round((heading - pose.heading) / (2 * math.pi))
            place = replace(pose, heading=pose.heading + turns * 2 * math.pi)
            yield Piece(motion, number, begin, time, place)
            begin, heading = begin + time, place.heading + motion.end.heading
