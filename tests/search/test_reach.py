"""The search of general networks against the slow oracle, on random networks; and on damaged tables.

With closed constraints at whole seconds the oracle is exact on whole ticks. Where bounds are strict, least
times are approached: an answer on the grid of n is never too early, and with a strict bound on the way at
most a tick for each move too late. Where clocks stand still and are read, the search may say that it does not
know, but whatever else it says is true.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.protocols import csma_cd, fischer
from mitlplan import _core
from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Location,
    Network,
    Number,
    Query,
    Synchronisation,
    Target,
    Test,
    Urgency,
    Variable,
)
from mitlplan.automata.trace import execute
from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.formats.uppaal import write_uppaal
from mitlplan.formats.uppaal_query import read_query
from mitlplan.formats.uppaal_read import read_uppaal
from mitlplan.search.fastest import Limits, Progress, Stopped
from mitlplan.search.reach import Reached, Unknown, Unreachable, reach
from mitlplan.search.systems import tabulate_system
from tests.oracles.published_reach import reach as slowly
from tests.strategies import as_many

CLOCKS = ("x", "y", "z")
LATEST = Fraction(12)
CLOSED = (Relation.AT_MOST, Relation.AT_LEAST)


@st.composite
def guards(draw: st.DrawFn, relations: tuple[Relation, ...], most: int = 2) -> Guard:
    count = draw(st.sampled_from([0, 0, 1, most]))
    return tuple(
        Constraint(
            draw(st.sampled_from(CLOCKS)),
            draw(st.sampled_from(relations)),
            Fraction(draw(st.integers(0, 4))),
        )
        for _ in range(count)
    )


@st.composite
def locations(draw: st.DrawFn, name: str, relations: tuple[Relation, ...], stops: bool) -> Location:
    return Location(
        name,
        draw(guards(relations, 1)),
        frozenset(draw(st.sets(st.sampled_from(CLOCKS), max_size=1))) if stops else frozenset(),
        urgency=draw(st.sampled_from([Urgency.NORMAL] * 6 + [Urgency.URGENT, Urgency.COMMITTED])),
    )


@st.composite
def edges(draw: st.DrawFn, count: int, relations: tuple[Relation, ...], channels: tuple[str, ...]) -> Edge:
    sides = [Synchronisation(name, sends=sends) for name in channels for sends in (False, True)]
    tests = st.builds(
        Test,
        st.just(Variable("n")),
        st.sampled_from(["==", "!=", "<", "<=", ">", ">="]),
        st.integers(0, 2).map(Number),
    )
    values = st.one_of(
        st.integers(0, 2).map(Number),
        st.sampled_from(["+", "-", "*"]).map(lambda sign: Arithmetic(sign, Variable("n"), Number(1))),
    )
    return Edge(
        draw(st.integers(0, count - 1)),
        draw(st.integers(0, count - 1)),
        draw(guards(relations)),
        frozenset(draw(st.sets(st.sampled_from(CLOCKS), max_size=2))),
        draw(st.sampled_from([None, None, *sides])),
        tuple(draw(st.lists(tests, max_size=1))),
        tuple(draw(st.lists(st.builds(Assignment, st.just("n"), values), max_size=2))),
    )


@st.composite
def automata(
    draw: st.DrawFn, name: str, relations: tuple[Relation, ...], stops: bool, channels: tuple[str, ...]
) -> Automaton:
    count = draw(st.integers(1, 3))
    return Automaton(
        name,
        tuple(draw(locations(f"l{index}", relations, stops)) for index in range(count)),
        tuple(draw(st.lists(edges(count, relations, channels), min_size=1, max_size=5))),
        draw(st.integers(0, count - 1)),
    )


@st.composite
def questions(
    draw: st.DrawFn,
    *,
    relations: tuple[Relation, ...] = CLOSED,
    stops: bool = False,
    channels: tuple[str, ...] = ("pair", "all"),
) -> tuple[Network, Query]:
    names = ["P", "Q", "R"][: draw(st.integers(1, 3))]
    parts = tuple(draw(automata(name, relations, stops, channels)) for name in names)
    network = Network(
        parts, CLOCKS, (Channel("pair"), Channel("all", broadcast=True)), (BoundedInteger("n", 0, 2),)
    )
    targets = []
    for _ in range(draw(st.integers(1, 2))):
        asked = draw(st.sets(st.sampled_from(parts), max_size=2))
        named = {each.name: draw(st.sampled_from(each.locations)).name for each in sorted(asked, key=_name)}
        tests = draw(st.sampled_from([(), (Test(Variable("n"), ">=", Number(1)),)]))
        targets.append(Target(named, draw(guards(relations, 1)), tests))
    return network, Query(tuple(targets))


def _name(automaton: Automaton) -> str:
    return automaton.name


@as_many(4)
@given(questions())
def test_least_times_with_closed_bounds(question: tuple[Network, Query]) -> None:
    network, query = question
    answer, expected = reach(network, query), slowly(network, query, latest=LATEST)
    if isinstance(answer, Reached):
        assert execute(network, answer.trace, answer.target) is None
        assert answer.trace.attained
        assert answer.trace.least == answer.trace.end == answer.bound
        assert answer.trace.least == expected.time if expected else answer.trace.least > LATEST
    else:
        assert isinstance(answer, Unreachable)
        assert expected is None


@as_many(3)
@given(questions(relations=tuple(Relation)))
def test_least_times_with_strict_bounds(question: tuple[Network, Query]) -> None:
    network, query = question
    answer = reach(network, query)
    if isinstance(answer, Unreachable):
        assert slowly(network, query, resolution=3, latest=LATEST) is None
        return
    assert isinstance(answer, Reached)
    trace = answer.trace
    assert execute(network, trace, answer.target) is None
    assert answer.bound == trace.least <= trace.end <= trace.least + Fraction(1, 1000)
    # Some run comes as near to the infimum as one likes, and on a fine enough grid no run is before it.
    parts = 2 * (len(trace.moves) + 2)
    if parts <= 12 and trace.least <= 4:
        expected = slowly(network, query, resolution=parts, latest=trace.least + 1)
        assert expected is not None
        assert trace.least <= expected.time < trace.least + 1
        assert not (trace.attained and expected.time > trace.least)
        assert trace.attained or expected.time > trace.least


@as_many(3)
@given(questions(relations=tuple(Relation), channels=("all",)))
def test_who_can_hear_a_broadcast_does(question: tuple[Network, Query]) -> None:
    """A trace may have to wait until a guard of somebody who is not to hear it does not hold."""
    network, query = question
    answer = reach(network, query)
    expected = slowly(network, query, resolution=3, latest=Fraction(4))
    if isinstance(answer, Unreachable):
        assert expected is None
    else:
        assert isinstance(answer, Reached)
        assert execute(network, answer.trace, answer.target) is None
        assert answer.trace.least == answer.bound
        assert expected is None or answer.trace.least <= expected.time


@pytest.mark.parametrize("stopped", [False, True])
@pytest.mark.parametrize(
    ("guard", "least", "attained"),
    [
        ((("x", "<=", 0),), 0, False),
        ((("x", "<", 2),), 2, True),
        ((("x", "<=", 5), ("y", "<", 3)), 3, True),
        ((("x", ">=", 0), ("y", "<=", 1)), 1, False),
        ((("x", ">", 1),), 0, True),
    ],
)
def test_a_broadcast_waits_until_nobody_else_can_hear_it(
    guard: tuple[tuple[str, str, int], ...], least: int, attained: bool, stopped: bool
) -> None:
    """Whoever hears it undoes it; of several bounds of the hearer, the first to be broken counts."""
    bounds = tuple(Constraint(clock, Relation(sign), Fraction(bound)) for clock, sign, bound in guard)
    say, hear = (Synchronisation("all", sends=sends) for sends in (True, False))
    said, undone = (Assignment("n", Number(value)) for value in (1, 0))
    # A clock that stands still and is read, so that times are found by the other way of solving.
    still = (Constraint("z", Relation.AT_MOST, Fraction(0)),) if stopped else ()
    here = Location("here", stopped=frozenset({"z"} if stopped else ()))
    network = Network(
        (
            Automaton("speaker", (here,), (Edge(0, 0, still, synchronisation=say, assignments=(said,)),)),
            Automaton(
                "hearer", (Location("a"),), (Edge(0, 0, bounds, synchronisation=hear, assignments=(undone,)),)
            ),
        ),
        CLOCKS,
        (Channel("all", broadcast=True),),
        (BoundedInteger("n", 0, 2),),
    )
    answer = reach(network, Query((Target({}, (), (Test(Variable("n"), ">=", Number(1)),)),)))
    assert isinstance(answer, Reached)
    assert (answer.trace.least, answer.trace.attained) == (least, attained)


@as_many(3)
@given(questions(stops=True))
def test_stopped_clocks_never_make_an_answer_wrong(question: tuple[Network, Query]) -> None:
    network, query = question
    answer, expected = reach(network, query), slowly(network, query, resolution=2, latest=LATEST)
    match answer:
        case Reached(trace, target, bound):
            assert execute(network, trace, target) is None
            assert bound <= trace.least
            assert expected is None or bound <= expected.time
            assert trace.least >= bound
        case Unreachable():
            assert expected is None
        case _:
            assert isinstance(answer, Unknown)


@given(questions(relations=tuple(Relation), stops=True))
def test_a_model_that_is_written_and_read_has_the_same_answer(question: tuple[Network, Query]) -> None:
    network, query = question
    text = write_uppaal(network, query)
    model = read_uppaal(text.encode())
    again = reach(model.network, read_query(model.queries[0], model))
    first = reach(network, query)
    assert type(again) is type(first)
    if isinstance(first, Reached) and isinstance(again, Reached):
        assert (again.trace.least, again.trace.attained) == (first.trace.least, first.trace.attained)
        assert again.bound == first.bound


@given(questions())
def test_any_trace_is_a_trace_and_not_before_the_fastest(question: tuple[Network, Query]) -> None:
    network, query = question
    some, fastest = reach(network, query, fastest=False), reach(network, query)
    assert type(some) is type(fastest)
    if isinstance(some, Reached) and isinstance(fastest, Reached):
        assert execute(network, some.trace, some.target) is None
        assert some.trace.least >= fastest.trace.least


@given(questions(), st.integers(2, 5))
def test_scaling_all_times_scales_the_answer(question: tuple[Network, Query], factor: int) -> None:
    network, query = question
    first, second = reach(network, query), reach(*scaled(network, query, Fraction(factor, 3)))
    assert type(first) is type(second)
    if isinstance(first, Reached) and isinstance(second, Reached):
        assert second.trace.least == first.trace.least * Fraction(factor, 3)


def scaled(network: Network, query: Query, factor: Fraction) -> tuple[Network, Query]:
    def guard(each: Guard) -> Guard:
        return tuple(replace(constraint, bound=constraint.bound * factor) for constraint in each)

    changed = tuple(
        replace(
            automaton,
            locations=tuple(replace(at, invariant=guard(at.invariant)) for at in automaton.locations),
            edges=tuple(replace(edge, guard=guard(edge.guard)) for edge in automaton.edges),
        )
        for automaton in network.automata
    )
    targets = tuple(replace(target, guard=guard(target.guard)) for target in query.targets)
    return replace(network, automata=changed), Query(targets)


@pytest.mark.parametrize(
    ("processes", "visited", "stored", "transitions"),
    [(4, 268, 220, 552), (5, 977, 727, 2_290), (6, 3_458, 2_378, 9_132)],
)
def test_the_zones_of_fischer_s_protocol_are_those_of_the_literature(
    processes: int, visited: int, stored: int, transitions: int
) -> None:
    """Breadth first, inclusion in both directions, local bounds: TChecker's counts (its covreach, -s bfs)."""
    protocol = fischer(processes)
    answer = reach(protocol.network, protocol.forbidden)
    assert isinstance(answer, Unreachable)
    effort = answer.effort
    assert (effort.visited, effort.stored, effort.transitions) == (visited, stored, transitions)


