"""Limits of time and memory, progress, and Ctrl-C: what stops a search, and what is known then."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from mitlplan.mission import mission_from_mapping
from mitlplan.plan import LimitReached, Plan
from mitlplan.planner import Progress, plan
from tests.search.long_missions import HARD, long_mission

TOLERATED = 5.0
"""Seconds: 0.2 s or a tenth are promised, on a machine that has nothing else to do. Here other tests run, so
this only tells a search that stops from one that does not."""


@pytest.mark.parametrize("name", HARD)
@pytest.mark.parametrize("limit", [0.3, 2.0])
def test_time_limit(name: str, limit: float) -> None:
    mission = mission_from_mapping(long_mission(name))
    begin = time.monotonic()
    outcome = plan(mission, time_limit=limit)
    took = time.monotonic() - begin
    assert isinstance(outcome, LimitReached)
    assert f"the time limit of {limit:g} s was reached" in outcome.reason
    assert outcome.bound is not None
    assert outcome.bound >= 0
    assert took <= limit * 1.1 + TOLERATED


def test_a_longer_search_knows_more() -> None:
    mission = mission_from_mapping(long_mission("many goals"))
    short, longer = (plan(mission, memory_limit=megabytes) for megabytes in (4, 40))
    assert isinstance(short, LimitReached)
    assert isinstance(longer, LimitReached)
    assert short.bound is not None
    assert longer.bound is not None
    assert 0 < short.bound < longer.bound
    assert short.statistics.zones < longer.statistics.zones


@pytest.mark.parametrize("name", ["many goals", "loops"])
def test_memory_limit(name: str) -> None:
    outcome = plan(mission_from_mapping(long_mission(name)), memory_limit=3, time_limit=30)
    assert isinstance(outcome, LimitReached)
    assert "the memory limit of 3 MB was reached" in outcome.reason


def test_memory_limit_is_the_same_every_time() -> None:
    mission = mission_from_mapping(long_mission("many goals"))
    first, second = (plan(mission, memory_limit=10) for _ in range(2))
    assert isinstance(first, LimitReached)
    assert isinstance(second, LimitReached)
    assert (first.reason, first.bound) == (second.reason, second.bound)


def test_progress() -> None:
    """States only become more, and what is proved stays proved."""
    seen: list[Progress] = []
    outcome = plan(mission_from_mapping(long_mission("many goals")), time_limit=2, progress=seen.append)
    assert isinstance(outcome, LimitReached)
    assert len(seen) >= 5
    assert all(one.states <= after.states for one, after in pairwise(seen))
    assert seen[0].states < seen[-1].states
    assert all(one.seconds < after.seconds for one, after in pairwise(seen))
    bounds = [one.lower_bound for one in seen]
    assert None not in bounds
    assert bounds == sorted(bounds)  # type: ignore[type-var]
    assert outcome.bound is not None
    assert bounds[-1] is not None
    assert bounds[-1] <= outcome.bound


def test_the_lower_bound_never_exceeds_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """With slices of no time at all the bound is reported after every few states."""
    monkeypatch.setattr("mitlplan.search.fastest.SLICE", 0.0)
    data = long_mission("many goals")
    data["spec"] = "F (g0 & F[2,40] g1) & F (g2 & F[2,40] g3) & F (g4 & F[2,40] g0)"
    seen: list[Progress] = []
    outcome = plan(mission_from_mapping(data), progress=seen.append)
    assert isinstance(outcome, Plan)
    bounds = [one.lower_bound for one in seen if one.lower_bound is not None]
    assert len(set(bounds)) >= 3
    assert bounds == sorted(bounds)
    assert bounds[-1] <= outcome.makespan


@pytest.mark.parametrize("name", HARD)
def test_interrupt_in_process(name: str) -> None:
    """Ctrl-C ends the native search by an exception, even in the midst of one state."""
    mission = mission_from_mapping(long_mission(name))
    sent: list[float] = []

    def send() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.7, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            plan(mission, time_limit=20)
        took = time.monotonic() - sent[0]
    finally:
        timer.cancel()
    assert took <= TOLERATED, "half a second is promised"


def test_interrupt(tmp_path: Path, record_property: Callable[[str, object], None]) -> None:
    """A real Ctrl-C on the command line, a while after the search has begun."""
    file = tmp_path / "mission.json"
    file.write_text(json.dumps(long_mission("many goals")), encoding="utf-8")
    process = subprocess.Popen(  # noqa: S603  # the interpreter that runs this test
        [sys.executable, "-m", "mitlplan", "plan", str(file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    # The first sign of progress comes after a second of searching.
    first = process.stderr.read(10)
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=20)
    took = time.monotonic() - begin
    assert process.returncode == 130
    assert output == ""
    assert first.strip().startswith("searching")
    assert errors.endswith("mitlplan: interrupted\n")
    assert took <= TOLERATED, "half a second is promised"
    record_property("interrupted after", took)
