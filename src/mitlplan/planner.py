"""The straight line from a mission to a checked plan.

    mission -> core formula -> transducers -> network -> tables -> run -> timed path -> plan -> check

:func:`plan` composes these arrows; each can be used alone. The same line, on a workspace in which anything
may happen at any time, decides whether a formula is satisfiable.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from typing import Any, TypeAlias, Union, overload
from typing import Literal as Choice

from mitlplan.automata.transducer import Network
from mitlplan.check import check, signal_of
from mitlplan.compose import Construction, compose, core_of
from mitlplan.endless import Loops, Question, Round, any_loop, fastest_loop
from mitlplan.errors import OutOfTime, TranslationError
from mitlplan.exact import Number
from mitlplan.logic.core import (
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Disjunction,
    Literal,
    Truth,
    holds,
)
from mitlplan.logic.formula import Formula, Iff, Not
from mitlplan.logic.normalize import accomplishable, normalize
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Signal
from mitlplan.mission import Horizon, Mission, Spec, UntilKind, mission_for
from mitlplan.plan import Infeasible, LimitReached, Loop, Outcome, Plan, Statistics, Step
from mitlplan.search.fastest import Exhausted, Found, Limits, Progress, Stopped, fastest_run
from mitlplan.search.schedule import STANDS_STILL, schedule
from mitlplan.search.tables import Tables, tabulate, ticks_per_second
from mitlplan.slack import slack_of
from mitlplan.translation.compact.relax import can_end, parked_label
from mitlplan.translation.compact.translate import translate
from mitlplan.workspace.universal import universal
from mitlplan.workspace.workspace import Workspace

__all__ = [
    "Answer",
    "Progress",
    "Satisfiable",
    "Unsatisfiable",
    "compose",
    "equivalent",
    "plan",
    "satisfiable",
    "valid",
]

MOST_ATOMS = 12
"""Of a formula to be decided."""

Report: TypeAlias = Callable[[Progress], None]


@dataclass(frozen=True, slots=True)
class Satisfiable:
    """A signal that satisfies the formula; it repeats, or anything may follow it."""

    signal: Signal


@dataclass(frozen=True, slots=True)
class Unsatisfiable:
    """A proof that no signal satisfies the formula: the search was exhausted."""


Answer: TypeAlias = Union[Satisfiable, Unsatisfiable, LimitReached]


@overload
def plan(
    mission: Mission,
    *,
    construction: Construction = ...,
    time_limit: float | None = ...,
    memory_limit: int | None = ...,
    progress: Report | None = ...,
    since: float | None = ...,
) -> Outcome: ...


@overload
def plan(
    mission: Workspace,
    spec: Spec,
    *,
    start: str | tuple[int, int],
    horizon: Horizon = ...,
    until: UntilKind = ...,
    epsilon: Number = ...,
    construction: Construction = ...,
    time_limit: float | None = ...,
    memory_limit: int | None = ...,
    progress: Report | None = ...,
    since: float | None = ...,
) -> Outcome: ...


def plan(
    mission: Mission | Workspace,
    spec: Spec | None = None,
    *,
    construction: Construction = "compact",
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Report | None = None,
    since: float | None = None,
    **reading: Any,
) -> Outcome:
    """The fastest plan for a mission, checked by the independent judge.

    Parameters
    ----------
    mission
        What is to be done, and where; or where alone, with `spec`.
    spec
        What is to be done on a workspace: a formula or its text, or several by their names.
    **reading
        With a workspace, `start` and whatever else :func:`mitlplan.mission.mission_for` takes.
    construction
        How formulas become automata: ``"seed"`` is the repaired construction of the paper, and cannot
        express everything.
    time_limit, memory_limit
        When to give up: seconds and megabytes. Searches look at them, and the way from one stage to
        the next does.
    progress
        Called a few times a second while the search goes on.
    since
        From when the time limit counts, by :func:`time.monotonic`; from now on if it is not said.

    Returns
    -------
    Plan, Infeasible or LimitReached
        A plan has passed the judge; infeasible is a proof.

    Raises
    ------
    MitlplanError
        If the formulas cannot be read or translated, or the start is on no cell of the workspace.

    Examples
    --------
    >>> from mitlplan.workspace import grid
    >>> workspace = grid(2, 2, regions={"A": [(1, 0)], "B": [(0, 1)]})
    >>> print(plan(workspace, "(!A U B) & F A", start="r0c0"))
    0 r0c0 -> 1 r0c1 -> 2 r0c0 -> 3 r1c0
    """
    limits = Limits(time_limit, memory_limit, progress, since).begin()
    mission = _mission(mission, spec, reading)
    planning = _planning(mission, limits, construction)
    outcome = planning.outcome()
    match outcome:
        case Plan():
            with planning.stage("check"):
                fault = check(mission, outcome)
            if fault is not None:
                raise AssertionError(f"the plan found does not pass the judge, a defect of mitlplan: {fault}")
            # A plan in hand is given away whatever happens now.
            with suppress(OutOfTime, MemoryError):
                outcome = planning.with_slack(outcome)
            return replace(outcome, checked=True, statistics=planning.statistics())
        case Infeasible():
            with planning.stage("conflict"):
                conflict = _conflict(mission, limits)
            return replace(outcome, conflict=conflict, statistics=planning.statistics())
        case LimitReached():
            return outcome


def _mission(mission: Mission | Workspace, spec: Spec | None, reading: Mapping[str, Any]) -> Mission:
    if isinstance(mission, Workspace):
        if spec is None:
            raise TypeError("on a workspace there is nothing to plan without a spec")
        return mission_for(mission, spec, **reading)
    if spec is not None or reading:
        raise TypeError("a mission has its own spec and start; give these with a workspace")
    return mission


class _Planning:
    """One mission on its way down the line."""

    def __init__(self, question: Question, horizon: Choice["infinite", "finite"], limits: Limits) -> None:
        self.question = question
        self.horizon = horizon
        self.limits = limits
        self.seconds: dict[str, float] = {}
        self.states = 0
        self.size = (0, 0)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin

    def outcome(self, *, fastest: bool = True) -> Outcome:
        """The answer; not `fastest`: any plan will do."""
        try:
            return self.sought(fastest=fastest)
        except OutOfTime:
            return LimitReached(self.limits.out_of_time, Fraction(0), self.statistics())

    def sought(self, *, fastest: bool) -> Outcome:
        """The answer, if there is time for all stages."""
        question = self.question
        self.limits.look()
        with self.stage("translate"):
            network = compose(
                question.workspace,
                question.starts,
                question.core,
                horizon=self.horizon,
                construction=question.construction,
            )
            self.size = _size(network)
            # What no tables could hold is refused, whether they are needed or not.
            ticks_per_second(network)
        endless = self.horizon == "infinite" and not all(map(accomplishable, question.formulas))
        # Where no run can end or park, only loops need to be sought.
        endings = not endless or can_end(question.core)
        parkings = endless and self.can_park()
        best: Plan | None = None
        if endings or parkings:
            with self.stage("translate"):
                self.limits.look()
                tables = tabulate(network)
            with self.stage("search"):
                result = fastest_run(tables, self.limits, endings=endings, parkings=parkings)
            self.states += result.states
            match result:
                case Stopped(reason, reached):
                    return LimitReached(reason, reached, self.statistics())
                case Found():
                    best = self.plan_of_run(tables, result)
                case Exhausted():
                    pass
        if best is not None and not (endless and fastest):
            return replace(best, statistics=self.statistics())
        if not endless:
            return self.infeasible()
        with self.stage("loops"):
            if fastest:
                to_beat = None
                if best is not None:
                    # An infimum is beaten by any loop that attains it.
                    to_beat = best.makespan, len(best.steps) - 1 if best.attained else sys.maxsize
                try:
                    loops = fastest_loop(question, to_beat, self.limits)
                except OutOfTime:
                    loops = Loops(reason=self.limits.out_of_time)
            else:
                loops = any_loop(question, self.limits)
        self.states += loops.states
        if loops.loop is not None:
            best = self.plan_of_round(loops.loop)
        if best is not None:
            bound = min(best.makespan, loops.bound) if loops.exists is not False else best.makespan
            return replace(best, bound=bound, statistics=self.statistics())
        if loops.exists is False:
            return self.infeasible()
        return LimitReached(loops.reason, loops.bound, self.statistics())

    def can_park(self) -> bool:
        """Whether some label allows the robot to stay for ever; ``False`` is certain."""
        workspace = self.question.workspace
        wanted = parked_label(self.question.core)
        return workspace.waiting and any(holds(wanted, label) for label in workspace.label_sets)

    def infeasible(self) -> Infeasible:
        reason = "every run of the robot on this map violates the mission"
        return Infeasible(reason, statistics=self.statistics())

    def statistics(self) -> Statistics:
        locations, edges = self.size
        return Statistics(self.question.construction, locations, edges, self.states, dict(self.seconds))

    def plan_of_run(self, tables: Tables, found: Found) -> Plan:
        """A finite or parking plan."""
        workspace, epsilon = self.question.workspace, self.question.epsilon
        moves = [step for step, row in enumerate(found.path.steps) if row[0] != STANDS_STILL]
        timed = schedule(tables, found.path, epsilon, moves)
        cells = tables.arrays["move_target"][found.path.steps[moves, 0]].tolist()
        parks = found.path.last == "parking"
        leaves = [*(timed.times[step] for step in moves[1:]), None if parks else timed.times[-1]]
        steps = tuple(
            Step(workspace.names[cell], timed.times[step], leave, shown, timed.slack[step])
            for cell, step, leave, shown in zip(cells, moves, leaves, self.shown(cells), strict=True)
        )
        return Plan(
            steps,
            found.time,
            Loop(len(steps) - 1, None) if parks else None,
            attained=found.attained,
            epsilon=None if found.attained else epsilon,
            bound=found.time,
        )

    def plan_of_round(self, loop: Round) -> Plan:
        """A looping plan."""
        workspace = self.question.workspace
        steps = []
        now = Fraction(0)
        stays = (*loop.prefix, *loop.cycle)
        for stay, shown in zip(stays, self.shown([stay.cell for stay in stays]), strict=True):
            leave = now + stay.duration
            steps.append(Step(workspace.names[stay.cell], now, leave, shown, Fraction(0)))
            now = leave
        period = sum((stay.duration for stay in loop.cycle), Fraction(0))
        return Plan(tuple(steps), loop.makespan, Loop(len(loop.prefix), period))

    def with_slack(self, found: Plan) -> Plan:
        """The plan with the slack of each step, which may be more than the run that found it allows."""
        question = self.question
        with self.stage("slack"):
            slack = slack_of(question.workspace, question.core, self.horizon, found, self.limits)
        steps = (
            step if step.slack == one else replace(step, slack=one)
            for step, one in zip(found.steps, slack, strict=True)
        )
        return replace(found, steps=tuple(steps))

    def shown(self, cells: Sequence[int]) -> Iterator[tuple[str, ...]]:
        """What holds in each cell, sorted."""
        workspace = self.question.workspace
        labels = workspace.label_of[cells].tolist()
        listed = {label: tuple(sorted(workspace.label_sets[label])) for label in set(labels)}
        return map(listed.__getitem__, labels)


def _planning(mission: Mission, limits: Limits, construction: Construction = "compact") -> _Planning:
    question = Question(
        mission.workspace,
        (mission.start,),
        tuple(requirement.formula for requirement in mission.spec),
        core_of(mission),
        mission.until,
        mission.epsilon,
        construction,
    )
    return _Planning(question, mission.horizon, limits)


def _size(network: Network) -> tuple[int, int]:
    """Locations and edges of the components; the product is never built."""
    locations = network.map.location_count + sum(len(one.locations) for one in network.transducers)
    edges = len(network.map.source) + sum(len(one.edges) for one in network.transducers)
    return locations, edges


def _conflict(mission: Mission, limits: Limits) -> tuple[str, ...]:
    """A minimal set of requirements that already exclude each other: each is dropped in turn."""
    kept = list(mission.spec)
    for requirement in mission.spec:
        rest = tuple(other for other in kept if other is not requirement)
        if not rest or limits.over():
            break
        part = replace(mission, spec=rest)
        try:
            excluded = isinstance(_planning(part, limits).outcome(fastest=False), Infeasible)
        except (OutOfTime, MemoryError):
            # That there is no plan is proved all the same.
            break
        if excluded:
            kept = list(rest)
    return tuple(requirement.name for requirement in kept)


# ------------------------------------------------------------------------------------ decisions on formulas


def satisfiable(
    formula: Formula | str,
    *,
    until: UntilKind = "standard",
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Report | None = None,
    since: float | None = None,
) -> Answer:
    """Whether any right-continuous signal satisfies a formula: one that does, or a proof that none does.

    The workspace has a cell for each valuation of the atoms, and anything may happen at any time.

    Examples
    --------
    >>> satisfiable("F[1,2] A & G !A")
    Unsatisfiable()
    """
    limits = Limits(time_limit, memory_limit, progress, since).begin()
    formula = _read(formula)
    core = normalize(formula, until, horizon="infinite")
    workspace = universal(_labels_to_tell_apart(core))
    starts = tuple(range(workspace.cell_count))
    question = Question(workspace, starts, (formula,), core, until, Fraction(1, 1000))
    outcome = _Planning(question, "infinite", limits).outcome(fastest=False)
    match outcome:
        case Plan():
            signal = signal_of(outcome.steps, outcome.loop)
            if not satisfies(formula, signal, until=until):
                raise AssertionError("the witness does not pass the judge, a defect of mitlplan")
            return Satisfiable(signal)
        case LimitReached():
            return outcome
        case Infeasible():
            return Unsatisfiable()


def _read(formula: Formula | str) -> Formula:
    return parse(formula) if isinstance(formula, str) else formula


def _labels_to_tell_apart(core: Core) -> list[frozenset[str]]:
    """A label for each combination of truth values that the predicates of a formula can take."""
    predicates = translate(core).predicates.values()
    names = sorted(set().union(*(_atoms(predicate) for predicate in predicates)))
    if len(names) > MOST_ATOMS:
        raise TranslationError(
            f"the formula has {len(names)} atoms; to decide it takes a state for each of their valuations, "
            f"and at most {MOST_ATOMS} atoms are allowed"
        )
    labels: dict[tuple[bool, ...], frozenset[str]] = {}
    for count in range(len(names) + 1):
        for chosen in combinations(names, count):
            label = frozenset(chosen)
            labels.setdefault(tuple(holds(predicate, label) for predicate in predicates), label)
    return list(labels.values())


def _atoms(core: Core) -> frozenset[str]:
    match core:
        case Truth():
            return frozenset()
        case Literal(name):
            return frozenset((name,))
        case Conjunction(operands) | Disjunction(operands):
            return frozenset().union(*map(_atoms, operands))
        case CoreUntil(left, right) | CoreRelease(left, right):
            return _atoms(left) | _atoms(right)


def valid(
    formula: Formula | str,
    *,
    until: UntilKind = "standard",
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Report | None = None,
    since: float | None = None,
) -> Answer:
    """Whether every signal satisfies a formula.

    The answer speaks of the negation: a signal is a counter-example.
    """
    return satisfiable(
        Not(_read(formula)),
        until=until,
        time_limit=time_limit,
        memory_limit=memory_limit,
        progress=progress,
        since=since,
    )


def equivalent(
    formula: Formula | str,
    other: Formula | str,
    *,
    until: UntilKind = "standard",
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Report | None = None,
    since: float | None = None,
) -> Answer:
    """Whether two formulas mean the same; the answer speaks of their difference."""
    return valid(
        Iff(_read(formula), _read(other)),
        until=until,
        time_limit=time_limit,
        memory_limit=memory_limit,
        progress=progress,
        since=since,
    )
