"""The three-point turn: back out through the edge one came in by, having reached the middle of the cell.

The cheapest way back to the edge is a turn on the spot, which never enters the cell. So the way is asked to
reach the line through the cell's centre, parallel to the edge. That takes two extremals: at the line the
momentum may jump across it, while the momentum along it, the turn rate and the rate of cost go on; so the
speed changes its sign there. (It changes once more on the first extremal: forwards, backwards, forwards.)
Four unknowns, the start and the moment at the line; they follow the depth of the line from where they are
known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from mitlplan.trajectory.boundary import Way, in_metres
from mitlplan.trajectory.leg import Leg, end_of, extremal
from mitlplan.trajectory.pose import ORIGIN, Pose

Array: TypeAlias = NDArray[np.float64]

# Speed, momentum across, turn rate and moment at depth 1/2, to four digits: where to begin to look.
_KNOWN_DEPTH = 0.5
_KNOWN_START = (1.6863, -0.5339, 3.0353, 0.7563)
_STEP = 1.15
_DEPTHS = (1e-3, 30.0)


@lru_cache(maxsize=1024)
def three_point(depth: float, length: float) -> tuple[Way, ...]:
    """To the line at `depth` ahead and back, turned by half a turn to the left; empty if none was found.

    Parameters
    ----------
    depth
        Metres from the edge to the line.
    length
        The unit of length of the weights, in metres.

    Examples
    --------
    >>> [round(leg.duration, 4) for way in three_point(0.5, length=1.0) for leg in way]
    [0.7563, 0.2437]
    """
    target = depth / length
    if not _DEPTHS[0] <= target <= _DEPTHS[1]:
        return ()
    unknown = np.array(_KNOWN_START)
    steps = max(1, math.ceil(abs(math.log(target / _KNOWN_DEPTH)) / math.log(_STEP)))
    for reached in np.geomspace(_KNOWN_DEPTH, target, steps + 1).tolist():
        found = root(_miss, unknown, args=(reached,), tol=1e-13)
        if np.abs(found.fun).max() > 1e-9:
            return ()
        unknown = found.x
    return tuple(in_metres((leg,), length) for leg in _legs(unknown.tolist()))


def _miss(unknown: Array, depth: float) -> Array:
    first, second = _legs(unknown.tolist())
    turning = end_of(first)
    end = turning.then(end_of(second))
    return np.array([turning.x - depth, end.x, end.y, end.heading - math.pi])


def _legs(unknown: Sequence[float]) -> tuple[Leg, Leg]:
    speed, across, turn_rate, moment = unknown
    first = extremal(speed, across, turn_rate, length=1.0, duration=moment)
    heading = end_of(first).heading
    # The momentum in the frame of the edge is (ahead, across); its part ahead jumps so that u changes its
    # sign.
    ahead = -speed - 2 * across * math.tan(heading)
    momentum = Pose(ahead, across, 0.0).seen_from(replace(ORIGIN, heading=heading))
    going_on = float(first.course(np.asarray(moment)).w)
    return first, extremal(momentum.x, momentum.y, going_on, length=1.0, duration=1 - moment)
