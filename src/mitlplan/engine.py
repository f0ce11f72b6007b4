"""Plans by way of the exported model: whatever finds a fastest trace of timed automata can be the engine.

The straight line of :mod:`mitlplan.planner` searches transducers in lock step, with an engine made for them.
The same mission is also a network that any tool for timed automata can search (:mod:`mitlplan.models`), and
such a tool is an :class:`Engine`: a function from a network and a query to a trace with exact times, or a
proof that there is none. Two exist: :func:`mitlplan.search.reach.reach`, and UPPAAL's verifier
(:mod:`mitlplan.formats.verifyta`). From the trace the robot's stays are read off, and the judge decides as
over every plan: an engine is trusted for its "no", and for "fastest".

Plans that end or park are what such a network asks for, not those that go round for ever. The published model
of Zhou, Maity and Baras asks for less: its runs stop when one window of every timed eventuality is verified,
and the paper repeats them from the cell where they stop. What it finds is shown with what the judge says.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from fractions import Fraction
from typing import Protocol

from mitlplan.automata.lockstep import PARKED
from mitlplan.automata.timed_automaton import Network, Query
from mitlplan.automata.trace import stays
from mitlplan.check import check
from mitlplan.compose import core_of
from mitlplan.errors import OutOfTime, ToolError
from mitlplan.logic.normalize import accomplishable
from mitlplan.mission import Mission
from mitlplan.models import Construction, MissionModel, model_of_mission
from mitlplan.plan import Infeasible, LimitReached, Loop, Outcome, Plan, Statistics, Step
from mitlplan.search.fastest import Limits, Stopped
from mitlplan.search.reach import Reachable, Reached, Unknown, Unreachable
from mitlplan.slack import slack_of


class Engine(Protocol):
    """Finds the fastest trace of a network to a target of a query."""

    def __call__(
        self, network: Network, query: Query, limits: Limits | None = None, *, epsilon: Fraction = ...
    ) -> Reachable:
        """The answer; where no trace attains the least time, one that comes within `epsilon` of it."""


def plan_by(
    engine: Engine,
    mission: Mission,
    *,
    name: str,
    construction: Construction = "compact",
    limits: Limits | None = None,
) -> Outcome:
    """The fastest plan for a mission that ends or parks, found by `engine` and checked by the judge.

    By the published construction it may be none, and then has a `fault`.

    Parameters
    ----------
    name
        What the engine is called in statistics and sentences.
    construction
        How formulas become automata.
    limits
        None by default.

    Returns
    -------
    Plan, Infeasible or LimitReached
        Infeasible only where no plan that goes round for ever is to be considered, and never by the published
        construction, which misses plans.

    Raises
    ------
    ToolError
        If what the engine found is no plan though the construction is sound, or it cannot be asked.
    TranslationError
        If that construction cannot express the formula.

    Examples
    --------
    >>> from mitlplan.mission import mission_for
    >>> from mitlplan.search.reach import reach
    >>> from mitlplan.workspace import grid
    >>> workspace = grid(2, 2, regions={"A": [(1, 0)], "B": [(0, 1)]})
    >>> print(plan_by(reach, mission_for(workspace, "(!A U B) & F A", start="r0c0"), name="reach"))
    0 r0c0 -> 1 r0c1 -> 2 r0c0 -> 3 r1c0
    """
    limits = (Limits() if limits is None else limits).begin()
    seconds: dict[str, float] = {}
    with _stage(seconds, "translate"):
        model = model_of_mission(mission, construction, stopped_clocks=False)
    with _stage(seconds, "search"):
        answer = engine(model.network, model.query, limits, epsilon=mission.epsilon)
    if construction == "published":
        outcome = _published_outcome(mission, model, answer, name)
    else:
        outcome = _outcome(mission, model, answer, name)
    if isinstance(outcome, Plan):
        with _stage(seconds, "check"):
            fault = check(mission, outcome)
        outcome = replace(outcome, checked=fault is None, fault=fault)
        if fault is not None and construction != "published":
            raise ToolError(f"the engine {name} found what is no plan: {fault}")
        if fault is None:
            # A plan in hand is given away whatever happens now.
            with _stage(seconds, "slack"), suppress(OutOfTime, MemoryError):
                slack = slack_of(mission.workspace, core_of(mission), mission.horizon, outcome, limits)
                steps = (replace(step, slack=one) for step, one in zip(outcome.steps, slack, strict=True))
                outcome = replace(outcome, steps=tuple(steps))
    return replace(outcome, statistics=_statistics(model, answer, name, construction, seconds))


@contextmanager
def _stage(seconds: dict[str, float], name: str) -> Iterator[None]:
    begin = time.perf_counter()
    try:
        yield
    finally:
        seconds[name] = time.perf_counter() - begin


def _published_outcome(mission: Mission, model: MissionModel, answer: Reachable, name: str) -> Outcome:
    """What the published construction finds, none of which proves anything."""
    match answer:
        case Reached():
            found = plan_of_trace(mission, model, answer)
            ends = mission.horizon == "finite" or all(accomplishable(each.formula) for each in mission.spec)
            return found if ends else repeated(found)
        case Unreachable():
            return LimitReached(
                "the published construction accepts no run; since it misses plans, this proves nothing"
            )
        case _:
            outcome = _outcome(mission, model, answer, name)
            return replace(outcome, bound=None) if isinstance(outcome, LimitReached) else outcome


def repeated(plan: Plan) -> Plan:
    """The plan that goes on from the cell it ends in as it did when it was first there.

    The paper's reading of a run for a mission without an end. A plan that is nowhere twice stays as it is.

    Examples
    --------
    >>> stops = (("home", 0, 1), ("dock", 1, 2), ("home", 2, 2))
    >>> steps = tuple(Step(cell, Fraction(enter), Fraction(leave)) for cell, enter, leave in stops)
    >>> print(repeated(Plan(steps, Fraction(2))))
    0 home -> 1 dock -> 2 home, and so on
    """
    *before, last = plan.steps
    if plan.loop is not None or last.leave != last.enter:
        return plan
    start = next((number for number, step in enumerate(before) if step.cell == last.cell), None)
    if start is None:
        return plan
    return replace(plan, steps=tuple(before), loop=Loop(start, last.enter - before[start].enter))


def _outcome(mission: Mission, model: MissionModel, answer: Reachable, name: str) -> Outcome:
    # Beside a plan that parks there may be a faster one that goes round; without one there may still be.
    finite = mission.horizon == "finite" or all(accomplishable(each.formula) for each in mission.spec)
    match answer:
        case Reached():
            found = plan_of_trace(mission, model, answer)
            return replace(found, bound=min(answer.bound, found.makespan) if finite else None)
        case Unreachable() if finite:
            return Infeasible("every run of the robot on this map violates the mission")
        case Unreachable():
            return LimitReached(
                "there is no plan that ends or parks; one that goes round for ever is sought by the engine "
                f"zones, not by {name}"
            )
        case Unknown():
            return LimitReached(
                f"what {name} found cannot be made at any times: zones over-approximate where clocks stand "
                "still; nothing is known"
            )
        case Stopped():
            return LimitReached(answer.reason, answer.lower_bound if finite else None)


def plan_of_trace(mission: Mission, model: MissionModel, found: Reached) -> Plan:
    """What the robot does in a trace of the model of `mission`; nobody has checked it yet."""
    workspace, trace = mission.workspace, found.trace
    entered = stays(model.network, trace, 0, model.cells)
    parks = PARKED in found.target.locations.values()
    leaves = [*(enter for _, enter in entered[1:]), None if parks else trace.end]
    steps = tuple(
        Step(workspace.names[cell], enter, leave, tuple(sorted(workspace.holds(cell))), Fraction(0))
        for (cell, enter), leave in zip(entered, leaves, strict=True)
    )
    plan = Plan(
        steps,
        trace.least,
        Loop(len(steps) - 1, None) if parks else None,
        attained=trace.attained,
        epsilon=None if trace.attained else mission.epsilon,
    )
    arrival = steps[-1].enter
    if parks and arrival <= trace.least:
        # The automata needed longer to see that nothing is left to do than the robot to get there.
        return replace(plan, makespan=arrival, attained=True, epsilon=None)
    return plan


def _statistics(
    model: MissionModel, answer: Reachable, name: str, construction: str, seconds: Mapping[str, float]
) -> Statistics:
    automata = model.network.automata
    return Statistics(
        construction,
        sum(len(automaton.locations) for automaton in automata),
        sum(len(automaton.edges) for automaton in automata),
        answer.states if isinstance(answer, Stopped) else answer.effort.stored,
        dict(seconds),
        name,
    )
