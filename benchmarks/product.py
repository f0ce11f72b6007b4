"""Missions by hand: cells times the progress of the formula, as somebody would write them for one mission.

A hand-made product is the limit for a planner that knows the mission only as a formula: whoever writes it has
done by thinking what translation and search do. Progress is a deterministic automaton over the labels of the
cells entered, one step a move, all moves taking equally long; where a deadline needs it, its state counts
moves. The product is a sparse matrix, ready for any search of shortest paths; the length of a path is the
time of the plan. Nothing here is shared with the planner but the arrays of the workspace.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from mitlplan.workspace import Workspace

DEAD = "dead"
DONE = "done"
State: TypeAlias = Hashable
Label: TypeAlias = frozenset[str]
Advance: TypeAlias = Callable[[State, Label], State]
"""From a state and the label of the cell entered to the next state, ``DEAD`` or ``DONE``."""

MOST_EDGES = 16_000_000
"""Larger products are not built: they would take gigabytes."""


class TooLargeError(Exception):
    """The product would have more than :data:`MOST_EDGES` edges."""


@dataclass(frozen=True, eq=False)
class Progress:
    """A deterministic automaton over labels, as a table.

    Parameters
    ----------
    states
        The states, the first one being the one before anything was seen.
    table
        int32, shape (states, labels): the state behind, or -1 where the mission is violated.
    """

    states: tuple[State, ...]
    table: NDArray[np.int32]


def explore(
    initial: State, advance: Advance, labels: tuple[Label, ...], *, most: int = 2_000_000
) -> Progress:
    """The automaton of all states that can be reached from `initial`.

    Raises
    ------
    TooLargeError
        If there are more than `most`.

    Examples
    --------
    >>> labels = (frozenset(), frozenset("A"))
    >>> once = explore("before", lambda state, label: DONE if "A" in label else state, labels)
    >>> once.states, once.table.tolist()
    (('before', 'done'), [[0, 1], [-1, -1]])
    """
    number: dict[State, int] = {initial: 0}
    waiting = [initial]
    rows: list[list[int]] = []
    for state in waiting:
        row = []
        for label in labels:
            following = DEAD if state == DONE else advance(state, label)
            if following != DEAD and following not in number:
                number[following] = len(number)
                waiting.append(following)
            row.append(-1 if following == DEAD else number[following])
        rows.append(row)
        if len(number) > most:
            raise TooLargeError
    return Progress(tuple(number), np.array(rows, dtype=np.int32))


Path: TypeAlias = NDArray[np.int64]
"""The nodes of a path."""

Finish: TypeAlias = Callable[[int, Callable[[], Path]], "int | None"]
"""From the moves of a shortest path, and the path if asked for, to those of the plan; ``None``: too late."""


def as_it_is(moves: int, path: Callable[[], Path]) -> int:
    """The plan is the path."""
    del path
    return moves


@dataclass(frozen=True, eq=False)
class Product:
    """Cells times progress; node ``state * cells + cell``.

    Parameters
    ----------
    graph
        Shape (nodes, nodes): a 1 for each move.
    start
        The node of the start, or ``None`` if the mission is violated there.
    goals
        The nodes in which the mission is accomplished.
    tick
        The seconds of a move.
    finish
        What a shortest path to a goal says about the plan.
    """

    graph: csr_array[np.float64]
    start: int | None
    goals: NDArray[np.int64]
    tick: Fraction
    finish: Finish

    @property
    def nodes(self) -> int:
        """The number of nodes."""
        return int(self.graph.shape[0])


Recipe: TypeAlias = tuple[State, Advance]


def build(workspace: Workspace, start: int, recipe: Recipe, finish: Finish = as_it_is) -> Product:
    """The product of a workspace, in which all moves take equally long, and the progress of a mission.

    Raises
    ------
    TooLargeError
        If it would not fit.
    """
    if len({*workspace.least.tolist()}) > 1:
        raise ValueError("moves of different lengths need more than a counter")
    cells, moves = workspace.cell_count, workspace.move_count
    labels = tuple(workspace.label_sets)
    progress = explore(*recipe, labels, most=MOST_EDGES // max(1, moves) + 1)
    states = len(progress.states)
    if states * moves > MOST_EDGES:
        raise TooLargeError
    behind = progress.table[:, workspace.label_of[workspace.target]]
    state, move = np.nonzero(behind >= 0)
    target = behind[state, move].astype(np.int64) * cells + workspace.target[move]
    leaving = np.bincount(state * cells + workspace.source[move], minlength=states * cells)
    graph = csr_array(
        (np.ones(len(target)), target, np.append(0, np.cumsum(leaving))), shape=(states * cells,) * 2
    )
    first = int(progress.table[0, workspace.label_of[start]])
    done = progress.states.index(DONE) if DONE in progress.states else None
    goals = np.zeros(0, dtype=np.int64) if done is None else done * cells + np.arange(cells)
    tick = workspace.least_time(0)
    return Product(graph, None if first < 0 else first * cells + start, goals, tick, finish)


# ------------------------------------------------------------------------------ the missions' progress


def visit(*goals: str, within: int | None = None) -> tuple[Recipe, Finish]:
    """``F[0,within] g`` for each goal; a deadline that all share needs no counter: earlier is never worse."""

    def advance(state: State, label: Label) -> State:
        assert isinstance(state, frozenset)
        return state - label or DONE

    def finish(moves: int, path: Callable[[], Path]) -> int | None:
        del path
        return moves if within is None or moves <= within else None

    return (frozenset(goals), advance), finish


def ordered(first: str = "B", then: str = "A") -> tuple[Recipe, Finish]:
    """``(!then U first) & F then``."""

    def advance(state: State, label: Label) -> State:
        seen = state == "seen" or first in label
        if then in label:
            return DONE if seen else DEAD
        return "seen" if seen else "unseen"

    return ("unseen", advance), as_it_is


def windows_by_counting(late: str, window: tuple[int, int], early: str, within: int) -> tuple[Recipe, Finish]:
    """``F[window] late & F[0,within] early``, counting the moves up to the window."""

    def advance(state: State, label: Label) -> State:
        assert isinstance(state, tuple)
        seen, moves = state[0] or early in label, state[1] + 1
        if not seen and moves > within:
            return DEAD
        if seen and late in label and moves >= window[0]:
            return DONE
        return seen, min(moves, max(window[0], 0 if seen else within))

    def finish(moves: int, path: Callable[[], Path]) -> int | None:
        del path
        return moves if moves <= window[1] else None

    return ((False, -1), advance), finish


def windows_by_parity(late: str, window: tuple[int, int], early: str) -> tuple[Recipe, Finish]:
    """The same where every move can be undone: whoever comes too early makes a move and takes it back.

    On a grid without diagonals the parity of a visit is that of the cell, so no counter is needed at all, if
    `early` and `late` are a single cell each and whoever writes this knows that `early` is reached in time.
    """

    def advance(state: State, label: Label) -> State:
        seen = state == "seen" or early in label
        if seen and late in label:
            return DONE
        return "seen" if seen else "unseen"

    def finish(moves: int, path: Callable[[], Path]) -> int | None:
        del path
        moves += max(0, window[0] - moves + 1) // 2 * 2
        return moves if moves <= window[1] else None

    return ("unseen", advance), finish


def fetch(
    goods: str,
    bay: str,
    *,
    cells: int,
    avoid: str | None = None,
    by: tuple[int | None, int | None],
    within: int,
) -> tuple[Recipe, Finish]:
    """First `goods`, then `bay`, each `by` a time, at most `within` after the goods; nowhere `avoid`.

    No counter: among the ways to a cell behind the goods, the one with the least time also has the youngest
    goods, since every way begins where the goods are (a single cell) and earlier is never worse.
    """

    def advance(state: State, label: Label) -> State:
        if avoid is not None and avoid in label:
            return DEAD
        if state == "first":
            if bay in label:
                return DEAD
            return "second" if goods in label else "first"
        return DONE if bay in label else "second"

    def finish(moves: int, path: Callable[[], Path]) -> int | None:
        # States are numbered in the order in which they are met: "first" has the first `cells` nodes.
        fetched = int(np.flatnonzero(path() >= cells)[0])
        limits = (by[0] is None or fetched <= by[0]) and (by[1] is None or moves <= by[1])
        return moves if limits and moves - fetched <= within else None

    return ("first", advance), finish


def respond(pairs: tuple[tuple[str, str], ...], within: int, goal: str) -> tuple[Recipe, Finish]:
    """``F goal & G(p -> F[0,within] q)`` for each pair, up to the end: the age of each demand is counted."""
    unmet = -1

    def advance(state: State, label: Label) -> State:
        assert isinstance(state, tuple)
        reached, ages = state[0] or goal in label, []
        for (asked, answered), age in zip(pairs, state[1], strict=True):
            older = age + 1 if age != unmet else (0 if asked in label else unmet)
            if older > within:
                return DEAD
            ages.append(unmet if answered in label else older)
        if reached and all(age == unmet for age in ages):
            return DONE
        return reached, tuple(ages)

    return ((False, (unmet,) * len(pairs)), advance), as_it_is
