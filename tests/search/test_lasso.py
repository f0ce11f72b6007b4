"""Loops of a small network, and how near their timetables come to an end that strict bounds leave out."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import pytest

from mitlplan.automata.transducer import Constraint, Edge, Location, Network, Relation, Transducer
from mitlplan.search.fastest import Limits
from mitlplan.search.lasso import Lasso, Timetable, lassos, timetable
from mitlplan.search.tables import Tables, tabulate
from mitlplan.workspace.abstract import abstract
from mitlplan.workspace.graph import Move, graph


def slow_walk(relation: Relation) -> Tables:
    """Three cells on the way to two others, and to and fro between these; 5/2 s from move to move."""
    long = (Constraint("x", relation, Fraction(5, 2)),)
    brake = Transducer(
        "brake",
        (Location("before"), Location("moving")),
        (Edge("before", "moving"), Edge("moving", "moving", long, resets=frozenset(("x",)))),
        (),
        (),
    )
    moves = [Move("s0", "s1"), Move("s1", "s2"), Move("s2", "a"), Move("a", "b", 1, both=True)]
    workspace = graph({"s0": [], "s1": [], "s2": [], "a": [], "b": []}, moves, waiting=True)
    return tabulate(Network(abstract(workspace, 0), (brake,), {}), objective=False)


def loops(tables: Tables) -> list[Lasso]:
    found = lassos(tables, Limits().begin())
    assert isinstance(found, Iterator)
    return list(found)


def timed(tables: Tables, lasso: Lasso, epsilon: Fraction) -> Timetable:
    times = timetable(tables, lasso, epsilon)
    assert times is not None
    return times


def end(lasso: Lasso, times: Timetable) -> Fraction:
    """When the first round ends."""
    return times.times[len(lasso.prefix) - 1] + times.period


def test_a_loop_has_the_least_times() -> None:
    """At a after three moves and back after five; or at b after four, and back after six."""
    tables = slow_walk(Relation.AT_LEAST)
    ends = set()
    for lasso in loops(tables):
        times = timed(tables, lasso, Fraction(1, 10))
        assert len(times.times) == len(lasso.prefix) + len(lasso.round) - 1
        ends.add((times.period, end(lasso, times)))
    assert ends == {(5, Fraction(25, 2)), (5, 15)}


@pytest.mark.parametrize("epsilon", [Fraction(1), Fraction(1, 10), Fraction(1, 1000)])
def test_strict_bounds_cost_no_more_than_epsilon(epsilon: Fraction) -> None:
    closed, strict = slow_walk(Relation.AT_LEAST), slow_walk(Relation.GREATER)
    ends = {len(lasso.prefix): end(lasso, timed(closed, lasso, epsilon)) for lasso in loops(closed)}
    near = {len(lasso.prefix): end(lasso, timed(strict, lasso, epsilon)) for lasso in loops(strict)}
    assert near.keys() == ends.keys()
    for place, least in ends.items():
        assert least < near[place] <= least + epsilon
