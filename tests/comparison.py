"""The engine, the oracle and the judge on one small mission: what they must agree on.

* Every plan is a walk on the map, ends when it says, and satisfies the mission according to the judge.
* Where every stay has a given length the oracle is exact: same answer, same least makespan, as few moves, and
  an infimum where the oracle needs half a tick. Elsewhere the engine is at least as fast as the oracle.
* "Infeasible" only if the oracle finds no plan up to its bound; "limit" never where the oracle finds one.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import floor

from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.mission import Mission, Requirement
from mitlplan.plan import Infeasible, LimitReached, Outcome, Plan
from mitlplan.planner import plan
from tests.mission_strategies import SmallMission, parts, text_of
from tests.oracles.path_checker import fault_in_path
from tests.oracles.progression import TooLargeError, co_safe, need_of
from tests.oracles.tick_planner import Answer, Least, NoneUpTo, least_by_progression


def mission_of(small: SmallMission) -> Mission:
    """The mission as the product reads it."""
    return Mission(
        workspace=small.workspace(),
        start=small.start_index,
        spec=(Requirement("spec", text_of(small.formula), small.formula),),
        horizon=small.horizon,
        until=small.until,
    )


def bound_for(small: SmallMission) -> int:
    """How far the oracle looks, in seconds: freedom in time multiplies the plans."""
    return 8 if small.tick_timed else 6 if small.waiting else 5


def open_ended(small: SmallMission) -> bool:
    """Whether some interval leaves out one of its finite ends: then an infimum may not be attained."""
    intervals = [part.interval for part in parts(small.formula) if hasattr(part, "interval")]
    return any(one.lower_open or (one.upper_open and one.upper is not None) for one in intervals)


def oracle(small: SmallMission, bound: int) -> Answer | None:
    """What the oracle answers, ``None`` if the formula is too large for it."""
    try:
        return least_by_progression(
            small.workspace(),
            small.start_index,
            small.formula,
            bound=bound,
            until=small.until,
            horizon=small.horizon,
            resolution=2 if open_ended(small) else 1,
        )
    except TooLargeError:
        return None


LONGEST = 20.0
"""Seconds that the engine gets for a mission: most take a hundredth of one."""


def disagreements(small: SmallMission, *, longest: float = LONGEST, may_give_up: bool = False) -> list[str]:
    """Every sentence on which engine, oracle and judge differ; empty if all is well."""
    outcome = plan(mission_of(small), time_limit=longest)
    if may_give_up and isinstance(outcome, LimitReached):
        return []
    return list(_disagreements(small, outcome, oracle(small, bound_for(small))))


def _disagreements(small: SmallMission, outcome: Outcome, answer: Answer | None) -> Iterator[str]:
    match outcome:
        case Plan():
            yield from faults(small, outcome)
            if answer is not None:
                yield from _against_oracle(small, outcome, answer)
        case Infeasible():
            if isinstance(answer, Least):
                yield f"the engine says infeasible, the oracle has {answer}"
        case LimitReached(reason):
            if isinstance(answer, Least):
                yield f"the engine gives up ({reason}), the oracle has {answer}"


def faults(small: SmallMission, found: Plan) -> Iterator[str]:
    """What is wrong with a plan by itself."""
    stays = [(step.cell, step.enter) for step in found.steps]
    end = found.steps[-1].leave
    target = None
    if found.loop is not None and found.loop.period is not None:
        target = found.steps[found.loop.start].cell
    fault = fault_in_path(small, stays, end, target)
    if fault is not None:
        yield fault
        return
    if any(step.leave != after.enter for step, after in zip(found.steps, found.steps[1:], strict=False)):
        yield "a step does not end where the next begins"
    labels = dict(small.cells)
    if any(step.holds != tuple(sorted(labels[step.cell])) for step in found.steps):
        yield "a step shows other propositions than its cell carries"
    yield from _faults_in_time(small, found, found.steps[-1].enter if end is None else end)
    signal = signal_of_plan(small, found)
    if not satisfies(small.formula, signal, until=small.until, horizon=small.horizon):
        yield "the judge rejects the plan"


def _faults_in_time(small: SmallMission, found: Plan, end: Fraction) -> Iterator[str]:
    if found.attained and end != found.makespan:
        yield f"the plan ends at {end}, not at its makespan"
    if not found.attained and not found.makespan < end <= found.makespan + (found.epsilon or 0):
        yield f"the plan ends at {end}, which is no answer to an infimum of {found.makespan}"
    finite_only = small.horizon == "finite" or co_safe(need_of(small.formula, until=small.until))
    if finite_only and found.loop is not None:
        yield "a finite plan was asked for"


def signal_of_plan(small: SmallMission, found: Plan) -> Signal:
    """What the robot shows, by the labels of the mission itself."""
    labels = dict(small.cells)
    segments = tuple(Segment(step.enter, frozenset(labels[step.cell])) for step in found.steps)
    end = found.steps[-1].leave
    match found.loop:
        case None:
            assert end is not None
            return Signal(segments, end)
        case loop if end is None:
            return Signal(segments, segments[-1].start + 1, repeat_from=segments[-1].start)
        case loop:
            return Signal(segments, end, repeat_from=found.steps[loop.start].enter)


def _moves(found: Plan) -> int:
    """The moves up to the makespan, the one that closes a loop included."""
    return len(found.steps) - (found.loop is None or found.loop.period is None)


def _against_oracle(small: SmallMission, found: Plan, answer: Answer) -> Iterator[str]:
    bound = found.makespan if found.bound is None else found.bound
    match answer:
        case Least(makespan) if not small.tick_timed:
            if bound > makespan or (found.makespan > makespan and bound == found.makespan):
                yield f"the engine is slower than the oracle: {answer}"
            elif found.makespan == makespan and not found.attained:
                yield f"the engine takes for an infimum what is attained: {answer}"
        case Least(makespan):
            least, attained = Fraction(floor(makespan)), makespan.denominator == 1
            proved = bound == found.makespan
            if proved and (found.makespan, found.attained) != (least, attained):
                yield f"another least makespan: {answer}"
            elif proved and attained and _moves(found) != answer.moves:
                yield f"not the fewest moves: {answer}"
            if not bound <= least <= found.makespan:
                yield f"the least makespan is not where the engine says: {answer}"
        case NoneUpTo(limit) if small.tick_timed:
            if found.makespan < limit or (found.makespan == limit and found.attained):
                yield f"the oracle finds nothing up to {limit}"
