"""Traces get exact times, and only what the network can do is a trace."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.automata.timed_automaton import (
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Location,
    Network,
    Number,
    Synchronisation,
    Test,
    Urgency,
    Variable,
)
from mitlplan.automata.trace import Move, Trace, earliest, execute
from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.translation.seed.published_network import published_model
from tests.oracles.published_reach import reach
from tests.translation.seed.paper import PHI, ring

ONE, TWO, HALF = Fraction(1), Fraction(2), Fraction(1, 2)


def at_least(clock: str, bound: Fraction) -> Guard:
    return (Constraint(clock, Relation.AT_LEAST, bound),)


def at_most(clock: str, bound: Fraction) -> Guard:
    return (Constraint(clock, Relation.AT_MOST, bound),)


def one(*locations: Location, edges: tuple[Edge, ...], clocks: tuple[str, ...] = ("x", "y")) -> Network:
    return Network((Automaton("a", locations, edges),), clocks)


A, B, C = Location("A"), Location("B"), Location("C")
FIRST: Move = ((0, 0),)
SECOND: Move = ((0, 1),)


def test_the_earliest_times_are_exact() -> None:
    network = one(
        A,
        B,
        C,
        edges=(
            Edge(0, 1, at_least("x", Fraction(1, 3)), frozenset({"y"})),
            Edge(1, 2, at_least("y", Fraction(3, 7))),
        ),
    )
    trace = earliest(network, [FIRST, SECOND])
    end = Fraction(16, 21)
    assert trace == Trace((FIRST, SECOND), (Fraction(1, 3), end), attained=True, least=end, end=end)


def test_an_early_move_may_have_to_wait_for_a_late_one() -> None:
    network = one(
        A,
        replace(B, invariant=at_most("y", HALF)),
        C,
        edges=(Edge(0, 1, resets=frozenset({"y"})), Edge(1, 2, at_least("x", TWO))),
    )
    trace = earliest(network, [FIRST, SECOND])
    assert trace is not None
    assert trace.times == (Fraction(3, 2), TWO)


def test_a_strict_bound_is_an_infimum() -> None:
    later = (Constraint("x", Relation.GREATER, ONE),)
    network = one(A, B, edges=(Edge(0, 1, later),))
    trace = earliest(network, [FIRST], epsilon=Fraction(1, 100))
    assert trace is not None
    assert (trace.attained, trace.least) == (False, 1)
    assert ONE < trace.times[0] <= ONE + Fraction(1, 100)
    assert execute(network, trace) is None


def test_a_stopped_clock_stands_still() -> None:
    network = one(
        replace(A, stopped=frozenset({"x"})),
        B,
        C,
        edges=(Edge(0, 1, at_least("y", TWO)), Edge(1, 2, at_least("x", ONE))),
    )
    trace = earliest(network, [FIRST, SECOND])
    assert trace is not None
    assert trace.times == (TWO, Fraction(3))
    assert execute(network, replace(trace, times=(TWO, TWO))) == "at 2: a guard of a does not hold"


def test_times_that_contradict_each_other_are_none() -> None:
    impossible = one(replace(A, invariant=at_most("x", ONE)), B, edges=(Edge(0, 1, at_least("x", TWO)),))
    assert earliest(impossible, [FIRST]) is None
    elsewhere = one(A, B, edges=(Edge(1, 0),))
    assert earliest(elsewhere, [FIRST]) is None
    assert earliest(elsewhere, []) == Trace((), ())


@pytest.mark.parametrize("urgency", [Urgency.URGENT, Urgency.COMMITTED])
def test_no_time_passes_in_an_urgent_location(urgency: Urgency) -> None:
    network = one(replace(A, urgency=urgency), B, edges=(Edge(0, 1),))
    assert execute(network, Trace((FIRST,), (ONE,))) == "at 1: no time may pass in A"
    assert (
        earliest(one(replace(A, urgency=urgency), B, edges=(Edge(0, 1, at_least("x", ONE)),)), [FIRST])
        is None
    )


def test_invariants_are_kept_all_the_time() -> None:
    late = one(replace(A, invariant=at_least("x", ONE)), B, edges=(Edge(0, 1),))
    assert execute(late, Trace((), ())) == "at 0: the invariant x>=1 of A does not hold"
    long = one(replace(A, invariant=at_most("x", ONE)), B, edges=(Edge(0, 1),))
    assert execute(long, Trace((FIRST,), (TWO,))) == "at 2: the invariant x<=1 of A does not hold"
    entered = one(A, replace(B, invariant=at_most("x", ONE)), edges=(Edge(0, 1),))
    assert execute(entered, Trace((FIRST,), (TWO,))) == "at 2: the invariant x<=1 of B does not hold"
    assert execute(entered, Trace((FIRST, FIRST), (ONE, HALF))) == "at 1/2: time runs backwards"


def test_integers_are_counted() -> None:
    count = (
        Edge(0, 0, tests=(Test(Variable("n"), "<", Number(2)),), assignments=(Assignment("n", Number(2)),)),
    )
    network = Network((Automaton("a", (A,), count),), variables=(BoundedInteger("n", 0, 2),))
    assert execute(network, Trace((FIRST,), (ONE,))) is None
    assert execute(network, Trace((FIRST, FIRST), (ONE, ONE))) == "at 1: a guard of a does not hold"
    small = replace(network, variables=(BoundedInteger("n", 0, 1),))
    assert execute(small, Trace((FIRST,), (ONE,))) == "at 1: n leaves its range"


def talking(*, broadcast: bool) -> Network:
    send, hear = Synchronisation("c", sends=True), Synchronisation("c", sends=False)
    listener = Automaton("b", (A, B), (Edge(0, 1, synchronisation=hear), Edge(0, 1)))
    return Network(
        (
            Automaton("a", (A, B), (Edge(0, 1, synchronisation=send), Edge(0, 1))),
            listener,
            replace(listener, name="c"),
        ),
        channels=(Channel("c", broadcast),),
    )


@pytest.mark.parametrize(
    ("move", "problem"),
    [
        (((0, 0), (1, 0)), None),
        (((0, 1),), None),
        (((0, 0),), "at 0: c joins two"),
        (((0, 0), (1, 0), (2, 0)), "at 0: c joins two"),
        (((1, 0), (0, 0)), "at 0: nobody sends on c"),
        (((0, 0), (1, 1)), "at 0: an edge does not receive on c"),
        (((0, 1), (1, 1)), "at 0: edges that do not communicate are taken at once"),
    ],
)
def test_a_channel_joins_two(move: Move, problem: str | None) -> None:
    assert execute(talking(broadcast=False), Trace((move,), (Fraction(0),))) == problem


def test_a_broadcast_takes_everyone_along() -> None:
    network = talking(broadcast=True)
    everyone: Move = ((0, 0), (1, 0), (2, 0))
    assert execute(network, Trace((everyone,), (ONE,))) is None
    assert execute(network, Trace((((0, 0),),), (ONE,))) == "at 1: b would have to receive c"
    gone: Move = ((1, 1),)
    assert execute(network, Trace((gone, ((0, 0), (2, 0))), (ONE, ONE))) is None


def test_a_committed_location_is_left_first() -> None:
    network = talking(broadcast=False)
    hurried = replace(network.automata[0], locations=(replace(A, urgency=Urgency.COMMITTED), B))
    network = replace(network, automata=(hurried, *network.automata[1:]))
    assert (
        execute(network, Trace((((1, 1),),), (Fraction(0),)))
        == "at 0: a committed location has to be left first"
    )
    assert execute(network, Trace((((0, 1),), ((1, 1),)), (Fraction(0), ONE))) is None


@pytest.mark.parametrize("name", ["phi1", "phi2", "phi3"])
def test_the_papers_runs_are_executed(name: str) -> None:
    model = published_model(PHI[name], ring())
    found = reach(model.network, model.query, latest=Fraction(8))
    assert found is not None
    moves = [move for _, move in found.trace]
    trace = earliest(model.network, moves)
    assert trace is not None
    assert trace.times[-1] == found.time
    assert execute(model.network, Trace(tuple(moves), tuple(time for time, _ in found.trace))) is None
