"""Whether a robot can go so: the moves of a plan held against the mission's own list of moves.

A second opinion on paths, from the text of a mission rather than from its workspace.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from mitlplan_fuzz.missions import SmallMission


def fault_in_path(
    mission: SmallMission, stays: Sequence[tuple[str, Fraction]], end: Fraction | None, loop: str | None
) -> str | None:
    """The first fault, or ``None``.

    `stays` gives the cells and their times of entry; `end` is when the plan ends, ``None`` if it parks;
    `loop` is the cell that is entered at `end`, ``None`` if the plan is finite.
    """
    if not stays or stays[0] != (mission.start, Fraction(0)):
        return "the plan does not begin at the start, at time 0"
    hops = [(*here, *there) for here, there in pairwise(stays)]
    last, entered = stays[-1]
    if loop is not None and end is not None:
        hops.append((last, entered, loop, end))
    for origin, since, target, until in hops:
        if not _move_exists(mission, origin, target, until - since):
            return f"no move from {origin} to {target} in {until - since}"
    if loop is None and end is None and not mission.waiting:
        return "the plan parks where nobody may wait"
    if loop is None and end is not None and not _stay_is_possible(mission, last, end - entered):
        return f"the robot cannot still be in {last} after {end - entered}"
    return None


def _move_exists(mission: SmallMission, origin: str, target: str, stay: Fraction) -> bool:
    return any(
        (origin, target) == (source, destination)
        and 0 < stay >= least
        and (mission.waiting or most is None or stay <= most)
        for source, destination, least, most in mission.moves
    )


def _stay_is_possible(mission: SmallMission, cell: str, stay: Fraction) -> bool:
    if stay == 0 or mission.waiting:
        return stay >= 0
    return stay > 0 and any(
        source == cell and (most is None or stay < most) for source, _, _, most in mission.moves
    )
