"""Damaged tables: the native search trusts nothing that comes over the border.

Tables of real networks are damaged at random: entries replaced, columns cut, exchanged, of the wrong type or
missing. Whatever comes of it must be an answer or one of a few exceptions: a crash would end the test run,
and under the sanitizers so does every access out of bounds.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan import _core
from mitlplan.compose import compose
from mitlplan.logic.normalize import normalize
from mitlplan.logic.parse import parse
from mitlplan.search.tables import tabulate
from mitlplan.workspace.graph import Move, graph
from mitlplan.workspace.workspace import Workspace

REFUSALS = (ValueError, OverflowError, TypeError, IndexError, MemoryError)
SCALARS = ("clocks", "time_clock", "driver_clock", "words")


def small_map(*, waiting: bool) -> Workspace:
    """Three cells, with stays that are given, that are free, and that have both bounds."""
    moves = [
        Move("a", "b", 1),
        Move("b", "a", ["1/2", 2]),
        Move("b", "c", 0),
        Move("c", "a", 3),
    ]
    return graph({"a": ["A"], "b": [], "c": ["B", "A"]}, moves, waiting=waiting)


def sound_tables(formula: str, *, waiting: bool, objective: bool) -> dict[str, Any]:
    """The tables of a network that is as it should be."""
    core = normalize(parse(formula), horizon="infinite")
    network = compose(small_map(waiting=waiting), (0, 1), core)
    return dict(tabulate(network, objective=objective).arrays)


SOUND = [
    sound_tables(formula, waiting=waiting, objective=objective)
    for formula in (
        "(!A U B) & F[1,4] A",
        "G (A -> F[0,2] B)",
        "G F[1,3] B & G[0,2] (A | F[0,1) G[0,1] !B)",
        "G ((A U[1,2] B) | (B R(0,3] !A))",
    )
    for waiting in (False, True)
    for objective in (False, True)
]
COLUMNS = sorted(SOUND[0])

NUMBERS = st.sampled_from(
    (-(2**63), -(2**31), -3, -2, -1, 0, 1, 2, 3, 7, 63, 64, 65, 2**31 - 1, 2**60, 2**63 - 1)
)
TYPES = st.sampled_from(("int8", "int32", "int64", "uint8", "uint64", "float64", "bool", "complex128", "O"))


@dataclass(frozen=True)
class Damage:
    """What is done to one column."""

    kind: str
    place: int
    number: int
    type: str

    def to(self, column: Any, name: str) -> Any:
        """The damaged column."""
        if not isinstance(column, np.ndarray):
            return "three" if self.kind == "type" else self.number
        if column.ndim != 1 or column.dtype.kind not in "iu":
            return column
        count = max(1, len(column))
        match self.kind:
            case "entry" if len(column):
                return self.replaced(column, self.place % count, self.number)
            case "neighbour" if len(column):
                place = self.place % count
                return self.replaced(column, place, int(column[place]) + self.number % 5 - 2)
            case "exchange" if len(column):
                order = np.arange(count)
                order[[0, self.place % count]] = order[[self.place % count, 0]]
                return column[order]
            case "cut":
                return column[: self.place % count]
            case "longer":
                return np.concatenate([column, column[: 1 + self.place % count]])
            case "empty":
                return column[:0]
            case "type":
                return column.astype(self.type)
            case "two dimensions":
                return column.reshape(1, -1)
            case "stride":
                return column[::-1]
            case _:
                return {"none": None, "list": column.tolist(), "text": name}.get(self.kind, column)

    @staticmethod
    def replaced(column: Any, place: int, number: int) -> Any:
        """The column with another entry, reduced to what its type holds."""
        limits = np.iinfo(column.dtype)
        copy = column.copy()
        copy[place] = min(max(number, int(limits.min)), int(limits.max))
        return copy


MILD = ("entry", "neighbour", "exchange")
COARSE = ("cut", "longer", "empty", "type", "two dimensions", "stride", "none", "list", "text")


def damages(kinds: tuple[str, ...]) -> st.SearchStrategy[Damage]:
    """Damages of these kinds."""
    return st.builds(Damage, st.sampled_from(kinds), st.integers(0, 10_000), NUMBERS, TYPES)


def use(tables: Mapping[str, Any], *, record: bool) -> None:
    """Ask the search for everything it can be asked for."""
    search = _core.Search(tables, record=record, memory=20_000_000)
    for _ in range(2):
        search.run(0.002)
    assert search.stored >= 1
    assert search.visited >= 0
    assert search.bytes > 0
    assert search.lower_bound is not None
    assert len(search.goal) == 2
    sources, targets, marks = search.graph()
    assert len(sources) == len(targets) == len(marks) == len(search.recorded_driver_edges())
    for node in {0, search.stored - 1}:
        search.path_to(node)
        search.locations(node)
    for step in {0, len(sources) - 1}:
        if len(sources):
            search.recorded_edges(step)
    if search.found:
        search.path()


@pytest.mark.parametrize("index", range(len(SOUND)))
@pytest.mark.parametrize("record", [False, True])
def test_sound_tables_are_taken(index: int, record: bool) -> None:
    use(SOUND[index], record=record)


@given(
    index=st.integers(0, len(SOUND) - 1),
    done=st.lists(st.tuples(st.sampled_from(COLUMNS), damages(MILD)), min_size=1, max_size=4),
    record=st.booleans(),
)
@settings(max_examples=1000)
def test_wrong_entries(index: int, done: list[tuple[str, Damage]], record: bool) -> None:
    tables = dict(SOUND[index])
    for name, damage in done:
        tables[name] = damage.to(tables[name], name)
    with suppress(*REFUSALS):
        use(tables, record=record)


@given(
    index=st.integers(0, len(SOUND) - 1),
    name=st.sampled_from(COLUMNS),
    coarse=damages(COARSE),
    done=st.lists(st.tuples(st.sampled_from(COLUMNS), damages(MILD + COARSE)), max_size=2),
)
@settings(max_examples=300)
def test_wrong_columns(index: int, name: str, coarse: Damage, done: list[tuple[str, Damage]]) -> None:
    tables = dict(SOUND[index])
    for column, damage in [(name, coarse), *done]:
        tables[column] = damage.to(tables[column], column)
    with suppress(*REFUSALS):
        use(tables, record=False)


@pytest.mark.parametrize("name", COLUMNS)
def test_missing_columns(name: str) -> None:
    tables = {column: values for column, values in SOUND[0].items() if column != name}
    with pytest.raises(ValueError, match=f"the tables lack {name}"):
        use(tables, record=False)


@pytest.mark.parametrize("name", sorted(set(COLUMNS) - set(SCALARS)))
@pytest.mark.parametrize("value", [None, "text", 3, [1, 2], np.zeros((2, 2), dtype=np.int32)])
def test_what_is_no_column(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"the wrong type of array: {name}"):
        use(SOUND[0] | {name: value}, record=False)


@pytest.mark.parametrize("name", SCALARS)
@pytest.mark.parametrize("value", [None, "text", 2**40, -(2**40), 1.5])
def test_what_is_no_number(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"not a small integer: {name}"):
        use(SOUND[0] | {name: value}, record=False)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"clocks": 2**31 - 1}, "too many clocks"),
        ({"clocks": 1}, "the objective is no clock"),
        ({"words": 0}, "no clock or no signal"),
        ({"driver_clock": 0}, "the driver has no clock"),
        ({"component_start": np.array([0], dtype=np.int32)}, "no component"),
    ],
)
def test_messages(changes: Mapping[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"^the tables of the network are damaged: {message}$"):
        use(SOUND[1] | dict(changes), record=False)


def test_a_component_without_a_location() -> None:
    """It would have no location to start in."""
    starts = SOUND[0]["component_start"]
    for place in range(len(starts)):
        doubled = np.insert(starts, place, starts[place])
        with pytest.raises(ValueError, match="a component without a location"):
            use(SOUND[0] | {"component_start": doubled}, record=False)


def test_too_many_components() -> None:
    """Steps are enumerated by recursion over the components."""
    tables = dict(SOUND[0])
    count = 5_000
    last = tables["component_start"][-1]
    tables["component_start"] = np.append(tables["component_start"], last + 1 + np.arange(count)).astype(
        np.int32
    )
    for name, column in tables.items():
        if name.startswith("location_") or name in ("move_start", "ending_start", "parking_start"):
            tables[name] = np.append(column, np.repeat(column[-1], count))
    with pytest.raises(ValueError, match="too many components"):
        use(tables, record=False)


def test_a_clock_that_nobody_declares_active() -> None:
    """The bounds of the locations must name every clock that is read from there."""
    for tables in SOUND:
        damaged = tables | {"location_bounds": np.zeros_like(tables["location_bounds"])}
        if len(tables["guard_clock"]) and not set(tables["guard_clock"].tolist()) <= {tables["time_clock"]}:
            with pytest.raises(ValueError, match="a guard reads a clock that is not active"):
                use(damaged, record=True)


# --- Exact times along a path ------------------------------------------------------------------------------

NEVER_REACHED = -(2**63)
"""The time of a step to which no constraint leads; on a path there is none."""

small = st.integers(-5, 5)
numbers_of_steps = st.sampled_from((-2, -1, 0, 1, 2, 3, 4, 2**31 - 1, -(2**31)))


@given(
    steps=st.integers(-2, 6),
    rows=st.lists(st.tuples(numbers_of_steps, numbers_of_steps, small | NUMBERS, st.booleans()), max_size=8),
)
@settings(max_examples=300)
def test_wrong_constraints(steps: int, rows: list[tuple[int, int, int, bool]]) -> None:
    columns = (
        np.array([row[0] for row in rows], dtype=np.int32),
        np.array([row[1] for row in rows], dtype=np.int32),
        np.array([row[2] for row in rows], dtype=np.int64),
        np.array([row[3] for row in rows], dtype=np.uint8),
    )
    try:
        times = _core.earliest_times(steps, *columns)
    except REFUSALS:
        return
    for source, target, weight, strict in rows:
        if times[source][0] == NEVER_REACHED:
            continue
        assert times[target] >= (times[source][0] + weight, times[source][1] + strict)


@given(
    planned=st.lists(small | NUMBERS, max_size=5),
    rows=st.lists(st.tuples(numbers_of_steps, numbers_of_steps, small | NUMBERS, st.booleans()), max_size=8),
    asked=st.lists(numbers_of_steps, max_size=3),
)
@settings(max_examples=300)
def test_wrong_plans(planned: list[int], rows: list[tuple[int, int, int, bool]], asked: list[int]) -> None:
    """Times that were never planned so: a refusal, or bounds that are no earlier than planned."""
    columns = (
        np.array([row[0] for row in rows], dtype=np.int32),
        np.array([row[1] for row in rows], dtype=np.int32),
        np.array([row[2] for row in rows], dtype=np.int64),
        np.array([row[3] for row in rows], dtype=np.uint8),
    )
    with suppress(*REFUSALS):
        latest = _core.latest_times(
            np.array(planned, dtype=np.int64), *columns, np.array(asked, dtype=np.int32)
        )
        assert all(late == -1 or late >= planned[step] for late, step in zip(latest, asked, strict=True))


def test_planned_times_that_break_a_constraint() -> None:
    """Bounds that lean on each other would otherwise fall by a tick a round, some 10^18 times."""
    source, target = np.array([1, 2, 0], dtype=np.int32), np.array([2, 1, 3], dtype=np.int32)
    weight, strict = np.array([1, 0, 0], dtype=np.int64), np.zeros(3, dtype=np.uint8)
    planned = np.array([0, 0, 0, 2**59], dtype=np.int64)
    with pytest.raises(ValueError, match="the planned times break a constraint"):
        _core.latest_times(planned, source, target, weight, strict, np.array([1], dtype=np.int32))