def test_zones_that_lie_in_others_make_room() -> None:
    """A third of the zones of Fischer's protocol are covered in the course of the search."""
    protocol = fischer(8)
    answer = reach(protocol.network, protocol.forbidden)
    assert isinstance(answer, Unreachable)
    assert answer.effort.visited > 1.5 * answer.effort.stored
    # A zone has at most 9 x 9 bounds of 8 bytes: all the rest that a state takes is in the difference.
    assert answer.effort.bytes < 9 * 9 * 8 * answer.effort.stored


@pytest.mark.parametrize("protocol", [fischer(3), fischer(3, patient=False), csma_cd(2), csma_cd(3)], ids=str)
def test_what_protocols_prevent_and_when_the_usual_happens(protocol: Any) -> None:
    assert isinstance(reach(protocol.network, protocol.forbidden), Unreachable)
    answer = reach(protocol.network, protocol.usual)
    assert isinstance(answer, Reached)
    assert (answer.trace.least, answer.trace.attained) == (protocol.least, protocol.attained)


@pytest.mark.parametrize(
    ("options", "above"),
    [({}, Fraction(1, 1000)), ({"epsilon": Fraction(1, 4)}, Fraction(1, 4))],
    ids=["a thousandth unless said", "a quarter"],
)
def test_how_near_an_infimum_is_come_to(options: dict[str, Fraction], above: Fraction) -> None:
    late = (Constraint("x", Relation.GREATER, Fraction(3, 2)),)
    walk = Automaton("walk", (Location("here"), Location("there")), (Edge(0, 1, guard=late),))
    answer = reach(Network((walk,), clocks=("x",)), Query((Target({"walk": "there"}),)), **options)
    assert isinstance(answer, Reached)
    assert (answer.trace.least, answer.trace.attained) == (Fraction(3, 2), False)
    assert answer.trace.end == Fraction(3, 2) + above


