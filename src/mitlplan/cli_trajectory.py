"""The commands `trajectory` and `draw`: from a mission or a plan to what a robot drives, and to a picture.

Both read the mission, take the plan from a file or find it, and follow it; they differ in what they write.
As everywhere results go to stdout and sentences to stderr, and the exit code is 1 or 3 where there is no
plan. What is said of the robot and of how it is driven is the same for both: ``--robot speed=1/2 --drive
turn=arc``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mitlplan.cli_answers import LIMIT, NONE, deliver, errors_reported, say
from mitlplan.cli_options import MissionFile, Output, positive_option, read_mission
from mitlplan.errors import OutputError, TrajectoryError

if TYPE_CHECKING:
    from mitlplan.mission import Mission
    from mitlplan.plan import Plan
    from mitlplan.trajectory import Driving, Robot, Trajectory
    from mitlplan.workspace import Workspace

ROBOT_KEYS = ("speed", "turn_rate", "acceleration", "turn_acceleration", "radius", "heading")
DRIVE_KEYS = (
    "turn",
    "u_turn",
    "profile",
    "waiting",
    "reverse",
    "linear_weight",
    "angular_weight",
    "stop_time",
    "retime",
    "deadline",
)


class TrajectoryForm(str, Enum):
    """How a trajectory is written."""

    csv = "csv"
    json = "json"
    sqlite3 = "sqlite3"
    mcap = "mcap"


class Shown(str, Enum):
    """What is drawn."""

    map = "map"
    plan = "plan"
    trajectory = "trajectory"


PlanFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="PLAN.json", help="A plan for it, as plan --format json writes it; else one is found."
    ),
]
RobotOptions = Annotated[
    list[str] | None,
    typer.Option("--robot", metavar="KEY=VALUE", help=f"What the robot can do: {', '.join(ROBOT_KEYS)}."),
]
DriveOptions = Annotated[
    list[str] | None,
    typer.Option("--drive", metavar="KEY=VALUE", help=f"How it is driven: {', '.join(DRIVE_KEYS)}."),
]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""

    @app.command("trajectory")
    def trajectory_command(
        mission: MissionFile,
        plan: PlanFile = None,
        form: Annotated[
            TrajectoryForm,
            typer.Option("--format", help="How it is written; sqlite3 and mcap are ROS 2 bags."),
        ] = TrajectoryForm.csv,
        output: Output = None,
        step: Annotated[
            str, typer.Option(metavar="SECONDS", callback=positive_option, help="Between two samples.")
        ] = "1/20",
        until: Annotated[
            str | None,
            typer.Option(
                metavar="SECONDS", callback=positive_option, help="How long to follow a plan that goes round."
            ),
        ] = None,
        frame: Annotated[str, typer.Option(help="The coordinate frame named in a bag.")] = "map",
        robot: RobotOptions = None,
        drive: DriveOptions = None,
    ) -> None:
        """Follow a plan: time, pose and controls of a robot that is in its cells when the plan says so."""
        with errors_reported():
            wishes = _wishes(robot or (), drive or ())
            bag = form in (TrajectoryForm.sqlite3, TrajectoryForm.mcap)
            _check_output(output, bag=bag)
            read, found = _planned(mission, plan)
            found, driven = _driven(read, found, wishes)
            writing = _Writing(form, Fraction(step), None if until is None else Fraction(until), frame)
            _write_trajectory(driven, found, writing, output)

    @app.command("draw")
    def draw_command(
        mission: MissionFile,
        plan: PlanFile = None,
        output: Annotated[
            Path,
            typer.Option("--output", "-o", metavar="FILE", help="An svg, png or pdf, or a gif that moves."),
        ] = Path("plan.svg"),
        shown: Annotated[Shown, typer.Option("--show", help="What is drawn on the map.")] = Shown.trajectory,
        title: Annotated[str, typer.Option(help="Written above the map.")] = "",
        robot: RobotOptions = None,
        drive: DriveOptions = None,
    ) -> None:
        """Draw the map with its regions, and the plan or the trajectory on it."""
        from mitlplan.formats.output import write_whole

        with errors_reported():
            wishes = _wishes(robot or (), drive or ())
            _check_output(output)
            kind = _picture_kind(output, shown)
            write_whole(output, _drawn(mission, plan, kind, shown, title, wishes))


# -------------------------------------------------------------------------------------------------- wishes


@dataclass(frozen=True, slots=True)
class _Wishes:
    """What was said of the robot and of how it is driven, checked to be keys that there are."""

    robot: Mapping[str, str]
    drive: Mapping[str, str]

    def exact(self, name: str) -> Fraction | None:
        """The number of that name, exactly."""
        from mitlplan.exact import exact

        text = self.robot.get(name, self.drive.get(name))
        if text is None:
            return None
        try:
            return exact(text)
        except ValueError as error:
            raise TrajectoryError(f"{name}: {error}") from None

    def heading(self) -> float | None:
        """How the robot faces at first, in radians."""
        from mitlplan.workspace.motion import heading_of

        text = self.robot.get("heading")
        try:
            return None if text is None else heading_of(text)
        except ValueError as error:
            raise TrajectoryError(f"--robot heading={text}: {error}") from None

    def choice(self, name: str, kind: type[Enum]) -> Any:
        """The member of `kind` whose name was given; ``None`` if none was."""
        text = self.drive.get(name)
        if text is None:
            return None
        members = {member.name.lower().replace("_", "-"): member for member in kind}
        if text not in members:
            raise TrajectoryError(f"{name}: {text} is none of {', '.join(members)}")
        return members[text]

    def wanted(self, name: str, *, otherwise: bool = False) -> bool:
        """Whether that is wanted: ``true`` or ``yes``, or ``false`` or ``no``; else `otherwise`."""
        text = self.drive.get(name)
        if text is None:
            return otherwise
        if text not in ("true", "yes", "false", "no"):
            raise TrajectoryError(f"{name}: {text} is neither true nor false")
        return text in ("true", "yes")


def _wishes(robot: Sequence[str], drive: Sequence[str]) -> _Wishes:
    return _Wishes(_pairs("--robot", robot, ROBOT_KEYS), _pairs("--drive", drive, DRIVE_KEYS))


def _pairs(option: str, texts: Sequence[str], known: Sequence[str]) -> Mapping[str, str]:
    from mitlplan.workspace.names import advise

    found = {}
    for text in texts:
        key, sign, value = (part.strip() for part in text.partition("="))
        if key not in known:
            raise TrajectoryError(f"{option} {text}: there is no {key}; {advise(key, known, 'keys')}")
        if not sign or not value:
            raise TrajectoryError(f"{option} {text}: write {key}=VALUE")
        found[key] = value
    return found


# ------------------------------------------------------------------------------------------------- driving


def _planned(mission: Path, plan: Path | None) -> tuple[Mission, Plan]:
    """The mission, and the plan of the file or one that is found for it."""
    from mitlplan.check import check
    from mitlplan.errors import PlanFileError
    from mitlplan.formats.plan_json import read_plan
    from mitlplan.plan import Infeasible, LimitReached
    from mitlplan.plan import Plan as FoundPlan
    from mitlplan.planner import plan as find

    found = read_mission(mission)
    outcome = find(found) if plan is None else read_plan(plan)
    match outcome:
        case FoundPlan():
            fault = None if plan is None else check(found, outcome)
            if fault is not None:
                raise PlanFileError(f"{plan}: the plan is not one for this mission: {fault}")
            return found, outcome
        case Infeasible(reason=reason):
            say(f"no plan: {reason}")
            raise typer.Exit(NONE)
        case LimitReached(reason=reason):
            say(f"no plan found: {reason}")
            raise typer.Exit(LIMIT)


def _driven(mission: Mission, plan: Plan, wishes: _Wishes) -> tuple[Plan, Trajectory]:
    """The trajectory, and the plan that it follows, which is another one if it was retimed."""
    from mitlplan.trajectory import Driving, Profile, Style, Waiting, Weights, follow

    model = mission.robot
    weights = [wishes.exact(f"{name}_weight") for name in ("linear", "angular")]
    if 0 in weights:
        raise TrajectoryError("the weights of speed and turn rate are positive numbers")
    driving = Driving(
        weights=Weights(*(1.0 if weight is None else float(weight) for weight in weights)),
        turn=wishes.choice("turn", Style),
        u_turn=wishes.choice("u_turn", Style),
        profile=wishes.choice("profile", Profile) or (model.driving.profile if model else Profile.EVEN),
        reverse=wishes.wanted("reverse"),
    )
    waiting = wishes.choice("waiting", Waiting) or Waiting.ENTRY
    robot, heading = _robot(mission, wishes), wishes.heading()
    if heading is None and model is not None:
        heading = model.heading
    if wishes.wanted("retime", otherwise=mission.retime):
        deadline = wishes.exact("deadline") or mission.deadline
        plan = _retimed(mission, plan, robot, driving, heading, deadline)
        waiting = Waiting.SLOW
    elif "deadline" in wishes.drive:
        raise TrajectoryError("a deadline is for --drive retime=true; the plan keeps its times otherwise")
    trajectory = follow(
        plan,
        mission.workspace,
        robot=robot,
        driving=driving,
        waiting=waiting,
        heading=heading,
        stop_time=wishes.exact("stop_time"),
    )
    return plan, trajectory


def _retimed(
    mission: Mission,
    plan: Plan,
    robot: Robot,
    driving: Driving,
    heading: float | None,
    deadline: Fraction | None,
) -> Plan:
    """The plan at the times that cost least; whether no others cost less is said on stderr."""
    from mitlplan.check import check
    from mitlplan.compose import core_of
    from mitlplan.refusal import reasons
    from mitlplan.trajectory import retime, spans_of

    core = core_of(mission)
    found = retime(
        plan,
        spans_of(plan, mission.workspace, robot=robot, driving=driving, heading=heading),
        lambda slower: check(mission, slower) is None,
        reasons=lambda slower: reasons(core, slower, horizon=mission.horizon),
        deadline=deadline,
    )
    if found.cost > found.bound:
        say(f"the new times cost {found.cost:.6g}; others may cost less, but not below {found.bound:.6g}")
    return found.plan


def _robot(mission: Mission, wishes: _Wishes) -> Robot:
    """The mission's robot, with what was said of it here in the place of what the mission says."""
    from mitlplan.trajectory import Robot

    model = Robot() if mission.robot is None else mission.robot.robot
    said: dict[str, Any] = {name: wishes.exact(name) for name in wishes.robot if name != "heading"}
    return replace(model, **said)


