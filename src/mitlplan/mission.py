"""The mission: a map, a robot on it, and what the robot has to do by when.

A mission file is untrusted and written by people, so each error is a sentence with file, line and column,
says what is wrong and offers the nearest thing that would be right. The way is: text with places
(:mod:`mitlplan.document`), its shape (:mod:`mitlplan.mission_schema`), then the map and the formulas, each
built by the function that anybody may call without a file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, Union, get_args

import numpy as np
from pydantic import ValidationError

from mitlplan.document import Document, Fault, read_document
from mitlplan.errors import FormulaError, TrajectoryError, WorkspaceError
from mitlplan.exact import Number, exact
from mitlplan.logic.formula import Atom, Formula, operands_of
from mitlplan.logic.normalize import warnings
from mitlplan.logic.parse import parse
from mitlplan.logic.show import show
from mitlplan.mission_schema import (
    BoxKeys,
    GraphKeys,
    GridKeys,
    MissionKeys,
    MovingaiKeys,
    Region,
    RobotKeys,
    SquaresKeys,
    WorkspaceKeys,
    faults,
)
from mitlplan.workspace import Box, Move, Workspace, graph, grid, movingai
from mitlplan.workspace.motion import Indices, heading_of, with_headings, with_travel_times
from mitlplan.workspace.names import advise
from mitlplan.workspace.regions import Part

if TYPE_CHECKING:
    from mitlplan.trajectory import Driving, Robot

Horizon: TypeAlias = Literal["infinite", "finite"]
UntilKind: TypeAlias = Literal["standard", "closed"]
Spec: TypeAlias = Union[str, Formula, Mapping[str, Union[str, Formula]]]
"""One requirement, or several by their names."""

ONLY_REQUIREMENT = "spec"
"""The name of the requirement where the file gives a single one without a name."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """One of the formulas that a mission demands, as it was written and as it was read."""

    name: str
    text: str
    formula: Formula


@dataclass(frozen=True, eq=False, slots=True)
class RobotModel:
    """The robot from which the times of moves were computed.

    Parameters
    ----------
    robot
        Its limits.
    driving
        How it is driven.
    heading
        How it faces at first, in radians; ``None``: as it likes.
    ground
        The map as it was given.
    cell_of
        For each cell of the mission's workspace the cell of `ground`; with headings there are several.
    """

    robot: Robot
    driving: Driving
    heading: float | None
    ground: Workspace
    cell_of: Indices


@dataclass(frozen=True, eq=False, slots=True)
class Mission:
    """What is to be planned.

    Parameters
    ----------
    workspace
        The robot's world.
    start
        The index of the cell in which the robot starts.
    spec
        The requirements, all of which must hold.
    horizon, until
        How the requirements are read (docs: semantics, sections 2 and 3).
    epsilon
        Seconds within which a plan comes to a least makespan that none attains.
    source
        The file that it was read from, if any.
    warnings
        Sentences on what is legal and surely not meant.
    robot
        What the times of moves were computed from; ``None`` if the map gives them.
    retime
        Whether a trajectory spends the time that the mission leaves, to cost less.
    deadline
        The latest end of a plan that is retimed; ``None``: its makespan.
    """

    workspace: Workspace
    start: int
    spec: tuple[Requirement, ...]
    horizon: Horizon = "infinite"
    until: UntilKind = "standard"
    epsilon: Fraction = Fraction(1, 1000)
    source: Path | None = None
    warnings: tuple[str, ...] = ()
    robot: RobotModel | None = None
    retime: bool = False
    deadline: Fraction | None = None


def read(
    file: str | Path,
    *,
    horizon: Horizon | None = None,
    until: UntilKind | None = None,
    epsilon: Fraction | None = None,
) -> Mission:
    """Read a mission file, YAML or (if it is called ``.json``) JSON.

    Parameters
    ----------
    file
        Where it is; paths in it are relative to its folder.
    horizon, until, epsilon
        Take the place of what the file says.

    Raises
    ------
    MissionError
        If the file, its map or its formulas cannot be read: one sentence with the place and a remedy.
    """
    source = Path(file)
    keys, document = _keys(read_document(source))
    return _mission(_overridden(keys, horizon, until, epsilon), document, source.parent, source)


def mission_from_mapping(data: Mapping[str, Any], *, folder: str | Path = ".") -> Mission:
    """Make a mission of the data that a mission file would hold.

    Parameters
    ----------
    data
        The keys of a mission file; numbers as whole numbers, fractions, decimals or texts, never floats.
    folder
        What paths in it are relative to.

    Raises
    ------
    MissionError
        As :func:`read`, without line and column.

    Examples
    --------
    >>> mission = mission_from_mapping({
    ...     "mitlplan": 1,
    ...     "workspace": {"grid": {"rows": 2, "columns": 2, "regions": {"A": [[1, 0]]}}},
    ...     "robot": {"start": [0, 0]},
    ...     "spec": "F[0,2] A",
    ... })
    >>> mission.workspace.names[mission.start], mission.spec[0].text
    ('r0c0', 'F[0,2] A')
    """
    keys, document = _keys(Document(data))
    return _mission(keys, document, Path(folder), None)


def mission_for(
    workspace: Workspace,
    spec: Spec,
    *,
    start: str | tuple[int, int],
    horizon: Horizon = "infinite",
    until: UntilKind = "standard",
    epsilon: Number = Fraction(1, 1000),
    propositions: Iterable[str] = (),
) -> Mission:
    """Make a mission of a workspace that is already there.

    Parameters
    ----------
    workspace
        The robot's world.
    spec
        A formula or its text, or several by their names.
    start
        The cell in which the robot starts: its name, or on grids its row and column.
    horizon, until
        How the requirements are read (docs: semantics, sections 2 and 3).
    epsilon
        Seconds within which a plan comes to a least makespan that none attains.
    propositions
        Those that formulas may name although no cell carries them.

    Raises
    ------
    MissionError
        As :func:`read`, without line and column.

    Examples
    --------
    >>> mission = mission_for(grid(2, 2, regions={"A": [(1, 0)]}), {"visit": "F[0,2] A"}, start="r0c0")
    >>> mission.start, mission.spec[0].name
    (0, 'visit')
    """
    document = Document({"spec": spec})
    for key, value, choices in (
        ("horizon", horizon, get_args(Horizon)),
        ("until", until, get_args(UntilKind)),
    ):
        if value not in choices:
            raise document.error(Fault(f"{' or '.join(choices)} is expected, not {value!r}", (key,)))
    tolerance = _tolerance(epsilon, document)
    known = sorted(workspace.propositions.union(propositions))
    requirements = tuple(_requirements(spec, known, document))
    return Mission(
        workspace=workspace,
        start=_start(start, workspace, document),
        spec=requirements,
        horizon=horizon,
        until=until,
        epsilon=tolerance,
        warnings=tuple(_warnings(spec, requirements, until, document)),
    )


def _tolerance(epsilon: Number, document: Document) -> Fraction:
    try:
        tolerance = exact(epsilon)
    except ValueError as error:
        raise document.error(Fault(str(error), ("epsilon",))) from None
    if tolerance == 0:
        raise document.error(Fault("a positive number is expected, such as 1/1000", ("epsilon",)))
    return tolerance


def schema() -> dict[str, Any]:
    """The JSON Schema of mission files, for editors.

    Examples
    --------
    >>> schema()["title"]
    'mitlplan mission'
    """
    found = MissionKeys.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **found, "title": "mitlplan mission"}


def _keys(document: Document) -> tuple[MissionKeys, Document]:
    try:
        return MissionKeys.model_validate(document.data), document
    except ValidationError as error:
        raise document.error(*faults(error, document.data)) from None


def _overridden(
    keys: MissionKeys, horizon: Horizon | None, until: UntilKind | None, epsilon: Fraction | None
) -> MissionKeys:
    given = {"horizon": horizon, "until": until, "epsilon": epsilon}
    return keys.model_copy(update={key: value for key, value in given.items() if value is not None})


def _mission(keys: MissionKeys, document: Document, folder: Path, source: Path | None) -> Mission:
    kind, kind_keys = _kind(keys.workspace)
    _check_propositions(kind_keys, document, ("workspace", kind))
    workspace = _workspace(_timed(keys, kind_keys, kind, document), document, folder, ("workspace", kind))
    known = sorted(workspace.propositions.union(kind_keys.propositions))
    start = _start(keys.robot.start, workspace, document)
    requirements = tuple(_requirements(keys.spec, known, document))
    robot = None
    if keys.robot.speed is not None:
        workspace, start, robot = _driven(keys.robot, workspace, start, document)
    return Mission(
        workspace=workspace,
        start=start,
        spec=requirements,
        horizon=keys.horizon,
        until=keys.until,
        epsilon=keys.epsilon,
        source=source,
        warnings=tuple(_warnings(keys.spec, requirements, keys.until, document)),
        robot=robot,
        retime=keys.robot.retime,
        deadline=keys.robot.deadline,
    )


# ---------------------------------------------------------------------------------------------- the workspace


def _kind(keys: WorkspaceKeys) -> tuple[str, GraphKeys | GridKeys | MovingaiKeys]:
    for kind, found in (("graph", keys.graph), ("grid", keys.grid), ("movingai", keys.movingai)):
        if found is not None:
            return kind, found
    raise AssertionError("the schema lets exactly one kind pass")


def _workspace(
    keys: GraphKeys | GridKeys | MovingaiKeys, document: Document, folder: Path, path: tuple[str, str]
) -> Workspace:
    try:
        match keys:
            case GraphKeys():
                moves = (Move(move.origin, move.target, move.time, move.both) for move in keys.moves)
                return graph(keys.cells, moves, waiting=keys.waiting)
            case GridKeys():
                blocked = [_part(part) for part in keys.blocked]
                return grid(keys.rows, keys.columns, blocked=blocked, **_squares(keys))
            case MovingaiKeys():
                return movingai(folder / keys.file, **_squares(keys))
    except WorkspaceError as error:
        raise document.error(Fault(str(error), (*path, *error.where))) from None


def _squares(keys: SquaresKeys) -> dict[str, Any]:
    return {
        "move_time": keys.move_time,
        "waiting": keys.waiting,
        "regions": {name: _region(region) for name, region in keys.regions.items()},
        "neighbours": keys.neighbours,
        "diagonal_time": keys.diagonal_time,
    }


def _region(region: Region) -> Box | list[Part]:
    return _box(region) if isinstance(region, BoxKeys) else [_part(part) for part in region]


def _part(part: BoxKeys | tuple[int, int]) -> Part:
    return _box(part) if isinstance(part, BoxKeys) else part


def _box(box: BoxKeys) -> Box:
    return Box(box.rows, box.columns)


def _check_propositions(
    keys: GraphKeys | GridKeys | MovingaiKeys, document: Document, path: tuple[str, str]
) -> None:
    """Refuse a proposition that no formula could name."""
    known: set[str] = set()
    for name, place, key in _given_propositions(keys):
        if name not in known and not _can_be_named(name):
            problem = (
                f"the proposition {name!r} cannot stand in a formula; a name is a letter followed by "
                "letters, digits, _ and ., and is no operator"
            )
            raise document.error(Fault(problem, (*path, *place), key))
        known.add(name)


def _given_propositions(
    keys: GraphKeys | GridKeys | MovingaiKeys,
) -> Iterator[tuple[str, tuple[str | int, ...], str | None]]:
    """Each proposition with the path at which it stands, and the key there if it is one."""
    for place, name in enumerate(keys.propositions):
        yield name, ("propositions", place), None
    match keys:
        case GraphKeys():
            for cell, holds in keys.cells.items():
                for place, name in enumerate(holds):
                    yield name, ("cells", cell, place), None
        case GridKeys() | MovingaiKeys():
            for name in keys.regions:
                yield name, ("regions",), name


def _can_be_named(name: str) -> bool:
    try:
        return parse(name) == Atom(name)
    except FormulaError:
        return False


def _start(start: str | tuple[int, int], workspace: Workspace, document: Document) -> int:
    name = start if isinstance(start, str) else f"r{start[0]}c{start[1]}"
    index = workspace.index_of(name)
    if index is None:
        problem = f"no cell is called {name}; {workspace.advise(name)}"
        raise document.error(Fault(problem, ("robot", "start")))
    return index


# -------------------------------------------------------------------------------------------------- the robot


def _timed(
    keys: MissionKeys, kind_keys: GraphKeys | GridKeys | MovingaiKeys, kind: str, document: Document
) -> GraphKeys | GridKeys | MovingaiKeys:
    """The keys of the map, where a robot with a speed stands in for the times of moves."""
    if keys.robot.speed is None or isinstance(kind_keys, GraphKeys):
        return kind_keys
    for key in ("move_time", "diagonal_time"):
        if key in kind_keys.model_fields_set:
            problem = f"the robot's speed gives the times of moves; leave {key} out, or the speed"
            raise document.error(Fault(problem, ("workspace", kind), key))
    # The builder wants a time for diagonal moves; it is replaced like all others.
    return kind_keys.model_copy(update={"diagonal_time": 1}) if kind_keys.neighbours == 8 else kind_keys


def _driven(
    keys: RobotKeys, ground: Workspace, start: int, document: Document
) -> tuple[Workspace, int, RobotModel]:
    """The map with the times that the robot needs, the cell in which it starts there, and the robot."""
    from mitlplan.trajectory import DrivenTimes, Driving, Profile, Robot

    heading = _heading(keys.heading, document)
    robot = Robot(keys.speed, keys.turn_rate, keys.acceleration, keys.turn_acceleration, keys.radius)
    driving = Driving(profile=Profile[keys.rest_to_rest.upper()])
    times = DrivenTimes(robot, driving)
    try:
        if keys.headings:
            headed = with_headings(ground, times, start, heading)
            model = RobotModel(robot, driving, heading, ground, headed.cell_of)
            return headed.workspace, headed.start, model
        same = np.arange(ground.cell_count, dtype=np.int32)
        model = RobotModel(robot, driving, heading, ground, same)
        return with_travel_times(ground, times, start, heading), start, model
    except (TrajectoryError, WorkspaceError) as error:
        raise document.error(Fault(str(error), ("robot",))) from None


def _heading(heading: str | float | None, document: Document) -> float | None:
    if not isinstance(heading, str):
        return heading
    try:
        return heading_of(heading)
    except ValueError as error:
        raise document.error(Fault(str(error), ("robot", "heading"))) from None


# ------------------------------------------------------------------------------------------- the requirements


def _requirements(spec: Spec, known: Sequence[str], document: Document) -> Iterator[Requirement]:
    if isinstance(spec, Mapping) and not spec:
        raise document.error(Fault("there is no requirement; write a formula or name: formula", ("spec",)))
    for name, given in _named(spec).items():
        with _placed(spec, name, document):
            text, formula = (given, parse(given)) if isinstance(given, str) else (show(given), given)
            _check_atoms(formula, text, known)
        yield Requirement(name, text, formula)


def _named(spec: Spec) -> Mapping[str, str | Formula]:
    return spec if isinstance(spec, Mapping) else {ONLY_REQUIREMENT: spec}


@contextmanager
def _placed(spec: Spec, name: str, document: Document) -> Iterator[None]:
    """Give the error of a formula the place of its requirement in the file."""
    try:
        yield
    except FormulaError as error:
        path = ("spec", name) if isinstance(spec, Mapping) else ("spec",)
        raise document.error(Fault(str(error), path)) from None


def _warnings(
    spec: Spec, requirements: Sequence[Requirement], until: UntilKind, document: Document
) -> Iterator[str]:
    for requirement in requirements:
        with _placed(spec, requirement.name, document):
            found = warnings(requirement.formula, until)
        yield from (f"the requirement {requirement.name}: {sentence}" for sentence in found)


def _check_atoms(formula: Formula, text: str, known: Sequence[str]) -> None:
    """Refuse a proposition that nothing on the map carries: legal logic, and nearly always a slip."""
    for name in _atoms(formula):
        if name not in known:
            place = re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", text)
            raise FormulaError(
                f"No cell carries the proposition {name}.",
                text,
                place.start() if place else 0,
                length=len(name),
                hint=f"{advise(name, known, 'propositions')} (or give the map propositions: [{name}])",
            )


def _atoms(formula: Formula) -> Iterator[str]:
    """The names in the formula, from left to right."""
    if isinstance(formula, Atom):
        yield formula.name
    for operand in operands_of(formula):
        yield from _atoms(operand)
