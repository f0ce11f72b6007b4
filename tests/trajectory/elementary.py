"""The elementary motions, each with the same task for collocation: the goals, and what is asked on the way.

The names are those of the table in docs/trajectory.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mitlplan.trajectory.leg import EQUAL_WEIGHTS
from mitlplan.trajectory.motion import Motion, Style, passing, straight, turn_left, turn_right, u_turn
from mitlplan.trajectory.pose import ORIGIN, Pose
from tests.trajectory.oracles import Goal, collocated

TURN, BACK = math.pi / 2, math.pi
CENTRE = 0.5
"""How far ahead the centre of the unit cell is."""


@dataclass(frozen=True)
class Elementary:
    """A motion in one second, and how collocation finds its cost.

    `times` is by how much the cost that is collocated must be multiplied: of a way that is the same forth and
    back one half will do.
    """

    name: str
    motion: Motion | None
    goals: tuple[Goal, ...]
    times: float = 1.0
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def cost(self) -> float:
        assert self.motion is not None, self.name
        return self.motion.cost

    def collocated(self) -> float:
        return self.times * collocated(self.goals, **self.options)


def _start(heading: float) -> Motion | None:
    """From the centre, facing so, to the middle of the edge ahead."""
    begin = Pose(0.0, 0.0, heading)
    goal, centre = (Pose(x, 0.0, 0.0).seen_from(begin) for x in (CENTRE, 0.0))
    return passing(goal, centre, EQUAL_WEIGHTS, Style.FREE)


def _seen(heading: float) -> Goal:
    goal = Pose(CENTRE, 0.0, 0.0).seen_from(Pose(0.0, 0.0, heading))
    return goal.x, goal.y, goal.heading


EQUAL = EQUAL_WEIGHTS
FORWARD: dict[str, Any] = {"forward": True}
ELEMENTARY = (
    Elementary("forward", straight(1.0, EQUAL), ((1.0, 0.0, 0.0),)),
    Elementary("start, facing the way out", straight(CENTRE, EQUAL), ((CENTRE, 0.0, 0.0),)),
    Elementary("start, facing 0.7 rad aside", _start(0.7), (_seen(0.7),)),
    Elementary("start, facing a quarter turn aside", _start(TURN), (_seen(TURN),)),
    Elementary("stop at the centre", straight(CENTRE, EQUAL), ((CENTRE, 0.0, None),)),
    Elementary("left turn", turn_left(CENTRE, CENTRE, EQUAL), ((CENTRE, CENTRE, TURN),)),
    Elementary("right turn", turn_right(CENTRE, CENTRE, EQUAL), ((CENTRE, -CENTRE, -TURN),)),
    Elementary(
        "quarter turn, `forward-only`",
        turn_left(CENTRE, CENTRE, EQUAL, Style.FORWARD_ONLY),
        ((CENTRE, CENTRE, TURN),),
        options=FORWARD,
    ),
    Elementary(
        "quarter turn, `arc` (the paper's circle)",
        turn_left(CENTRE, CENTRE, EQUAL, Style.ARC),
        ((CENTRE, CENTRE, TURN),),
        options={"circles": (CENTRE,)},
    ),
    Elementary(
        "quarter turn, `spot`",
        turn_left(CENTRE, CENTRE, EQUAL, Style.SPOT),
        ((CENTRE, 0.0, 0.0), (CENTRE, 0.0, TURN), (CENTRE, CENTRE, TURN)),
    ),
    Elementary(
        "U-turn, `three-point`",
        u_turn(CENTRE, EQUAL, Style.THREE_POINT),
        ((CENTRE, None, None), (0.0, 0.0, BACK)),
    ),
    Elementary(
        "U-turn, `forward-only`",
        u_turn(CENTRE, EQUAL, Style.FORWARD_ONLY),
        # To the centre, and then a quarter turn there: the kink at u = 0 is where the phases meet. Back again
        # is the same, and twice the way in the same second is four times the cost.
        ((CENTRE, 0.0, None), (CENTRE, 0.0, TURN)),
        times=4.0,
        options={"forward": True, "elements": 40},
    ),
    Elementary(
        "U-turn, `spot`",
        u_turn(CENTRE, EQUAL, Style.SPOT),
        ((CENTRE, 0.0, 0.0), (CENTRE, 0.0, BACK), (0.0, 0.0, BACK)),
    ),
    Elementary(
        "in and out again, backwards",
        passing(ORIGIN, Pose(CENTRE, 0.0, 0.0), EQUAL, Style.SPOT),
        ((CENTRE, 0.0, None), (0.0, 0.0, 0.0)),
    ),
)


def through_the_centre() -> float:
    """What a U-turn costs at least that reaches the centre itself, and not only the line through it."""
    return min(collocated([(CENTRE, 0.0, None), (0.0, 0.0, BACK)], seed=seed) for seed in range(4))
