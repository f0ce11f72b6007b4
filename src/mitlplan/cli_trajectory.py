"""The command `trajectory`: from a mission or a plan to what a robot drives.

It reads the mission, takes the plan from a file or finds it, and follows it; `draw` does the same and makes a
picture of it. As everywhere results go to stdout and sentences to stderr, and the exit code is 1 or 3 where
there is no plan. What is said of the robot and of how it is driven: ``--robot speed=1/2 --drive turn=arc``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mitlplan.cli_answers import NONE, deliver, errors_reported, say
from mitlplan.cli_limits import LIMIT
from mitlplan.cli_options import MissionFile, Output, positive_option, read_mission
from mitlplan.errors import OutputError, TrajectoryError

if TYPE_CHECKING:
    from mitlplan.mission import Mission
    from mitlplan.plan import Plan
    from mitlplan.trajectory import Driving, Robot, Trajectory

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
    """Add the command to `app`."""

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
            wishes = wishes_of(robot or (), drive or ())
            bag = form in (TrajectoryForm.sqlite3, TrajectoryForm.mcap)
            _check_output(output, bag=bag)
            read, found = mission_and_plan(mission, plan)
            found, driven = trajectory_of(read, found, wishes)
            writing = _Writing(form, Fraction(step), None if until is None else Fraction(until), frame)
            _write_trajectory(driven, found, writing, output)


# -------------------------------------------------------------------------------------------------- wishes


@dataclass(frozen=True, slots=True)
class Wishes:
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


def wishes_of(robot: Sequence[str], drive: Sequence[str]) -> Wishes:
    """What the options ``--robot`` and ``--drive`` say."""
    return Wishes(_pairs("--robot", robot, ROBOT_KEYS), _pairs("--drive", drive, DRIVE_KEYS))


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


def mission_and_plan(mission: Path, plan: Path | None) -> tuple[Mission, Plan]:
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


def trajectory_of(mission: Mission, plan: Plan, wishes: Wishes) -> tuple[Plan, Trajectory]:
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
    robot, heading = robot_of(mission, wishes), wishes.heading()
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


def robot_of(mission: Mission, wishes: Wishes) -> Robot:
    """The mission's robot, with what was said of it here in the place of what the mission says."""
    from mitlplan.trajectory import Robot

    model = Robot() if mission.robot is None else mission.robot.robot
    said: dict[str, Any] = {name: wishes.exact(name) for name in wishes.robot if name != "heading"}
    return replace(model, **said)


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
