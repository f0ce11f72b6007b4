"""Map and formula become one network."""

from __future__ import annotations

from typing import Literal as Choice
from typing import TypeAlias

from mitlplan.automata.transducer import Network
from mitlplan.logic.core import Core, conjunction, holds
from mitlplan.logic.normalize import normalize
from mitlplan.mission import Mission
from mitlplan.translation.compact.translate import translate as translate_compact
from mitlplan.translation.seed.repaired import translate as translate_seed
from mitlplan.workspace.abstract import abstract
from mitlplan.workspace.workspace import Workspace

Construction: TypeAlias = Choice["compact", "seed"]


def core_of(mission: Mission) -> Core:
    """All requirements of a mission as one formula in normal form."""
    return conjunction(
        *(normalize(each.formula, mission.until, horizon=mission.horizon) for each in mission.spec)
    )


def compose(
    workspace: Workspace,
    starts: tuple[int, ...],
    core: Core,
    *,
    horizon: Choice["infinite", "finite"] = "infinite",
    construction: Construction = "compact",
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
    construction
        How the formula becomes transducers; ``"seed"`` is the repaired construction of the paper.

    Raises
    ------
    TranslationError
        If the construction cannot express the formula.

    Examples
    --------
    >>> from mitlplan.logic.core import Literal, eventually
    >>> from mitlplan.workspace import grid
    >>> network = compose(grid(2, 2, regions={"A": [(1, 0)]}), (0,), eventually(Literal("A")))
    >>> [transducer.name for transducer in network.transducers]
    ['start', 'F A']
    """
    translate = translate_compact if construction == "compact" else translate_seed
    obligations = translate(core, until_the_end=horizon == "finite")
    predicates = {
        name: frozenset(index for index, label in enumerate(workspace.label_sets) if holds(predicate, label))
        for name, predicate in obligations.predicates.items()
    }
    return Network(abstract(workspace, *starts), obligations.transducers, predicates)
