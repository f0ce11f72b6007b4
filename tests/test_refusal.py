"""What forbids the times of a plan: beside the judge, on random formulas and random times."""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate, pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan.check import signal_of
from mitlplan.logic.core import Core
from mitlplan.logic.normalize import normalize, written
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.plan import Loop, Plan, Step
from mitlplan.refusal import reasons
from mitlplan.trajectory.timetable import Apart
from tests.strategies import ATOMS, core_formulas

HALF = Fraction(1, 2)
labels = st.lists(
    st.sets(st.sampled_from(ATOMS)).map(lambda names: tuple(sorted(names))), min_size=1, max_size=5
)
stays = st.integers(1, 8).map(lambda halves: halves * HALF)


def plan_at(seen: list[tuple[str, ...]], times: list[Fraction], kind: str) -> Plan:
    """Cells with those labels, entered at those times, the last of which ends a plan that does not park."""
    leaves: list[Fraction | None] = [*times[1 : len(seen)], None if kind == "parks" else times[len(seen)]]
    steps = tuple(
        Step(f"c{place}", enter, leave, holds)
        for place, (holds, enter, leave) in enumerate(zip(seen, times, leaves, strict=False))
    )
    match kind:
        case "parks":
            return Plan(steps, times[len(seen) - 1], Loop(len(seen) - 1, None))
        case "loops":
            return Plan(steps, times[-1], Loop(0, times[-1]))
        case _:
            return Plan(steps, times[-1])


def accepted(core: Core, plan: Plan) -> bool:
    return satisfies(written(core), signal_of(plan.steps, plan.loop))


def kept(why: Apart, times: list[Fraction]) -> bool:
    gap = times[why.later] - times[why.earlier]
    return gap > why.least if why.strict else gap >= why.least


@st.composite
def timed(draw: st.DrawFn) -> tuple[list[tuple[str, ...]], list[Fraction], str]:
    seen = draw(labels)
    durations = draw(st.lists(stays, min_size=len(seen), max_size=len(seen)))
    kind = draw(st.sampled_from(["ends", "ends at once", "parks", "loops"]))
    if kind == "ends at once":
        durations[-1] = Fraction(0)
    return seen, list(accumulate(durations, initial=Fraction(0))), kind


@given(core_formulas(), timed())
@settings(max_examples=400)
def test_there_are_reasons_exactly_where_the_judge_refuses(
    core: Core, case: tuple[list[tuple[str, ...]], list[Fraction], str]
) -> None:
    seen, times, kind = case
    plan = plan_at(seen, times, kind)
    why = reasons(core, plan)
    if accepted(core, plan):
        assert why is None
    elif kind != "loops":
        # What a loop never does may show only when it has been followed for ever.
        assert why is not None
        assert all(kept(one, times) for one in why)


@given(core_formulas(), timed(), st.lists(st.tuples(st.integers(0, 4), stays), min_size=8, max_size=8))
@settings(max_examples=400)
def test_as_long_as_the_reasons_are_kept_the_judge_refuses(
    core: Core, case: tuple[list[tuple[str, ...]], list[Fraction], str], changes: list[tuple[int, Fraction]]
) -> None:
    """The times wander off, a stay at a time."""
    seen, times, kind = case
    why = reasons(core, plan_at(seen, times, kind))
    durations = [end - begin for begin, end in pairwise(times)]
    changeable = len(seen) - (kind in ("ends at once", "loops"))
    for place, stay in changes if why is not None and changeable else []:
        durations[place % changeable] = stay
        moved = list(accumulate(durations, initial=Fraction(0)))
        if kind == "loops":
            # The period stays what it was.
            moved[-1] = times[-1]
        if moved[-2] <= moved[-1] and moved[-2] < moved[-1] + (kind == "ends at once"):
            forbidden = all(kept(one, moved) for one in why or ())
            assert not (forbidden and accepted(core, plan_at(seen, moved, kind)))


def test_only_what_matters_is_named() -> None:
    seen = [(), ("A",), (), ("B",), (), ("A",), (), ("B",)]
    times = [Fraction(time) for time in (0, 2, 3, 9, 10, 12, 13, 20)]
    plan = plan_at(seen, [*times, Fraction(20)], "ends")
    found = reasons(normalize(parse("F[0,20] B & F(A & F[0,4] B)")), plan)
    # Neither visit of A is followed by B in time: each must be so, or it is no reason.
    assert found == (Apart(2, 3, Fraction(4)), Apart(6, 7, Fraction(4)))
    assert reasons(normalize(parse("F[0,20] B")), plan) is None


def test_a_finite_horizon_ends_with_the_plan() -> None:
    seen = [(), ("A",)]
    early, late = (plan_at(seen, [Fraction(time) for time in (0, 2, end)], "ends") for end in (3, 9))
    core = normalize(parse("G F[0,4] A & F[6,inf) A"), horizon="finite")
    assert reasons(core, early, horizon="finite") == (Apart(2, 0, Fraction(-6), strict=True),)
    assert reasons(core, late, horizon="finite") is None
