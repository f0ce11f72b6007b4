"""The shape of a mission file, as pydantic models; the JSON Schema for editors comes from here too.

The models check shape and kind only. What needs the map (is that cell on it, is there such a proposition) is
checked where the workspace is built, so every rule is written once. Pydantic's own wording is for
programmers; :func:`faults` says the same for people, with the nearest known key where one was mistyped.
"""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Annotated, Any, ClassVar, Literal, Union

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    ValidationError,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from mitlplan.document import Fault
from mitlplan.exact import PATTERN, exact

_NUMBER_SCHEMA: dict[str, Any] = {
    "anyOf": [{"type": "number", "minimum": 0}, {"type": "string", "pattern": PATTERN}]
}


_WHOLE_SCHEMA: dict[str, Any] = {"type": "integer", "minimum": 0}
_PAIR_SCHEMA: dict[str, Any] = {"type": "array", "items": _WHOLE_SCHEMA, "minItems": 2, "maxItems": 2}


def _whole(value: object) -> int:
    """A whole number, given as one or as its text; never longer than any map is wide."""
    if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) <= 9:
        return int(value)
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return value
    raise ValueError(f"a whole number from 0 is expected, not {shorten(value)}")


def _pair(value: object) -> tuple[int, int] | None:
    match value:
        case str() | Mapping():
            return None
        case [first, last]:
            return _whole(first), _whole(last)
    return None


def _cell(value: object) -> tuple[int, int]:
    cell = _pair(value)
    if cell is None:
        raise ValueError(
            f"a cell [row, column] is expected, not {shorten(value)}; a list of one cell is [[row, column]]"
        )
    return cell


def _stretch(value: object) -> tuple[int, int]:
    stretch = _pair(value)
    if stretch is None:
        raise ValueError(f"[first, last] is expected, not {shorten(value)}; both belong to the box")
    return stretch


def _tolerance(value: object) -> Fraction:
    tolerance = exact(value)  # type: ignore[arg-type]  # exact refuses what is no number
    if tolerance == 0:
        raise ValueError("a positive number is expected, such as 1/1000")
    return tolerance


def _limit(value: object) -> Fraction:
    limit = exact(value)  # type: ignore[arg-type]  # exact refuses what is no number
    if limit == 0:
        raise ValueError("a positive number is expected; a limit that the robot does not have is left out")
    return limit


def _length(value: object) -> Fraction:
    return exact(value)  # type: ignore[arg-type]  # exact refuses what is no number


def _heading(value: object) -> str | float:
    """Radians of either sign, or a word, which is looked up where the directions of moves are known."""
    match value:
        case str() if value.isalpha():
            return value
        case str() if value.startswith("-"):
            return -float(_length(value[1:]))
        case int() | Fraction() | Decimal() if value < 0:
            return -float(_length(-value))
    return float(_length(value))


def _profile(value: object) -> Literal["even", "cubic", "quintic"]:
    match value:
        case "cubic" | "quintic":
            return "cubic" if value == "cubic" else "quintic"
        case True | "true":
            return "cubic"
        case False | "false":
            return "even"
    raise ValueError(f"true, false, cubic or quintic is expected, not {shorten(value)}")


def _version(value: object) -> int:
    if value not in (1, "1"):
        raise ValueError(f"version 1 of the format is read here, not {shorten(value)}")
    return 1


def _flag(value: object) -> bool:
    match value:
        case bool():
            return value
        case "true" | "false":
            return value == "true"
    raise ValueError(f"true or false is expected, not {shorten(value)}")


def _name(value: object) -> str:
    # What cannot be printed could steer the terminal on which the name is shown later.
    if isinstance(value, str) and value and value.isprintable():
        return value
    raise ValueError(f"a name is expected, not {shorten(value)}")


def _formula(value: object) -> str:
    if isinstance(value, str) and "".join(value.split()).isprintable():
        return value
    given = shorten(value)
    raise ValueError(f"a formula is expected, not {given}; several are named, as in {{one: F A, two: F B}}")