# -- limits ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("megabytes", [1, 2, 3])
def test_a_limit_of_memory_stops_the_search_once_it_is_used(megabytes: int) -> None:
    """All the zones of seven processes take 3.8 MB, those of six 1.1 MB."""
    larger, smaller = fischer(7), fischer(6)
    stopped = reach(larger.network, larger.forbidden, Limits(megabytes=megabytes))
    assert isinstance(stopped, Stopped)
    assert stopped.reason == f"the memory limit of {megabytes} MB was reached after {stopped.states} states"
    full = reach(larger.network, larger.forbidden, Limits(megabytes=4))
    assert isinstance(full, Unreachable)
    part = Fraction(stopped.states * full.effort.bytes, full.effort.stored)
    assert megabytes / 2 < part / 1_000_000 < megabytes * 2
    enough = reach(smaller.network, smaller.forbidden, Limits(megabytes=megabytes))
    assert isinstance(enough, Unreachable) is (megabytes > 1)


def test_a_limit_of_time_stops_the_search() -> None:
    protocol = fischer(7)
    stopped = reach(protocol.network, protocol.forbidden, Limits(seconds=0))
    assert isinstance(stopped, Stopped)
    assert stopped.reason == f"the time limit of 0 s was reached after {stopped.states} states"
    assert isinstance(reach(protocol.network, protocol.forbidden, Limits(seconds=1_000)), Unreachable)