def _on_the_ground(mission: Mission, plan: Plan) -> tuple[Workspace, Plan]:
    """The map as it was given, and the plan on it, without the headings that the mission's cells may have."""
    model, world = mission.robot, mission.workspace
    if model is None:
        return world, plan
    indices = [world.index_of(step.cell) for step in plan.steps]
    names = [model.ground.names[model.cell_of[index]] for index in indices if index is not None]
    steps = (replace(step, cell=name) for step, name in zip(plan.steps, names, strict=True))
    return model.ground, replace(plan, steps=tuple(steps))


# ------------------------------------------------------------------------------------------------- writing


@dataclass(frozen=True, slots=True)
class _Writing:
    """How a trajectory is written."""

    form: TrajectoryForm
    step: Fraction
    until: Fraction | None
    frame: str


def _write_trajectory(trajectory: Trajectory, plan: Plan, writing: _Writing, output: Path | None) -> None:
    try:
        match writing.form:
            case TrajectoryForm.csv:
                from mitlplan.formats.trajectory_csv import trajectory_to_csv

                text = trajectory_to_csv(trajectory, writing.step, writing.until)
            case TrajectoryForm.json:
                from mitlplan.formats.trajectory_json import trajectory_to_json

                text = trajectory_to_json(trajectory, writing.step, writing.until)
            case TrajectoryForm.sqlite3 | TrajectoryForm.mcap:
                from mitlplan.formats.ros import Storage, write_bag

                assert output is not None
                storage = Storage(writing.form.value)
                write_bag(
                    output,
                    trajectory,
                    plan,
                    writing.step,
                    storage=storage,
                    frame=writing.frame,
                    until=writing.until,
                )
                return
    except ValueError as error:
        raise OutputError(str(error)) from None
    deliver(text, output)


