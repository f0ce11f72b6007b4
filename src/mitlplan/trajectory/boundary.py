"""From one pose to another at least cost: the boundary-value problem, three unknowns.

An extremal is fixed by its start: speed, momentum across, turn rate. Those that end at the goal are the
roots of three equations in closed form; the cheapest of them is taken. Several starts find them: the turn on
the spot continued to the goal, and a fixed scatter. Long motions pass so close to the pendulum's upper
equilibrium that floats cannot tell their start; those that turn one way only are found from the headings at
both ends and the modulus instead (two unknowns), which stays well conditioned.

With u >= 0 the best control is the positive part of p cos(th - b): where that is negative the robot turns on
the spot. Inside this module the unit of length is that of the weights, and every way takes one second.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from mitlplan.trajectory.elliptic import Modulus
from mitlplan.trajectory.leg import Leg, Oscillating, Rotating, Steady, Weights, end_of, extremal
from mitlplan.trajectory.pose import ORIGIN, Pose

Array: TypeAlias = NDArray[np.float64]
Way: TypeAlias = tuple[Leg, ...]
Flight: TypeAlias = Callable[[float, float, float], Way]

_STARTS = 20
_SAME = 1e-9
_MOST_STRETCHES = 6
_NEAR = 0.2
_STRIDE = 0.3


@lru_cache(maxsize=4096)
def connect(goal: Pose, length: float) -> Way:
    """The cheapest way from the origin to `goal` in one second; empty if none was found.

    Parameters
    ----------
    goal
        As seen from the start, in metres; its heading, in radians, says which way and how often to turn.
    length
        The unit of length of the weights, in metres.

    Examples
    --------
    >>> (leg,) = connect(Pose(0.5, 0.5, math.pi / 2), length=1.0)
    >>> round(leg.rate(Weights()), 10)
    3.0771054975
    """
    target = _canonical(goal, length)
    steady = _steady(target)
    found = [steady] if steady else [*_turning_one_way(target), *_shot(target, _free_flight, _STARTS)]
    return in_metres(_cheapest(found), length)


@lru_cache(maxsize=4096)
def connect_forward(goal: Pose, length: float) -> Way:
    """As :func:`connect`, but never driving backwards."""
    target = _canonical(goal, length)
    steady = _steady(target)
    if steady and target.x >= 0:
        return in_metres(steady, length)
    # A way that begins with a turn on the spot is found more easily from its end.
    onward = _shot(target, _forward_flight, _STARTS // 2)
    retraced = _shot(_retraced(target), _forward_flight, _STARTS // 2)
    ways = [*onward, *(tuple(leg.retraced for leg in reversed(way)) for way in retraced)]
    return in_metres(_cheapest(ways), length)


def end_of_way(way: Way) -> Pose:
    """The pose at the end of legs driven one after the other."""
    pose = ORIGIN
    for leg in way:
        pose = pose.then(end_of(leg))
    return pose


def cost_of_way(way: Way, weights: Weights) -> float:
    """The integral of the rate of cost along `way`."""
    return sum(leg.rate(weights) * leg.duration for leg in way)


def _canonical(pose: Pose, length: float) -> Pose:
    return Pose(pose.x / length, pose.y / length, pose.heading)


def in_metres(way: Way, length: float) -> Way:
    """The way, with the unit of length of the weights given in metres."""
    return tuple(
        replace(leg, speed=leg.speed * length) if isinstance(leg, Steady) else replace(leg, length=length)
        for leg in way
    )


def _retraced(goal: Pose) -> Pose:
    """Where the controls of a way to `goal` lead in the opposite order of time."""
    cosine, sine = math.cos(goal.heading), math.sin(goal.heading)
    return Pose(cosine * goal.x + sine * goal.y, sine * goal.x - cosine * goal.y, goal.heading)


def _steady(goal: Pose) -> Way:
    """The way that is a straight line or a turn on the spot, where one is enough."""
    if math.hypot(goal.x, goal.y) < _SAME:
        return (Steady(0.0, goal.heading),)
    if abs(goal.y) < _SAME and abs(goal.heading) < _SAME:
        return (Steady(goal.x, 0.0),)
    return ()


def _cheapest(ways: Iterable[Way]) -> Way:
    best: Way = ()
    for way in ways:
        if not best or cost_of_way(way, Weights()) < cost_of_way(best, Weights()) - _SAME:
            best = way
    return best


# ----------------------------------------------------------------------------------------------- by the start


def _shot(goal: Pose, flight: Flight, starts: int) -> Iterator[Way]:
    """The ways of `flight` that end at `goal`, over its three unknowns at the start."""

    def miss(start: Array, share: float) -> Array:
        end = end_of_way(flight(*start.tolist()))
        return np.array([end.x - share * goal.x, end.y - share * goal.y, end.heading - goal.heading])

    distance = math.hypot(goal.x, goal.y)
    nearest = min(1.0, _NEAR / distance)
    start = _from_spot(Pose(nearest * goal.x, nearest * goal.y, goal.heading))
    # From a goal near by, where the way is all but a turn on the spot, to the goal itself.
    for share in np.geomspace(nearest, 1.0, 2 + math.ceil(math.log(1 / nearest) / _STRIDE)).tolist():
        found = root(miss, start, args=(share,), tol=1e-13)
        start = found.x
    if np.abs(found.fun).max() < _SAME:
        yield flight(*start.tolist())
    spread = np.array([distance + 1, distance + 1, abs(goal.heading) + 2])
    # The seed is part of the method: equal goals always get equal ways.
    for draw in np.random.default_rng(0).normal(size=(starts, 3)):
        found = root(miss, np.array([goal.x, goal.y, goal.heading]) + draw * spread, args=(1.0,), tol=1e-13)
        if np.abs(found.fun).max() < _SAME:
            yield flight(*found.x.tolist())


def _from_spot(goal: Pose) -> Array:
    """The start of the extremal to a goal very near by: there the heading grows evenly."""
    angle = np.linspace(0.0, goal.heading, 65)
    cosine, sine = np.cos(angle), np.sin(angle)
    moments = np.array([[cosine @ cosine, cosine @ sine], [cosine @ sine, sine @ sine]]) / len(angle)
    momentum = np.linalg.lstsq(moments, np.array([goal.x, goal.y]), rcond=1e-3)[0]
    return np.array([momentum[0], momentum[1], goal.heading])


def _free_flight(speed: float, across: float, turn_rate: float) -> Way:
    return (extremal(speed, across, turn_rate, length=1.0),)


def _forward_flight(speed: float, across: float, turn_rate: float) -> Way:
    """Arcs while p cos(th - b) is positive, turns on the spot while it is not."""
    momentum = math.hypot(speed, across)
    pace = math.hypot(max(speed, 0.0), turn_rate)
    sense = 1 if turn_rate > 0 else -1
    way: list[Leg] = []
    left = 1.0
    while left > 0 and len(way) < _MOST_STRETCHES:
        if speed <= 0:
            turn = _turn_until_ahead(speed, across, sense)
            way.append(Steady(0.0, sense * pace, min(left, turn / pace) if pace > 0 else left))
            speed, across, turn_rate = 0.0, sense * momentum, sense * pace
        else:
            leg = extremal(speed, across, turn_rate, length=1.0, duration=left)
            leg = replace(leg, duration=min(left, _until_still(leg)))
            way.append(leg)
            sense = 1 if float(leg.course(np.asarray(leg.duration)).w) > 0 else -1
            speed, across = 0.0, -sense * momentum
        left -= way[-1].duration
    return tuple(way)


def _turn_until_ahead(speed: float, across: float, sense: int) -> float:
    """How far to turn until the momentum has a part ahead again, in radians."""
    return (sense * math.atan2(across, speed) - math.pi / 2) % (2 * math.pi)


def _until_still(leg: Leg) -> float:
    """When the speed next vanishes, in seconds."""
    match leg:
        case Steady():
            return math.inf
        case Rotating() | Oscillating():
            half_period = 2 * leg.modulus.quarter_period
            passed = math.floor(leg.phase / half_period + 1e-9)
            return ((passed + 1) * half_period - leg.phase) / leg.pace


# ---------------------------------------------------------------------------------------- by the two headings


def _turning_one_way(goal: Pose) -> Iterator[Way]:
    """The rotating extremals to `goal`, over the phase at the start and the modulus."""
    if abs(goal.heading) < _SAME:
        return
    side = goal if goal.heading > 0 else goal.mirrored
    distance = math.hypot(side.x, side.y)
    upright = math.pi / 2 - math.atan2(side.y, side.x)
    for angle in (upright, upright + math.pi):
        for guess in (-2.0, 1.0, distance):
            found = root(_one_way_miss, np.array([angle, guess]), args=(side,), tol=1e-13)
            if np.abs(found.fun).max() < _SAME:
                start, steepness = found.x.tolist()
                leg = _one_way(start, steepness, side.heading)
                yield (leg if side is goal else leg.mirrored,)


def _one_way_miss(unknown: Array, goal: Pose) -> Array:
    angle, steepness = unknown.tolist()
    end = end_of(_one_way(angle, steepness, goal.heading))
    return np.array([end.x - goal.x, end.y - goal.y])


def _one_way(angle: float, steepness: float, turn: float) -> Rotating:
    """The extremal from the amplitude `angle` that turns by `turn`; `steepness` is log m / (1 - m)."""
    # Beyond these bounds a float knows no further modulus.
    steepness = min(max(steepness, -300.0), 600.0)
    modulus = Modulus(1 / math.sqrt(1 + math.exp(-steepness)), 1 / (1 + math.exp(steepness)))
    phase = modulus.argument(angle)
    return Rotating(1.0, modulus, phase, modulus.argument(angle + turn) - phase, 1)
