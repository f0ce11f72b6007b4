"""The general workspace: named cells and the moves between them, one by one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from mitlplan.errors import WorkspaceError
from mitlplan.workspace.move_time import MoveTime, stay_bounds
from mitlplan.workspace.names import ListedNames, advise
from mitlplan.workspace.workspace import UNLIMITED, Workspace


@dataclass(frozen=True, slots=True)
class Move:
    """A move between two cells.

    Parameters
    ----------
    origin, target
        The names of the cells.
    time
        Seconds: exact, or ``[least, most]``; 0 is any positive stay.
    both
        Whether the way back is a move as well.
    """

    origin: str
    target: str
    time: MoveTime = 1
    both: bool = False


def graph(cells: Mapping[str, Sequence[str]], moves: Iterable[Move], *, waiting: bool = False) -> Workspace:
    """A workspace of named cells and moves.

    Parameters
    ----------
    cells
        For each cell the propositions that hold in it.
    moves
        The moves; the same move given twice counts once.
    waiting
        Whether the robot may stay in a cell longer than its next move needs.

    Raises
    ------
    WorkspaceError
        If there is no cell, a move leads from or to an unknown cell, or a time is no time.

    Examples
    --------
    >>> workspace = graph({"hall": [], "dock": ["A"]}, [Move("hall", "dock", "7/2", both=True)])
    >>> workspace.move_count, workspace.durations, sorted(workspace.holds(1))
    (2, (Fraction(7, 2),), ['A'])
    """
    names = ListedNames(tuple(cells))
    labels = [frozenset(holds) for holds in cells.values()]
    label_index = {label: index for index, label in enumerate(dict.fromkeys(labels))}
    directed = sorted(set(_directed(moves, names)), key=_order)
    ends = {end for _, _, bounds in directed for end in bounds if end is not None}
    durations = tuple(sorted(ends))
    time_index: dict[Fraction | None, int] = {time: index for index, time in enumerate(durations)}
    time_index[None] = UNLIMITED
    return Workspace(
        names=names,
        label_sets=tuple(label_index),
        label_of=np.array([label_index[label] for label in labels], dtype=np.int32),
        source=np.array([origin for origin, _, _ in directed], dtype=np.int32),
        target=np.array([target for _, target, _ in directed], dtype=np.int32),
        durations=durations,
        least=np.array([time_index[least] for _, _, (least, _) in directed], dtype=np.int32),
        most=np.array([time_index[most] for _, _, (_, most) in directed], dtype=np.int32),
        waiting=waiting,
    )


_Directed = tuple[int, int, tuple[Fraction, Fraction | None]]


def _directed(moves: Iterable[Move], names: ListedNames) -> Iterable[_Directed]:
    for place, move in enumerate(moves):
        origin = _cell(move.origin, names, ("moves", place, "from"))
        target = _cell(move.target, names, ("moves", place, "to"))
        try:
            bounds = stay_bounds(move.time)
        except WorkspaceError as error:
            raise WorkspaceError(str(error), where=("moves", place, "time")) from None
        yield origin, target, bounds
        if move.both:
            yield target, origin, bounds


def _cell(name: str, names: ListedNames, where: tuple[str | int, ...]) -> int:
    index = names.find(name)
    if index is None:
        raise WorkspaceError(f"no cell is called {name}; {advise(name, names, 'cells')}", where=where)
    return index


def _order(move: _Directed) -> tuple[int, int, Fraction, bool, Fraction]:
    origin, target, (least, most) = move
    return origin, target, least, most is None, most or Fraction(0)