Whole = Annotated[int, PlainValidator(_whole), WithJsonSchema(_WHOLE_SCHEMA)]
Cell = Annotated[tuple[int, int], PlainValidator(_cell), WithJsonSchema(_PAIR_SCHEMA)]
Stretch = Annotated[tuple[int, int], PlainValidator(_stretch), WithJsonSchema(_PAIR_SCHEMA)]
Version = Annotated[int, PlainValidator(_version), WithJsonSchema({"const": 1})]
Flag = Annotated[bool, PlainValidator(_flag), WithJsonSchema({"type": "boolean"})]
Name = Annotated[str, PlainValidator(_name), WithJsonSchema({"type": "string", "minLength": 1})]
Tolerance = Annotated[Fraction, PlainValidator(_tolerance), WithJsonSchema(_NUMBER_SCHEMA)]
_LIMIT_SCHEMA: dict[str, Any] = {
    "anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string", "pattern": PATTERN}]
}
Limit = Annotated[Fraction, PlainValidator(_limit), WithJsonSchema(_LIMIT_SCHEMA)]
Length = Annotated[Fraction, PlainValidator(_length), WithJsonSchema(_NUMBER_SCHEMA)]
Heading = Annotated[
    Union[str, float],
    PlainValidator(_heading),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string", "minLength": 1}]}),
]
RestToRest = Annotated[
    Literal["even", "cubic", "quintic"],
    PlainValidator(_profile),
    WithJsonSchema({"anyOf": [{"type": "boolean"}, {"enum": ["cubic", "quintic"]}]}),
]
Formula = Annotated[str, PlainValidator(_formula), WithJsonSchema({"type": "string", "minLength": 1})]
# Read by the workspace's builder, which knows what a move's time may be.
Time = Annotated[
    Any,
    WithJsonSchema(
        {
            "anyOf": [
                *_NUMBER_SCHEMA["anyOf"],
                {"type": "array", "items": _NUMBER_SCHEMA, "minItems": 2, "maxItems": 2},
            ]
        }
    ),
]