def _picture_kind(output: Path, shown: Shown) -> str:
    kind = output.suffix.removeprefix(".").lower()
    if kind not in ("svg", "png", "pdf", "gif"):
        raise OutputError(f"cannot draw {output}: its name ends in .svg, .png or .pdf, or in .gif to move")
    if kind == "gif" and shown is not Shown.trajectory:
        raise OutputError(f"cannot draw {output}: only a trajectory moves; leave --show away or draw a png")
    return kind


def _drawn(mission: Path, plan: Path | None, kind: Any, shown: Shown, title: str, wishes: _Wishes) -> bytes:
    try:
        from mitlplan.draw import animation, picture, rendered
    except ImportError:
        raise OutputError("pictures need the package matplotlib: pip install 'mitlplan[draw]'") from None
    if shown is Shown.map:
        world = read_mission(mission)
        ground = world.workspace if world.robot is None else world.robot.ground
        return rendered(picture(ground, title=title), kind)
    found, planned = _planned(mission, plan)
    if shown is Shown.plan:
        return rendered(picture(*_on_the_ground(found, planned), title=title), kind)
    planned, driven = _driven(found, planned, wishes)
    ground, planned = _on_the_ground(found, planned)
    if kind == "gif":
        radius = float(_robot(found, wishes).radius)
        return animation(ground, driven, radius=radius or None, title=title)
    return rendered(picture(ground, planned, driven, title=title), kind)


def _check_output(output: Path | None, *, bag: bool = False) -> None:
    from mitlplan.formats.output import check_writable

    match output, bag:
        case None, True:
            raise OutputError("a bag is a folder; name it with --output")
        case Path(), True:
            from mitlplan.formats.ros import check_new

            check_new(output)
        case Path(), False:
            check_writable(output)
