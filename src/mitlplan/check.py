"""The check of a plan: can the robot go so, and does what it then sees satisfy the mission?

The first question is asked of the map (:mod:`mitlplan.workspace.path`), the second of the judge
(:mod:`mitlplan.logic.semantics`). Neither shares code with translation and search, so that an error there
cannot confirm itself. That no plan is faster is not checked here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from mitlplan.logic.explain import explain
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.mission import Mission
from mitlplan.plan import Loop, Plan, Step
from mitlplan.workspace.path import ending, follows

_PARKED = Fraction(1)
"""How long one round of staying for ever is taken to be: any positive number would do."""


def check(mission: Mission, plan: Plan) -> str | None:
    """Whether `plan` is a plan for `mission`, and what is wrong if it is not.

    Parameters
    ----------
    mission, plan
        As read or planned; `plan` may come from anywhere.

    Returns
    -------
    str or None
        A sentence on the first fault, or ``None`` if there is none.

    Examples
    --------
    >>> from mitlplan.mission import mission_from_mapping
    >>> mission = mission_from_mapping({
    ...     "mitlplan": 1,
    ...     "workspace": {"grid": {"rows": 1, "columns": 2, "regions": {"A": [[0, 1]]}}},
    ...     "robot": {"start": "r0c0"},
    ...     "spec": {"visit": "F A", "soon": "F[0,1/2] A"},
    ... })
    >>> steps = (Step("r0c0", Fraction(0), Fraction(1)), Step("r0c1", Fraction(1), Fraction(1), ("A",)))
    >>> check(mission, Plan(steps, makespan=Fraction(1)))
    'the requirement soon is violated: F[0,1/2] A does not hold at 0: A never holds in [0,1/2].'
    """
    return next(_faults(mission, plan), None)


def signal_of(steps: Sequence[Step], loop: Loop | None = None) -> Signal:
    """What holds when, along steps that the robot can go; a stay that shows nothing new is no segment.

    Parameters
    ----------
    steps, loop
        As :func:`mitlplan.workspace.path.follows` accepts them.

    Examples
    --------
    >>> signal_of([Step("r0c0", Fraction(0), None, ("A",))], Loop(0, None)).repeat_from
    Fraction(0, 1)
    """
    segments = tuple(
        Segment(step.enter, frozenset(step.holds))
        for place, step in enumerate(steps)
        if place == 0 or step.holds != steps[place - 1].holds
    )
    end = ending(steps)
    match loop:
        case None:
            return Signal(segments, end)
        case Loop(_, None):
            return Signal(segments, end + _PARKED, end)
        case Loop(first, _):
            return Signal(segments, end, steps[first].enter)


def _faults(mission: Mission, plan: Plan) -> Iterator[str]:
    fault = follows(mission.workspace, mission.start, plan.steps, plan.loop)
    if fault is not None:
        yield fault
        return
    yield from _wrong_makespan(plan)
    signal = signal_of(plan.steps, plan.loop)
    for requirement in mission.spec:
        if not satisfies(requirement.formula, signal, until=mission.until, horizon=mission.horizon):
            why = explain(requirement.formula, signal, until=mission.until, horizon=mission.horizon)
            yield f"the requirement {requirement.name} is violated: {why}"


def _wrong_makespan(plan: Plan) -> Iterator[str]:
    end = ending(plan.steps)
    if plan.attained and plan.makespan != end:
        yield f"the plan takes {end}, not its makespan {plan.makespan}"
    if not plan.attained and not plan.makespan <= end <= plan.makespan + (plan.epsilon or 0):
        yield f"the plan takes {end}, which is not within {plan.epsilon} above the infimum {plan.makespan}"
