"""The workspace in which anything may happen at any time: a cell for each label, every stay positive.

A formula has a run on it if and only if some right-continuous signal satisfies the formula.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from mitlplan.workspace.workspace import UNLIMITED, Workspace


def universal(labels: Sequence[frozenset[str]]) -> Workspace:
    """A cell for each of `labels`, and moves between any two of them after any positive time.

    Examples
    --------
    >>> universal([frozenset(), frozenset({"A"})]).move_count
    2
    """
    count = len(labels)
    source, target = np.nonzero(~np.eye(count, dtype=bool))
    moves = len(source)
    return Workspace(
        names=tuple(" ".join(sorted(label)) or "nothing" for label in labels),
        label_sets=tuple(labels),
        label_of=np.arange(count, dtype=np.int32),
        source=source.astype(np.int32),
        target=target.astype(np.int32),
        durations=(Fraction(0),),
        least=np.zeros(moves, dtype=np.int32),
        most=np.full(moves, UNLIMITED, dtype=np.int32),
        waiting=True,
    )
