"""Plans as JSON: the format that other programs build on.

Times are written as texts, ``"7/2"``, because a JSON number would be read as a float. A plan that is read may
come from anywhere: its shape is checked here, and whether it is a plan for a mission by the judge.
"""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator, ValidationError

from mitlplan.document import Document, read_document
from mitlplan.errors import MissionError, PlanFileError
from mitlplan.exact import exact
from mitlplan.mission_schema import Flag, Name, Version, Whole, faults
from mitlplan.plan import Infeasible, LimitReached, Loop, Outcome, Plan, Statistics, Step

_MOST_STEPS = 1_000_000


def plan_to_mapping(outcome: Outcome) -> dict[str, Any]:
    """What the JSON of `outcome` holds.

    Examples
    --------
    >>> plan_to_mapping(Infeasible("A is out of reach.", conflict=("visit",)))["status"]
    'infeasible'
    """
    answer: dict[str, Any] = {
        "mitlplan": 1,
        "status": "plan",
        "makespan": None,
        "bound": None,
        "attained": None,
        "epsilon": None,
        "steps": [],
        "loop": None,
        "checked": False,
        "fault": None,
        "reason": None,
        "conflict": [],
        "statistics": _statistics(outcome.statistics),
    }
    match outcome:
        case Plan():
            return answer | _plan(outcome)
        case Infeasible():
            return answer | {
                "status": "infeasible",
                "reason": outcome.reason,
                "conflict": list(outcome.conflict),
            }
        case LimitReached():
            return answer | {"status": "limit", "reason": outcome.reason, "bound": _text(outcome.bound)}


def plan_to_json(outcome: Outcome) -> str:
    """The JSON of `outcome`, a line for each step.

    Examples
    --------
    >>> print(plan_to_json(Infeasible("A is out of reach."))[:33])
    {"mitlplan": 1,
     "status": "infea
    """
    entries = []
    for key, value in plan_to_mapping(outcome).items():
        if key == "steps" and value:
            steps = ",\n  ".join(json.dumps(step, ensure_ascii=False) for step in value)
            entries.append(f'"steps": [\n  {steps}]')
        else:
            entries.append(f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
    return "{" + ",\n ".join(entries) + "}\n"


def read_plan(file: str | Path) -> Outcome:
    """Read what :func:`plan_to_json` wrote, or another program in its place.

    Parameters
    ----------
    file
        Where it is.

    Raises
    ------
    PlanFileError
        If it cannot be read or is no such JSON: one sentence with the place.
    """
    try:
        document = read_document(Path(file), json_only=True)
        return _outcome(_keys(document))
    except MissionError as error:
        raise PlanFileError(str(error)) from None


def plan_from_mapping(data: object) -> Outcome:
    """The inverse of :func:`plan_to_mapping`.

    Raises
    ------
    PlanFileError
        If `data` has not the shape of a plan.

    Examples
    --------
    >>> plan_from_mapping({"mitlplan": 1, "status": "limit", "reason": "Out of time.", "bound": "7/2"}).bound
    Fraction(7, 2)
    """
    try:
        return _outcome(_keys(Document(data)))
    except MissionError as error:
        raise PlanFileError(str(error)) from None


# -------------------------------------------------------------------------------------------------- writing


def _plan(plan: Plan) -> dict[str, Any]:
    return {
        "makespan": _text(plan.makespan),
        "bound": _text(plan.bound),
        "attained": plan.attained,
        "epsilon": _text(plan.epsilon),
        "steps": [_step(step) for step in plan.steps],
        "loop": None if plan.loop is None else {"start": plan.loop.start, "period": _text(plan.loop.period)},
        "checked": plan.checked,
        "fault": plan.fault,
    }


def _step(step: Step) -> dict[str, Any]:
    return {
        "cell": step.cell,
        "enter": _text(step.enter),
        "leave": _text(step.leave),
        "holds": list(step.holds),
        "slack": _text(step.slack),
    }


def _statistics(statistics: Statistics) -> dict[str, Any]:
    return {
        "engine": statistics.engine,
        "construction": statistics.construction,
        "locations": statistics.locations,
        "edges": statistics.edges,
        "zones": statistics.zones,
        "seconds": dict(statistics.seconds),
    }


def _text(time: Fraction | None) -> str | None:
    return None if time is None else str(time)


# -------------------------------------------------------------------------------------------------- reading

_Time = Annotated[Fraction, PlainValidator(exact)]


def _not_too_many(steps: object) -> object:
    if isinstance(steps, list) and len(steps) > _MOST_STEPS:
        raise ValueError(f"{len(steps)} steps are too many; at most {_MOST_STEPS} are read")
    return steps


class _Keys(BaseModel):
    # Later versions and other programs may add keys of their own.
    model_config = ConfigDict(extra="ignore", frozen=True)


class _StepKeys(_Keys):
    cell: Name
    enter: _Time
    leave: _Time | None
    holds: list[Name] = []
    slack: _Time | None = None


class _LoopKeys(_Keys):
    start: Whole
    period: _Time | None


class _PlanKeys(_Keys):
    version: Version = Field(alias="mitlplan")
    status: Literal["plan", "infeasible", "limit"]
    makespan: _Time | None = None
    bound: _Time | None = None
    attained: Flag | None = True
    epsilon: _Time | None = None
    steps: Annotated[list[_StepKeys], BeforeValidator(_not_too_many)] = []
    loop: _LoopKeys | None = None
    reason: str | None = None
    conflict: list[Name] = []


def _keys(document: Document) -> _PlanKeys:
    try:
        keys = _PlanKeys.model_validate(document.data)
    except ValidationError as error:
        raise document.error(*faults(error, document.data)) from None
    if keys.status == "plan" and (keys.makespan is None or not keys.steps):
        raise MissionError("a plan has a makespan and at least one step", file=document.file)
    return keys


def _outcome(keys: _PlanKeys) -> Outcome:
    # That a plan was checked is not believed: whoever reads it can check it.
    match keys.status:
        case "infeasible":
            return Infeasible(keys.reason or "", tuple(keys.conflict))
        case "limit":
            return LimitReached(keys.reason or "", keys.bound)
        case "plan":
            assert keys.makespan is not None
            return Plan(
                steps=tuple(
                    Step(step.cell, step.enter, step.leave, tuple(step.holds), step.slack)
                    for step in keys.steps
                ),
                makespan=keys.makespan,
                loop=None if keys.loop is None else Loop(keys.loop.start, keys.loop.period),
                attained=keys.attained is not False,
                epsilon=keys.epsilon,
                bound=keys.bound,
            )