class Keys(BaseModel):
    """A mapping with fixed keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=False)
    not_yet: ClassVar[tuple[str, ...]] = ()
    until_then: ClassVar[str] = "leave it out"

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            example = {"keys": ", ".join(f"{key}: ..." for key in list(cls._keys())[:2])}
            raise PydanticCustomError("shape", "keys with values are expected, such as {keys}", example)
        known = cls._keys()
        for key in data:
            if key in cls.not_yet:
                found = {"key": key, "advice": cls.until_then}
                raise PydanticCustomError("key", "'{key}' is not yet supported; {advice}", found)
            if key not in known:
                found = {"key": key, "shown": shorten(key), "advice": _advise_key(str(key), known)}
                raise PydanticCustomError("key", "unknown key {shown}; {advice}", found)
        for key, field in known.items():
            if field and key not in data:
                raise PydanticCustomError("shape", "the key '{key}' is missing", {"key": key})
        return data

    @classmethod
    def _keys(cls) -> dict[str, bool]:
        """Each key as it is written in the file, and whether it is required."""
        return {field.alias or name: field.is_required() for name, field in cls.model_fields.items()}


def _advise_key(key: str, known: Mapping[str, bool]) -> str:
    # No more of it: with a key of megabytes, comparing takes minutes and gigabytes.
    close = difflib.get_close_matches(key[:100], known, n=1, cutoff=0.6)
    return f"did you mean '{close[0]}'?" if close else f"the keys here are {', '.join(known)}"


class BoxKeys(Keys):
    """A box of cells, both ends included."""

    rows: Stretch
    columns: Stretch


def _part_kind(value: object) -> str:
    return "box" if isinstance(value, (Mapping, BoxKeys)) else "cell"


def _region_kind(value: object) -> str:
    return "box" if isinstance(value, (Mapping, BoxKeys)) else "list"


Part = Annotated[Annotated[Cell, Tag("cell")] | Annotated[BoxKeys, Tag("box")], Discriminator(_part_kind)]
Region = Annotated[
    Annotated[list[Part], Tag("list")] | Annotated[BoxKeys, Tag("box")], Discriminator(_region_kind)
]


class MoveKeys(Keys):
    """A move between two cells; `time` is exact or [least, most], and 0 means any positive stay."""

    origin: Name = Field(alias="from")
    target: Name = Field(alias="to")
    time: Time
    both: Flag = False


class KindKeys(Keys):
    """What every kind of workspace has."""

    waiting: Flag = False
    propositions: list[Name] = Field(
        default=[], description="Propositions that formulas may name although no region carries them."
    )


class GraphKeys(KindKeys):
    """Named cells with their propositions, and the moves between them."""

    cells: dict[Name, list[Name]]
    moves: list[MoveKeys] = []


class SquaresKeys(KindKeys):
    """What the kinds made of square cells have."""

    move_time: Time = 1
    neighbours: Annotated[Whole, WithJsonSchema({"enum": [4, 8]})] = 4
    diagonal_time: Time = None
    regions: dict[Name, Region] = {}


class GridKeys(SquaresKeys):
    """A grid; cells are called r{row}c{column}, row 0 at the top."""

    rows: Whole
    columns: Whole
    blocked: list[Part] = []


class MovingaiKeys(SquaresKeys):
    """A map of the MovingAI benchmarks; the path is relative to the mission file."""

    file: Name


class WorkspaceKeys(Keys):
    """The map: exactly one kind."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1, "maxProperties": 1})
    not_yet = ("occupancy", "route_graph", "polygons")
    until_then = "use graph, grid or movingai"

    graph: GraphKeys | None = None
    grid: GridKeys | None = None
    movingai: MovingaiKeys | None = None

    @model_validator(mode="before")
    @classmethod
    def _one_kind(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and len(data) != 1:
            given = f", not {len(data)} ({', '.join(map(str, data))})" if data else ""
            raise PydanticCustomError(
                "shape",
                "exactly one kind of workspace is expected: graph, grid or movingai{given}",
                {"given": given},
            )
        return data


def _start_kind(value: object) -> str:
    return "name" if isinstance(value, str) else "cell"


class RobotKeys(Keys):
    """The robot: where it starts, as a cell's name or [row, column], and what it can do.

    With a speed, the moves take as long as the robot needs for them; the other keys say more of it. Only
    `retime` and `deadline`, which change no plan but how it is driven, do without.
    """

    start: Annotated[Annotated[Name, Tag("name")] | Annotated[Cell, Tag("cell")], Discriminator(_start_kind)]
    speed: Limit | None = Field(default=None, description="Metres a second; moves take their times from it.")
    turn_rate: Limit | None = Field(default=None, description="Radians a second.")
    acceleration: Limit | None = Field(default=None, description="Metres a second squared.")
    turn_acceleration: Limit | None = Field(default=None, description="Radians a second squared.")
    heading: Heading | None = Field(
        default=None, description="How it faces at first: radians, or east, northeast, north, ..."
    )
    radius: Length = Field(default=Fraction(0), description="Of the disc that covers it, in metres.")
    headings: Flag = Field(
        default=False, description="Whether a move takes as long as its own turn; cells are then r0c1@east."
    )
    rest_to_rest: RestToRest = Field(
        default=False,
        validate_default=True,
        description="Whether every motion begins and ends at rest; true is cubic.",
    )
    retime: Flag = Field(
        default=False,
        description="Whether trajectories take the time that the mission leaves, to cost less.",
    )
    deadline: Limit | None = Field(default=None, description="When a retimed plan ends at the latest.")

    @model_validator(mode="after")
    def _belong_together(self) -> RobotKeys:
        if self.deadline is not None and not self.retime:
            raise PydanticCustomError(
                "key", "'{key}' needs retime: true; otherwise a plan keeps its times", {"key": "deadline"}
            )
        limits = self.model_fields_set - {"start", "retime", "deadline"}
        set_here = (key for key in type(self).model_fields if key in limits)
        given = [key for key in set_here if getattr(self, key) is not None]
        if given and self.speed is None:
            raise PydanticCustomError(
                "key",
                "'{key}' needs the robot's speed, from which the times of moves are computed",
                {"key": given[0]},
            )
        sudden = [key for key in given if key.endswith("acceleration")]
        if sudden and self.rest_to_rest == "even":
            raise PydanticCustomError(
                "key",
                "'{key}' needs rest_to_rest: true; otherwise the controls jump, which no acceleration allows",
                {"key": sudden[0]},
            )
        return self


def _spec_kind(value: object) -> str:
    return "named" if isinstance(value, Mapping) else "one"


class MissionKeys(Keys):
    """A mission: a map, a robot on it, and what the robot has to do, when."""

    version: Version = Field(alias="mitlplan", description="The version of the format.")
    workspace: WorkspaceKeys
    robot: RobotKeys
    spec: Annotated[
        Annotated[Formula, Tag("one")] | Annotated[dict[Name, Formula], Tag("named")],
        Discriminator(_spec_kind),
    ]
    horizon: Literal["infinite", "finite"] = "infinite"
    until: Literal["standard", "closed"] = "standard"
    epsilon: Tolerance = Field(
        default="1/1000",
        validate_default=True,
        description="Seconds within which a plan comes to a least makespan that none attains.",
    )


def faults(error: ValidationError, data: object) -> Iterator[Fault]:
    """What a validation of `data` found, in sentences."""
    for detail in error.errors(include_url=False):
        loc, key = detail["loc"], detail.get("ctx", {}).get("key")
        if loc[-1:] == ("[key]",):
            loc, key = loc[:-2], loc[-2]
        yield Fault(_sentence(detail), _path(loc, data), None if key is None else str(key))


def _path(loc: tuple[str | int, ...], data: object) -> tuple[str | int, ...]:
    """`loc` without what stands for a branch of a union, where the data has no level."""
    path: list[str | int] = []
    for step in loc:
        match data, step:
            case Mapping(), _ if step in data:
                data = data[step]
            case Sequence(), int() if step < len(data):
                data = data[step]
            case _:
                continue
        path.append(step)
    return tuple(path)


def _sentence(detail: ErrorDetails) -> str:
    given = shorten(detail["input"])
    context = detail.get("ctx", {})
    match detail["type"]:
        case "value_error":
            return str(context["error"])
        case "literal_error":
            return f"{context['expected']} is expected, not {given}"
        case "missing":
            return f"the key '{detail['loc'][-1]}' is missing"
        case "string_type":
            return f"a text is expected, not {given}"
        case "list_type":
            return f"a list is expected, not {given}"
        case "dict_type" | "model_type":
            return f"names with values are expected, not {given}"
        case _:
            return detail["msg"]


_BRIEF = reprlib.Repr()
_BRIEF.maxstring = _BRIEF.maxother = 60


def shorten(value: object) -> str:
    """A value as Python writes it, cut short."""
    text = _BRIEF.repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
