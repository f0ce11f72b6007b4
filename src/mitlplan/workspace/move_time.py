"""The time a move takes, as it is given: an exact number, or the least and the most of a range."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from mitlplan.errors import WorkspaceError
from mitlplan.exact import Number, exact

MoveTime: TypeAlias = Number | Sequence[Number]
"""An exact number of seconds, or ``[least, most]``; 0 asks only for a positive stay."""


def stay_bounds(time: MoveTime) -> tuple[Fraction, Fraction | None]:
    """The least and the most time in a cell before a move; a most of ``None`` is unlimited.

    Raises
    ------
    WorkspaceError
        If the time is not a number or a range that some positive time lies in.

    Examples
    --------
    >>> stay_bounds(["1", "3/2"]), stay_bounds(0)
    ((Fraction(1, 1), Fraction(3, 2)), (Fraction(0, 1), None))
    """
    try:
        if isinstance(time, Sequence) and not isinstance(time, str):
            return _range(time)
        least = exact(time)
    except ValueError as error:
        raise WorkspaceError(f"the time of a move: {error}") from None
    return least, (least if least > 0 else None)


def _range(time: Sequence[Number]) -> tuple[Fraction, Fraction]:
    if len(time) != 2:
        raise WorkspaceError(f"a range of time is [least, most], two numbers, not {len(time)}")
    least, most = (exact(end) for end in time)
    if most < least:
        raise WorkspaceError(f"the range of time [{least}, {most}] has its least above its most; swap them")
    if most == 0:
        raise WorkspaceError("the range of time [0, 0] holds no positive time; write 0 for any positive stay")
    return least, most
