"""Measuring: all contestants of an instance in turns, so that what disturbs one disturbs all.

A round runs each contestant once; the median over the rounds counts. Whoever gives another answer than the
rest, or than theory, ends the benchmark: a wrong answer is no time at all.
"""

from __future__ import annotations

import gc
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from statistics import median

from benchmarks.families import Expected, Instance
from benchmarks.peers import Answer, Peer
from benchmarks.product import TooLargeError
from benchmarks.satisfiability import GivenUpError
from mitlplan.mission import Mission
from mitlplan.plan import Infeasible, LimitReached, Plan
from mitlplan.planner import plan

OURS = "mitlplan"


class WrongAnswerError(Exception):
    """Two contestants disagree, or one of them with theory."""


@dataclass
class Times:
    """What was measured of one contestant on one instance.

    Parameters
    ----------
    prepare, solve
        Seconds, one entry a round.
    stages
        Seconds of the planner's stages, one entry a round.
    states
        Stored by the planner.
    bound
        The planner has shown that no plan is faster, in seconds.
    given_up
        Why there is no answer.
    """

    prepare: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    stages: list[Mapping[str, float]] = field(default_factory=list)
    states: int = 0
    bound: Fraction | None = None
    given_up: str | None = None

    @property
    def total(self) -> float:
        """Median seconds of preparing and solving."""
        return median(a + b for a, b in zip(self.prepare, self.solve, strict=True))

    def stage(self, name: str) -> float:
        """Median seconds of a stage of the planner."""
        return median(stages.get(name, 0.0) for stages in self.stages)


@dataclass(frozen=True)
class Row:
    """One instance, measured."""

    instance: Instance
    answer: Expected
    times: Mapping[str, Times]

    @property
    def ours(self) -> Times:
        """The planner's."""
        return self.times[OURS]


@contextmanager
def alarm(seconds: float) -> Iterator[None]:
    """Ends what goes on for longer, as soon as Python gets a chance to.

    Raises
    ------
    GivenUpError
        If it did.
    """

    def ring(number: int, frame: object) -> None:
        del number, frame
        raise GivenUpError(f"over {seconds:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _planned(mission: Mission, limit: float, times: Times) -> Answer:
    begin = time.perf_counter()
    outcome = plan(mission, time_limit=limit)
    times.solve.append(time.perf_counter() - begin)
    times.prepare.append(0.0)
    times.stages.append(outcome.statistics.seconds)
    times.states = outcome.statistics.zones
    match outcome:
        case Plan():
            times.bound = outcome.bound
            return outcome.makespan
        case Infeasible():
            return None
        case LimitReached(reason):
            raise GivenUpError(reason)


def _answered(peer: Peer, times: Times) -> Answer:
    begin = time.perf_counter()
    solve = peer.prepare()
    ready = time.perf_counter()
    answer = solve()
    times.solve.append(time.perf_counter() - ready)
    times.prepare.append(ready - begin)
    return answer


def hold(instance: Instance, *, limit: float, rounds: int, budget: float, absent: Mapping[str, str]) -> Row:
    """All contestants of an instance, each `rounds` times or until the `budget` is spent, once at least.

    Parameters
    ----------
    limit
        Seconds after which a contestant gives up.
    budget
        Seconds after which no further round begins.
    absent
        Contestants that are not to be tried, and why.

    Raises
    ------
    WrongAnswerError
        If anybody is wrong.
    """
    times = {OURS: Times(), **{peer.name: Times() for peer in instance.peers}}
    runs: dict[str, Callable[[], Answer]] = {
        OURS: lambda: _planned(instance.mission, limit, times[OURS]),
        **{peer.name: _run_of(peer, times[peer.name]) for peer in instance.peers},
    }
    for name, measured in times.items():
        measured.given_up = absent.get(name)
    answer: Expected = instance.expected
    begin = time.perf_counter()
    for _ in range(rounds):
        for name, run in runs.items():
            if times[name].given_up is not None:
                continue
            gc.collect()
            try:
                # The planner keeps its limit by itself; the alarm is for when it does not.
                with alarm(limit * 1.2 if name == OURS else limit):
                    found: Expected = _as_expected(run())
            except (GivenUpError, TooLargeError) as error:
                times[name].given_up = str(error) or "product too large"
                continue
            if answer == "unknown":
                answer = found
            if found != answer:
                raise WrongAnswerError(
                    f"{instance.name} {instance.size}: {name} says {found}, but it is {answer}"
                )
        if time.perf_counter() - begin > budget:
            break
    return Row(instance, answer, times)


def ratio_in_turns(one: Mission, other: Mission, *, rounds: int) -> float:
    """How many times as long `one` takes as `other`: the medians of plans made in turns."""
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):
        for kept, mission in zip(seconds, (one, other), strict=True):
            gc.collect()
            begin = time.perf_counter()
            plan(mission)
            kept.append(time.perf_counter() - begin)
    return median(seconds[0]) / median(seconds[1])


def _run_of(peer: Peer, times: Times) -> Callable[[], Answer]:
    return lambda: _answered(peer, times)


def _as_expected(answer: Answer) -> Expected:
    return "infeasible" if answer is None else answer
