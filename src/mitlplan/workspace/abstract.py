"""From the workspace to the timed automaton of the paper's Fig. 1.

A location a cell, one clock z that every move resets, a guard ``z >= time`` on every move, and, where the
robot must not wait, an invariant that keeps it from staying longer than its longest move allows.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from mitlplan.automata.transducer import NEVER, MapAutomaton
from mitlplan.workspace.workspace import UNLIMITED, Workspace


def abstract(workspace: Workspace, *starts: int) -> MapAutomaton:
    """The map automaton of `workspace` for a robot that starts in one of the cells `starts`.

    Examples
    --------
    >>> from mitlplan.workspace import Move, graph
    >>> workspace = graph({"a": [], "b": ["B"]}, [Move("a", "b", Fraction(2))], waiting=False)
    >>> automaton = abstract(workspace, 0)
    >>> automaton.durations[automaton.invariant[0]]
    Fraction(2, 1)
    """
    durations = workspace.durations
    if workspace.waiting:
        most: NDArray[np.int32] = np.full(workspace.move_count, NEVER, dtype=np.int32)
        invariant: NDArray[np.int32] = np.full(workspace.cell_count, NEVER, dtype=np.int32)
    else:
        # Ranks make indices into the durations comparable, also where a move is unlimited.
        order = sorted(range(len(durations)), key=durations.__getitem__)
        rank = np.empty(len(durations) + 1, dtype=np.int64)
        rank[order] = np.arange(len(durations))
        rank[UNLIMITED] = len(durations)
        most = workspace.most.astype(np.int32)
        longest = np.full(workspace.cell_count, -1, dtype=np.int64)
        np.maximum.at(longest, workspace.source, rank[most])
        # A cell without a move cannot be stayed in at all.
        if 0 not in durations:
            durations = (*durations, Fraction(0))
        zero = durations.index(Fraction(0))
        by_rank = np.array([*order, NEVER, zero], dtype=np.int32)
        invariant = by_rank[longest]
    return MapAutomaton(
        initial=starts,
        label_sets=workspace.label_sets,
        label_of=workspace.label_of,
        source=workspace.source,
        target=workspace.target,
        durations=durations,
        least=workspace.least,
        most=most,
        invariant=invariant,
        may_park=workspace.waiting,
    )
