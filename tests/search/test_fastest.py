"""Limits: when the time is over, and that a search which has grown too large is given up."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mitlplan.automata.transducer import Edge, Location, Network, Transducer
from mitlplan.search.fastest import Limits, Progress, Stopped
from mitlplan.search.lasso import Lasso, lassos
from mitlplan.search.tables import Tables, tabulate
from mitlplan.workspace.abstract import abstract
from mitlplan.workspace.graph import Move, graph


def clock_face(count: int) -> Tables:
    """Two cells and a hand that may go on to the next of so many hours at any step: a state for each hour."""
    hours = [f"hour {number}" for number in range(count)]
    steps = [*zip(hours, hours, strict=True), *zip(hours, [*hours[1:], hours[0]], strict=True)]
    transducers = (
        Transducer("hand", tuple(map(Location, hours)), tuple(Edge(*step) for step in steps), (), ()),
    )
    workspace = graph({"a": [], "b": []}, [Move("a", "b", 1, both=True)], waiting=False)
    return tabulate(Network(abstract(workspace, 0), transducers, {}), objective=False)


def test_without_a_limit_time_is_never_over() -> None:
    limits = Limits().begin()
    assert limits.remaining() is None
    assert not limits.over()


def test_time_is_over_when_it_has_run_out() -> None:
    assert Limits(seconds=0.0).begin().over()
    assert not Limits(seconds=1_000.0).begin().over()


def test_a_clock_that_runs_is_not_started_again() -> None:
    old = Limits(seconds=1_000.0, started=-10_000.0)
    assert old.over()
    assert old.begin() is old
    begun = Limits(seconds=1_000.0).begin()
    remaining = begun.remaining()
    assert begun.started is not None
    assert begun.begin() is begun
    assert remaining is not None
    assert 0 < remaining <= 1_000


def test_a_search_is_given_up_that_has_grown_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """With slices of no time at all it is asked after every few states."""
    monkeypatch.setattr("mitlplan.search.fastest.SLICE", 0.0)
    tables = clock_face(300)
    seen: list[Progress] = []
    stopped = lassos(tables, Limits(progress=seen.append).begin(), most_states=100)
    assert isinstance(stopped, Stopped)
    assert stopped.reason == f"the search was given up after {stopped.states} states"
    assert stopped.lower_bound is None
    assert seen
    assert max(one.states for one in seen) <= 100 < stopped.states
    found = lassos(tables, Limits().begin(), most_states=10_000)
    assert isinstance(found, Iterator)
    assert isinstance(next(found), Lasso)
