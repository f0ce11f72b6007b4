"""A mission as a network of timed automata, by any of the constructions: to be exported and drawn.

The compact and the repaired construction become transducers in lock step with the map
(:mod:`mitlplan.automata.lockstep`); the published one is its own product
(:mod:`mitlplan.translation.seed.published_network`), unsound and marked so.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from mitlplan import compose
from mitlplan.automata import transducer
from mitlplan.automata.lockstep import lockstep
from mitlplan.automata.timed_automaton import Network, Query
from mitlplan.logic.formula import And, Formula
from mitlplan.logic.normalize import accomplishable
from mitlplan.logic.show import show
from mitlplan.mission import Mission
from mitlplan.translation.seed.published_network import published_model
from mitlplan.translation.seed.published_thaw import without_stopped_clocks
from mitlplan.workspace.abstract import abstract

Construction: TypeAlias = Literal["compact", "seed", "published"]


@dataclass(frozen=True, slots=True)
class MissionModel:
    """A network that asks what the mission asks.

    Parameters
    ----------
    network, query
        The first automaton is the robot, and the query is reachable if there is a finite or a parking plan.
    cells
        For each location of the robot's automaton the cell, or ``None``.
    layers
        For each of them a number, different for locations of the same cell: for drawings.
    notes
        Sentences on what the model is.
    """

    network: Network
    query: Query
    cells: tuple[int | None, ...]
    layers: tuple[int, ...]
    notes: tuple[str, ...]


def model_of_mission(
    mission: Mission, construction: Construction = "compact", *, stopped_clocks: bool = True
) -> MissionModel:
    """The network of `mission`.

    Parameters
    ----------
    construction
        How the formula becomes automata.
    stopped_clocks
        Whether clocks may be stopped, as those of the published construction are; without, it is a larger
        network with the same runs.

    Raises
    ------
    TranslationError
        If that construction cannot express the formula.

    Examples
    --------
    >>> from mitlplan.mission import mission_from_mapping
    >>> mission = mission_from_mapping({
    ...     "mitlplan": 1,
    ...     "workspace": {"grid": {"rows": 2, "columns": 2, "regions": {"A": [[1, 0]], "B": [[0, 1]]}}},
    ...     "robot": {"start": "r0c0"},
    ...     "spec": "(!A U B) & F A",
    ... })
    >>> [automaton.name for automaton in model_of_mission(mission, "published").network.automata]
    ['sys']
    """
    if construction == "published":
        return _published(mission, stopped_clocks=stopped_clocks)
    return _in_lockstep(mission, construction)


def formula_of(mission: Mission) -> Formula:
    """All requirements as one formula, as they were written."""
    formulas = tuple(requirement.formula for requirement in mission.spec)
    return formulas[0] if len(formulas) == 1 else And(formulas)


def lockstep_of(mission: Mission, construction: compose.Construction) -> transducer.Network:
    """The map automaton and the transducers that watch it."""
    core, horizon = compose.core_of(mission), mission.horizon
    return compose.compose(
        mission.workspace, (mission.start,), core, horizon=horizon, construction=construction
    )


def _in_lockstep(mission: Mission, construction: Literal["compact", "seed"]) -> MissionModel:
    accomplished = all(accomplishable(requirement.formula) for requirement in mission.spec)
    parkings = mission.horizon == "infinite" and not accomplished
    model = lockstep(lockstep_of(mission, construction), list(mission.workspace.names), parkings=parkings)
    count = mission.workspace.cell_count
    return MissionModel(
        network=model.network,
        query=model.query,
        cells=model.cells,
        layers=tuple(index // count for index in range(len(model.cells))),
        notes=(
            f"{show(formula_of(mission))}, by the {construction} construction.",
            "Plans that end or park are found; plans that go round for ever are not sought here.",
            *model.meanings,
        ),
    )


def _published(mission: Mission, *, stopped_clocks: bool) -> MissionModel:
    workspace = mission.workspace
    model = published_model(
        formula_of(mission), abstract(workspace, mission.start), names=list(workspace.names)
    )
    if not stopped_clocks:
        model = without_stopped_clocks(model)
    return MissionModel(
        network=model.network,
        query=model.query,
        cells=model.cells,
        layers=model.layers,
        notes=(
            f"{show(formula_of(mission))}, as published by Zhou, Maity and Baras.",
            "UNSOUND: what it finds may violate the formula, what it misses may satisfy it (docs/paper.md).",
        ),
    )
