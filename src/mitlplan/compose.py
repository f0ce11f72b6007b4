"""Map and formula become one network."""

from __future__ import annotations

from typing import Literal as Choice

from mitlplan.automata.transducer import Network
from mitlplan.logic.core import Core, holds
from mitlplan.translation.compact.translate import translate
from mitlplan.workspace.abstract import abstract
from mitlplan.workspace.workspace import Workspace


def compose(
    workspace: Workspace,
    starts: tuple[int, ...],
    core: Core,
    *,
    horizon: Choice["infinite", "finite"] = "infinite",
) -> Network:
    """The map automaton, and the transducers of a formula that watch it.

    Parameters
    ----------
    starts
        The cells in which the robot may start.
    core
        The formula, in normal form.
    horizon
        ``"finite"``: what has no upper bound speaks of the time up to the end of the plan.

    Examples
    --------
    >>> from mitlplan.logic.core import Literal, eventually
    >>> from mitlplan.workspace import grid
    >>> network = compose(grid(2, 2, regions={"A": [(1, 0)]}), (0,), eventually(Literal("A")))
    >>> [transducer.name for transducer in network.transducers]
    ['start', 'F A']
    """
    obligations = translate(core, until_the_end=horizon == "finite")
    predicates = {
        name: frozenset(index for index, label in enumerate(workspace.label_sets) if holds(predicate, label))
        for name, predicate in obligations.predicates.items()
    }
    return Network(abstract(workspace, *starts), obligations.transducers, predicates)
