"""The command `draw`: the map, a plan or a trajectory on it, the automata of a mission, the paper's figures.

One option says which: `--show` for what is on the map, `--automaton` for what the mission was translated to
(:mod:`mitlplan.models`), `--figure` for a figure of Zhou, Maity and Baras, made from the code's own automata.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mitlplan.cli_answers import errors_reported
from mitlplan.cli_models import layout_of
from mitlplan.cli_options import Construction, read_mission
from mitlplan.cli_trajectory import (
    DriveOptions,
    PlanFile,
    RobotOptions,
    Wishes,
    mission_and_plan,
    robot_of,
    trajectory_of,
    wishes_of,
)
from mitlplan.errors import OutputError

if TYPE_CHECKING:
    from mitlplan.automata.timed_automaton import Automaton
    from mitlplan.mission import Mission
    from mitlplan.plan import Plan
    from mitlplan.workspace import Workspace


class Shown(str, Enum):
    """What is drawn on the map."""

    map = "map"
    plan = "plan"
    trajectory = "trajectory"


OptionalMission = Annotated[
    Path | None, typer.Argument(metavar="[MISSION]", help="A mission file, YAML or JSON; none for --figure.")
]


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""

    @app.command("draw")
    def draw_command(
        mission: OptionalMission = None,
        plan: PlanFile = None,
        output: Annotated[
            Path | None,
            typer.Option(
                "--output",
                "-o",
                metavar="FILE",
                help="An svg, png or pdf, or a gif that moves; svg or dot of automata.  [default: plan.svg]",
            ),
        ] = None,
        shown: Annotated[Shown, typer.Option("--show", help="What is drawn on the map.")] = Shown.trajectory,
        title: Annotated[str, typer.Option(help="Written above the map.")] = "",
        automaton: Annotated[
            bool, typer.Option("--automaton", help="Draw an automaton of the mission instead: the robot's.")
        ] = False,
        part: Annotated[
            str, typer.Option(metavar="NAME", help="Another one of the mission's automata.")
        ] = "",
        construction: Annotated[
            Construction, typer.Option(help="How formulas become automata, for --automaton.")
        ] = Construction.published,
        figure: Annotated[
            str, typer.Option(metavar="NAME", help="Draw a figure of the paper instead: fig1 to fig9.")
        ] = "",
        robot: RobotOptions = None,
        drive: DriveOptions = None,
    ) -> None:
        """Draw the map with its regions, and the plan or the trajectory on it; or automata."""
        from mitlplan.formats.output import check_writable, write_whole

        with errors_reported():
            if (mission is None) == (not figure):
                raise typer.BadParameter("name a mission or a figure, and not both")
            output = output or Path("automaton.svg" if automaton or figure else "plan.svg")
            check_writable(output)
            if mission is None:
                drawing: str | bytes = _graph_drawn(output, lambda: _paper_figure(figure))
            elif automaton or part:
                drawing = _graph_drawn(output, lambda: _mission_dot(mission, construction, part))
            else:
                wishes = wishes_of(robot or (), drive or ())
                drawing = _map_drawn(mission, plan, output, shown, title, wishes)
            write_whole(output, drawing)


# -- automata -------------------------------------------------------------------------------------------


def _mission_dot(mission: Path, construction: Construction, part: str) -> str:
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


def _paper_figure(name: str) -> str:
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


def _graph_drawn(output: Path, graph: Callable[[], str]) -> str:
    """A graph as what the file's name asks for: ``.dot``, or a picture."""
    from mitlplan.draw.automata import draw_graph

    match output.suffix:
        case ".dot":
            return graph()
        case ".svg":
            return draw_graph(graph()).decode()
        case _:
            raise OutputError(f"cannot write {output}: an automaton is drawn as .svg or .dot")


# -- maps -----------------------------------------------------------------------------------------------


def _on_the_ground(mission: Mission, plan: Plan) -> tuple[Workspace, Plan]:
    """The map as it was given, and the plan on it, without the headings that the mission's cells may have."""
    model, world = mission.robot, mission.workspace
    if model is None:
        return world, plan
    indices = [world.index_of(step.cell) for step in plan.steps]
    names = [model.ground.names[model.cell_of[index]] for index in indices if index is not None]
    steps = (replace(step, cell=name) for step, name in zip(plan.steps, names, strict=True))
    return model.ground, replace(plan, steps=tuple(steps))


def _picture_kind(output: Path, shown: Shown) -> Any:
    kind = output.suffix.removeprefix(".").lower()
    if kind not in ("svg", "png", "pdf", "gif"):
        raise OutputError(f"cannot draw {output}: its name ends in .svg, .png or .pdf, or in .gif to move")
    if kind == "gif" and shown is not Shown.trajectory:
        raise OutputError(f"cannot draw {output}: only a trajectory moves; leave --show away or draw a png")
    return kind


def _map_drawn(
    mission: Path, plan: Path | None, output: Path, shown: Shown, title: str, wishes: Wishes
) -> bytes:
    kind = _picture_kind(output, shown)
    try:
        from mitlplan.draw import animation, picture, rendered
    except ImportError:
        raise OutputError("pictures need the package matplotlib: pip install 'mitlplan[draw]'") from None
    if shown is Shown.map:
        world = read_mission(mission)
        ground = world.workspace if world.robot is None else world.robot.ground
        return rendered(picture(ground, title=title), kind)
    found, planned = mission_and_plan(mission, plan)
    if shown is Shown.plan:
        return rendered(picture(*_on_the_ground(found, planned), title=title), kind)
    planned, driven = trajectory_of(found, planned, wishes)
    ground, planned = _on_the_ground(found, planned)
    if kind == "gif":
        radius = float(robot_of(found, wishes).radius)
        return animation(ground, driven, radius=radius or None, title=title)
    return rendered(picture(ground, planned, driven, title=title), kind)
