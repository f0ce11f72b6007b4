"""Timed paths on a workspace: whether the robot can go so, in that time, and see what it is said to see.

This is the half of the check of a plan that concerns the map. It shares nothing with the search. Steps are
counted from 0, as in a plan's JSON.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from mitlplan.plan import Loop, Step
from mitlplan.workspace.workspace import Workspace


def follows(workspace: Workspace, start: int, steps: Sequence[Step], loop: Loop | None = None) -> str | None:
    """Whether the robot can move as `steps` say, and what is wrong if it cannot.

    Parameters
    ----------
    workspace
        Where the robot moves.
    start
        The index of the cell in which it starts.
    steps
        The stays, in order.
    loop
        How it goes on after the last one; ``None`` if the plan ends there.

    Returns
    -------
    str or None
        A sentence on the first fault, or ``None`` if there is none.

    Examples
    --------
    >>> from mitlplan.workspace.grid import grid
    >>> workspace = grid(1, 3)
    >>> one = Step("r0c0", Fraction(0), Fraction(1))
    >>> follows(workspace, 0, [one, Step("r0c1", Fraction(1), Fraction(1))])
    >>> follows(workspace, 0, [one, Step("r0c2", Fraction(1), Fraction(1))])
    'steps[0] (r0c0): no move leads from r0c0 to r0c2'
    """
    return next(_faults(workspace, start, steps, loop), None)


def ending(steps: Sequence[Step]) -> Fraction:
    """The makespan that `steps` have: the end of the last stay, or the arrival where it lasts for ever.

    Examples
    --------
    >>> ending([Step("r0c0", Fraction(2), None)])
    Fraction(2, 1)
    """
    last = steps[-1]
    return last.enter if last.leave is None else last.leave


_NO_CELL = -1


@dataclass(frozen=True, slots=True)
class _Way:
    """A path, its cells by their indices, and for each step the moves that lead to the next one."""

    workspace: Workspace
    steps: Sequence[Step]
    cells: Sequence[int]
    moves: Sequence[range]

    @classmethod
    def of(cls, workspace: Workspace, steps: Sequence[Step]) -> _Way:
        indices = (workspace.index_of(step.cell) for step in steps)
        cells = [_NO_CELL if index is None else index for index in indices]
        return cls(workspace, steps, cells, workspace.moves_along(cells))


def _faults(workspace: Workspace, start: int, steps: Sequence[Step], loop: Loop | None) -> Iterator[str]:
    if not steps:
        yield "there is no step; a plan begins with a stay in the start cell"
        return
    way = _Way.of(workspace, steps)
    for place, step in enumerate(steps):
        for fault in _wrong_step(way, start, place, loop):
            yield f"steps[{place}] ({step.cell}): {fault}"


def _wrong_step(way: _Way, start: int, place: int, loop: Loop | None) -> Iterator[str]:
    steps = way.steps
    if place == 0:
        yield from _wrong_start(way.workspace, start, steps[0])
    yield from _wrong_label(way, place)
    if place < len(steps) - 1:
        yield from _wrong_move(way, place)
    else:
        yield from _wrong_end(way, loop)


def _wrong_start(workspace: Workspace, start: int, first: Step) -> Iterator[str]:
    if first.cell != workspace.names[start]:
        yield f"the plan begins here, the robot in {workspace.names[start]}"
    if first.enter != 0:
        yield f"the plan begins at {first.enter}, not at 0"


def _wrong_label(way: _Way, place: int) -> Iterator[str]:
    step = way.steps[place]
    if way.cells[place] == _NO_CELL:
        yield f"no cell is called {step.cell}; {way.workspace.advise(step.cell)}"
        return
    holds = way.workspace.holds(way.cells[place])
    if frozenset(step.holds) != holds:
        yield f"the plan says that {_listed(step.holds)} holds there, the map {_listed(sorted(holds))}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "nothing"


def _wrong_move(way: _Way, place: int) -> Iterator[str]:
    step, following = way.steps[place], way.steps[place + 1]
    if step.leave is None:
        yield "only the last stay of a plan may be without an end"
        return
    if following.enter != step.leave:
        yield f"the robot leaves at {step.leave}, but enters {following.cell} at {following.enter}"
    yield from _wrong_departure(way.workspace, step, step.leave, following.cell, way.moves[place])


def _wrong_departure(
    workspace: Workspace, step: Step, leave: Fraction, target: str, moves: range
) -> Iterator[str]:
    stay = leave - step.enter
    if stay <= 0:
        yield f"the robot enters at {step.enter} and leaves at {leave}; a stay takes time"
        return
    if not moves:
        yield f"no move leads from {step.cell} to {target}"
    elif not any(_in_time(workspace, move, stay) for move in moves):
        allowed = " or ".join(dict.fromkeys(_shown(workspace, move) for move in moves))
        yield f"the move to {target} after a stay of {stay} is not allowed; it takes {allowed}"


def _in_time(workspace: Workspace, move: int, stay: Fraction) -> bool:
    most = workspace.most_time(move)
    return workspace.least_time(move) <= stay and (workspace.waiting or most is None or stay <= most)


def _shown(workspace: Workspace, move: int) -> str:
    least, most = workspace.least_time(move), workspace.most_time(move)
    if workspace.waiting or most is None:
        return f"at least {least}" if least > 0 else "any time above 0"
    return f"exactly {least}" if least == most else f"{least} to {most}"


def _wrong_end(way: _Way, loop: Loop | None) -> Iterator[str]:
    last = way.steps[-1]
    match loop:
        case None:
            yield from _wrong_stop(way)
        case Loop(first, None):
            if first != len(way.steps) - 1:
                place = len(way.steps) - 1
                yield f"the robot parks in its last cell, so the loop starts at {place}, not {first}"
            if last.leave is not None:
                yield f"the robot parks here, so it leaves never, not at {last.leave}"
            if not way.workspace.waiting:
                yield "the robot parks here, where the map allows no waiting"
        case Loop(first, Fraction() as period):
            yield from _wrong_return(way, first, period)


def _wrong_stop(way: _Way) -> Iterator[str]:
    """A plan may end during a stay, but no stay is longer than what some move out of the cell allows."""
    workspace, last = way.workspace, way.steps[-1]
    if last.leave is None:
        yield "the plan ends here, so the last stay ends with it"
        return
    stay = last.leave - last.enter
    if stay < 0:
        yield f"the robot enters at {last.enter} and the plan ends before, at {last.leave}"
    if workspace.waiting or way.cells[-1] == _NO_CELL:
        return
    longest = [workspace.most_time(move) for move in workspace.moves_from(way.cells[-1])]
    bounds = [most for most in longest if most is not None]
    if len(bounds) == len(longest) and stay > max(bounds, default=Fraction(0)):
        limit = max(bounds, default=Fraction(0))
        yield f"the robot stays for {stay}, where the map allows no waiting beyond {limit}"


def _wrong_return(way: _Way, first: int, period: Fraction) -> Iterator[str]:
    steps, last = way.steps, way.steps[-1]
    if not 0 <= first < len(steps):
        yield f"the loop goes on at steps[{first}], but the last is steps[{len(steps) - 1}]"
        return
    if last.leave is None:
        yield "the plan loops, so the last stay has an end"
        return
    if last.leave - steps[first].enter != period:
        yield f"one round of the loop takes {last.leave - steps[first].enter}, not the period {period}"
    moves = way.workspace.moves_along([way.cells[-1], way.cells[first]])[0]
    yield from _wrong_departure(way.workspace, last, last.leave, steps[first].cell, moves)
