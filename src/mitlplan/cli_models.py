"""The commands `translate` and `automaton`: a mission as a model for other tools, and as a picture.

Both make the network of the mission by one of the constructions (:mod:`mitlplan.models`); they differ in what
they write. `automaton --figure` draws the figures of Zhou, Maity and Baras from the code's own automata.
"""

from __future__ import annotations

from enum import Enum
from fractions import Fraction
from pathlib import Path
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
    read_mission,
)

if TYPE_CHECKING:
    from mitlplan.automata.timed_automaton import Automaton, Network
    from mitlplan.formats.layout import Layout
    from mitlplan.mission import Mission
    from mitlplan.models import MissionModel


class Format(str, Enum):
    """What a model is written as."""

    uppaal = "uppaal"
    tchecker = "tchecker"
    dot = "dot"
    json = "json"


def _bound_option(text: str | None) -> str | None:
    from mitlplan.exact import exact

    if text is not None:
        try:
            exact(text)
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
    return text


OptionalMission = Annotated[
    Path | None, typer.Argument(metavar="[MISSION]", help="A mission file, YAML or JSON.")
]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""

    @app.command("translate")
    def translate_command(
        mission: MissionFile,
        form: Annotated[Format, typer.Option("--to", help="What the model is written as.")] = Format.uppaal,
        construction: ConstructionOption = Construction.compact,
        output: Output = None,
        bound: Annotated[
            str | None,
            typer.Option(
                metavar="SECONDS", callback=_bound_option, help="Only plans as fast as this (tchecker)."
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

    @app.command("automaton")
    def automaton_command(
        mission: OptionalMission = None,
        construction: ConstructionOption = Construction.published,
        figure: Annotated[
            str,
            typer.Option(metavar="NAME", help="Instead of a mission, a figure of the paper: fig1 to fig9."),
        ] = "",
        part: Annotated[str, typer.Option(metavar="NAME", help="Draw only this automaton.")] = "",
        output: Annotated[
            Path,
            typer.Option("--output", "-o", metavar="FILE", help="An svg, or a dot to be drawn elsewhere."),
        ] = Path("automaton.svg"),
    ) -> None:
        """Draw the automata of a mission, or those of the paper's figures."""
        with errors_reported():
            if (mission is None) == (not figure):
                raise typer.BadParameter("name a mission or a figure, and not both")
            dot = paper_figure(figure) if mission is None else mission_dot(mission, construction, part)
            draw_to(output, dot)


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


def mission_dot(mission: Path, construction: Construction, part: str) -> str:
    """The graph of one automaton of a mission: the one called `part`, or the robot's."""
    from mitlplan.errors import MissionError
    from mitlplan.formats.dot import automaton_dot
    from mitlplan.models import model_of_mission

    read = read_mission(mission)
    model = model_of_mission(read, construction.value)
    known = {each.name: each for each in model.network.automata}
    chosen: Automaton | None = known.get(part) if part else model.network.automata[0]
    if chosen is None:
        raise MissionError(f"there is no automaton {part}; there are {', '.join(known)}")
    return automaton_dot(chosen, points=layout_of(read, model).get(chosen.name))


def paper_figure(name: str) -> str:
    """The graph of a figure of the paper: ``fig1``, ``fig2``, ``fig4`` to ``fig9``.

    Raises
    ------
    ToolError
        If there is no such figure.
    """
    from mitlplan.errors import ToolError
    from mitlplan.paper import figures

    known = figures()
    if name not in known:
        raise ToolError(f"there is no figure {name}; there are {', '.join(known)}")
    return known[name]


def draw_to(output: Path, dot: str) -> None:
    """Write a graph as what the file's name asks for: ``.dot``, or a picture."""
    from mitlplan.draw.automata import draw_graph
    from mitlplan.errors import OutputError
    from mitlplan.formats.output import check_writable, write_whole

    check_writable(output)
    if output.suffix == ".dot":
        write_whole(output, dot)
    elif output.suffix == ".svg":
        write_whole(output, draw_graph(dot).decode())
    else:
        raise OutputError(f"cannot write {output}: an automaton is drawn as .svg or .dot")