def test_progress_is_told_between_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    """With slices of no time at all it is told after every few states, limit of time or not."""
    monkeypatch.setattr("mitlplan.search.fastest.SLICE", 0.0)
    protocol = fischer(5)
    for seconds in (None, 1_000):
        seen: list[Progress] = []
        answer = reach(protocol.network, protocol.forbidden, Limits(seconds, progress=seen.append))
        assert isinstance(answer, Unreachable)
        assert len(seen) >= 5
        assert seen[0].states < seen[-1].states
        assert all(0 <= one.seconds <= after.seconds < 1_000 for one, after in pairwise(seen))


# -- the border ----------------------------------------------------------------------------------------


NUMBERS = (-(2**63), -(2**31), -3, -2, -1, 0, 1, 2, 3, 7, 11, 12, 64, 2**31 - 1, 2**60, 2**63 - 1)
REFUSALS = (ValueError, OverflowError, TypeError, IndexError, MemoryError)


@as_many(4)
@given(questions(stops=True), st.booleans(), st.data())
def test_damaged_tables_are_refused_or_searched(
    question: tuple[Network, Query], objective: bool, data: st.DataObject
) -> None:
    """Whatever comes of it is an answer or a refusal: a crash would end the test run."""
    arrays = dict(tabulate_system(*question, objective=objective).arrays)
    for _ in range(data.draw(st.integers(1, 3))):
        name = data.draw(st.sampled_from(sorted(arrays)))
        column, number = arrays[name], data.draw(st.sampled_from(NUMBERS))
        if not isinstance(column, np.ndarray):
            arrays[name] = number
            continue
        match data.draw(st.sampled_from(["entry", "cut", "longer", "type", "missing"])):
            case "entry" if len(column):
                changed = column.copy()
                with suppress(OverflowError):
                    changed[data.draw(st.integers(0, len(column) - 1))] = number
                arrays[name] = changed
            case "cut":
                arrays[name] = column[: data.draw(st.integers(0, len(column)))].copy()
            case "longer":
                arrays[name] = np.append(column, column[:2])
            case "type":
                arrays[name] = column.astype(data.draw(st.sampled_from(["float64", "int8", "uint64", "O"])))
            case _:
                del arrays[name]
    with suppress(*REFUSALS):
        search = _core.Reachability(arrays, memory=50_000_000)
        if search.run(0.05, limit=0.2) == 1:
            search.path()


def test_the_border_says_what_is_missing() -> None:
    arrays = dict(tabulate_system(fischer(2).network, fischer(2).usual, objective=True).arrays)
    search = _core.Reachability(arrays)
    with pytest.raises(ValueError, match="no goal has been found"):
        search.path()
    with pytest.raises(ValueError, match="no goal has been found"):
        _ = search.goal
    with pytest.raises(ValueError, match="the tables lack program_word"):
        _core.Reachability({name: each for name, each in arrays.items() if name != "program_word"})
    deep: Any = Variable("lock")
    for _ in range(70):
        deep = Arithmetic("+", Number(1), deep)
    network = fischer(2).network
    tested = replace(network.automata[0].edges[0], tests=(Test(deep, ">", Number(0)),))
    first = replace(network.automata[0], edges=(tested, *network.automata[0].edges[1:]))
    deeper = replace(network, automata=(first, *network.automata[1:]))
    with pytest.raises(ValueError, match="nested too deeply"):
        reach(deeper, fischer(2).usual)
