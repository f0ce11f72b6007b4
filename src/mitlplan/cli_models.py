"""The command `translate`: a mission as a network of timed automata for other tools."""

from __future__ import annotations

from enum import Enum
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

import typer

from mitlplan.cli_answers import deliver, errors_reported
from mitlplan.cli_options import (
    Construction,
    ConstructionOption,
    Horizon,
    MissionFile,
    Output,
    Until,
    exact_option,
    read_mission,
)

if TYPE_CHECKING:
    from mitlplan.automata.timed_automaton import Network
    from mitlplan.formats.layout import Layout
    from mitlplan.mission import Mission
    from mitlplan.models import MissionModel


class Format(str, Enum):
    """What a model is written as."""

    uppaal = "uppaal"
    tchecker = "tchecker"
    dot = "dot"
    json = "json"


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""

    @app.command("translate")
    def translate_command(
        mission: MissionFile,
        form: Annotated[Format, typer.Option("--to", help="What the model is written as.")] = Format.uppaal,
        construction: ConstructionOption = Construction.compact,
        output: Output = None,
        bound: Annotated[
            str | None,
            typer.Option(
                metavar="SECONDS", callback=exact_option, help="Only plans as fast as this (tchecker)."
            ),
        ] = None,
        until: Until = None,
        horizon: Horizon = None,
    ) -> None:
        """Write a mission as a network of timed automata, for UPPAAL, TChecker or Graphviz."""
        with errors_reported():
            read = read_mission(mission, until, horizon)
            latest = None if bound is None else Fraction(bound)
            deliver(translated(read, form, construction, bound=latest), output)


# -- what the commands do ------------------------------------------------------------------------------


def translated(
    mission: Mission, form: Format, construction: Construction, *, bound: Fraction | None = None
) -> str:
    """The text of the model of `mission`."""
    from mitlplan.formats.tchecker import write_tchecker
    from mitlplan.formats.uppaal import write_uppaal
    from mitlplan.models import model_of_mission

    model = model_of_mission(mission, construction.value, stopped_clocks=form is not Format.tchecker)
    match form:
        case Format.uppaal:
            layout = layout_of(mission, model)
            return write_uppaal(model.network, model.query, layout=layout, notes=model.notes)
        case Format.tchecker:
            return write_tchecker(_folded(mission, model), model.query, bound=bound, notes=model.notes)
        case Format.dot:
            from mitlplan.formats.dot import automaton_dot

            layout = layout_of(mission, model)
            drawn = [automaton_dot(each, points=layout.get(each.name)) for each in model.network.automata]
            return "\n".join(drawn)
        case Format.json:
            from mitlplan.formats.model_json import network_to_json

            return network_to_json(model.network, model.query)


def layout_of(mission: Mission, model: MissionModel) -> Layout:
    """The places of the robot's automaton: like the map."""
    from mitlplan.formats.layout import cell_points, copies_of_map

    robot = model.network.automata[0]
    return {robot.name: copies_of_map(model.cells, model.layers, cell_points(mission.workspace))}


def _folded(mission: Mission, model: MissionModel) -> Network:
    """On a grid, a location a row: TChecker loads large automata slowly."""
    from dataclasses import replace

    import numpy as np

    from mitlplan.automata.folding import fold_columns

    positions = mission.workspace.positions
    if positions is None:
        return model.network
    rows = np.unique(-positions[:, 1], return_inverse=True)[1]
    columns = np.unique(positions[:, 0], return_inverse=True)[1]
    coordinates = [None if cell is None else (int(rows[cell]), int(columns[cell])) for cell in model.cells]
    robot, *watchers = model.network.automata
    folded, column = fold_columns(robot, coordinates, "column")
    variables = (*model.network.variables, column)
    return replace(model.network, automata=(folded, *watchers), variables=variables)
