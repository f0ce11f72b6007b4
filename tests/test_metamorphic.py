"""Laws that need no oracle: how the answer changes when the mission does.

Scaling all times scales the makespan; a further move cannot make the mission slower, a further requirement
cannot make it faster; names, order and numbering change nothing; the same mission gets the same plan.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.logic import formula as f
from mitlplan.mission import Mission, Requirement
from mitlplan.plan import Infeasible, LimitReached, Outcome, Plan
from mitlplan.planner import plan
from mitlplan_fuzz.comparison import mission_of
from mitlplan_fuzz.formulas import SeededChoices, draw_formula, parts, text_of, trivial, with_operands
from mitlplan_fuzz.missions import SmallMission, random_mission
from mitlplan_fuzz.oracles.progression import co_safe

CHUNKS = range(50_000, 50_240, 40)
LONGEST = 2.0
"""Seconds for an answer. A law about a mission that takes longer is not tried."""


def chunk(first: int) -> Iterator[tuple[SmallMission, random.Random]]:
    """Forty missions, each with a stream of its own for what is changed."""
    for seed in range(first, first + 40):
        yield random_mission(seed), random.Random(seed)


def answer_to(mission: SmallMission | Mission) -> Outcome:
    """What the engine says."""
    return plan(mission if isinstance(mission, Mission) else mission_of(mission), time_limit=LONGEST)


def least(outcome: Outcome) -> tuple[object, ...]:
    """What of the answer does not depend on names and order."""
    match outcome:
        case Plan(makespan=makespan, attained=attained, bound=bound):
            return ("plan", makespan, attained, bound)
        case Infeasible():
            return ("infeasible",)
        case LimitReached(reason=reason):
            return ("limit", reason)


def assert_same(found: Outcome, reference: Outcome, why: str) -> None:
    """The same answer, if both were found in time."""
    if not isinstance(found, LimitReached) and not isinstance(reference, LimitReached):
        assert least(found) == least(reference), why


def lower_bound(outcome: Outcome) -> Fraction | None:
    """No plan is faster than this; ``None`` means that there is no plan."""
    match outcome:
        case Plan(makespan=makespan, bound=bound):
            return makespan if bound is None else bound
        case Infeasible():
            return None
        case LimitReached(bound=bound):
            return bound or Fraction(0)


def assert_no_slower(easier: SmallMission | Mission, harder: SmallMission | Mission, why: str) -> None:
    """Every plan of the harder mission is one of the easier."""
    found, reference = answer_to(easier), answer_to(harder)
    if not isinstance(reference, Plan):
        return
    bound = lower_bound(found)
    assert bound is not None, why
    assert bound <= reference.makespan, why
    if isinstance(found, Plan) and bound == found.makespan == reference.makespan:
        assert found.attained or not reference.attained, why


@pytest.mark.parametrize("first", CHUNKS)
def test_scaling_all_times_scales_the_makespan(first: int) -> None:
    for mission, stream in chunk(first):
        factor = Fraction(stream.randrange(1, 8), stream.randrange(1, 8))
        scaled = answer_to(mission.scaled(factor))
        match answer_to(mission), scaled:
            case Plan(makespan=makespan, attained=attained, bound=Fraction() as bound), Plan():
                assert least(scaled) == ("plan", makespan * factor, attained, bound * factor), mission.yaml()
            case unscaled, _:
                assert_same(scaled, unscaled, mission.yaml())


@pytest.mark.parametrize("first", CHUNKS)
def test_a_further_move_cannot_make_it_slower(first: int) -> None:
    for mission, stream in chunk(first):
        names = [name for name, _ in mission.cells]
        origin, target = stream.sample(names, 2)
        time = Fraction(stream.randrange(1, 4))
        roomier = replace(mission, moves=(*mission.moves, (origin, target, time, time)))
        assert_no_slower(roomier, mission, roomier.yaml())


@pytest.mark.parametrize("first", CHUNKS)
def test_waiting_cannot_make_it_slower(first: int) -> None:
    for mission, _ in chunk(first):
        freer = replace(mission, waiting=True)
        assert_no_slower(freer, replace(mission, waiting=False), freer.yaml())


@pytest.mark.parametrize("first", CHUNKS)
def test_a_further_requirement_cannot_make_it_faster(first: int) -> None:
    for mission, stream in chunk(first):
        further = draw_formula(SeededChoices(stream), ("A", "B"), depth=2, until=mission.until)
        both = f.And((mission.formula, further))
        # A mission that goes on for ever may count from an earlier moment than one that is accomplished.
        if trivial(both, mission.until) or _accomplished(mission, mission.formula) != _accomplished(
            mission, both
        ):
            continue
        stronger = replace(mission, formula=both)
        assert_no_slower(mission, stronger, stronger.yaml())


def _accomplished(mission: SmallMission, formula: f.Formula) -> bool:
    """Whether finite plans only are asked for."""
    return mission.horizon == "finite" or co_safe(formula)


@pytest.mark.parametrize("first", CHUNKS)
def test_names_change_nothing(first: int) -> None:
    for mission, stream in chunk(first):
        cells = dict(zip((name for name, _ in mission.cells), _shuffled("vwxyz", stream), strict=False))
        atoms = dict(zip("ABC", _shuffled(("Q.1", "near_B", "A"), stream), strict=True))
        renamed = replace(
            mission,
            cells=tuple((cells[name], tuple(atoms[atom] for atom in holds)) for name, holds in mission.cells),
            moves=tuple((cells[origin], cells[target], *times) for origin, target, *times in mission.moves),
            start=cells[mission.start],
            formula=_renamed(mission.formula, atoms),
        )
        assert_same(answer_to(renamed), answer_to(mission), mission.yaml())


def _shuffled(items: str | tuple[str, ...], stream: random.Random) -> list[str]:
    return stream.sample(list(items), len(items))


def _renamed(formula: f.Formula, names: dict[str, str]) -> f.Formula:
    if isinstance(formula, f.Atom):
        return f.Atom(names[formula.name])
    return with_operands(formula, [_renamed(operand, names) for operand in f.operands_of(formula)])


@pytest.mark.parametrize("first", CHUNKS)
def test_the_order_of_cells_moves_and_operands_changes_nothing(first: int) -> None:
    for mission, stream in chunk(first):
        cells, moves = list(mission.cells), list(mission.moves)
        stream.shuffle(cells)
        stream.shuffle(moves)
        turned = replace(mission, cells=tuple(cells), moves=tuple(moves), formula=_turned(mission.formula))
        assert_same(answer_to(turned), answer_to(mission), mission.yaml())


def _turned(formula: f.Formula) -> f.Formula:
    operands = [_turned(operand) for operand in f.operands_of(formula)]
    if isinstance(formula, (f.And, f.Or, f.Iff)):
        operands.reverse()
    return with_operands(formula, operands)


@pytest.mark.parametrize("first", CHUNKS)
def test_requirements_are_a_conjunction(first: int) -> None:
    for mission, stream in chunk(first):
        further = draw_formula(SeededChoices(stream), ("A", "B"), depth=2, until=mission.until)
        demanded = [mission.formula, further]
        if trivial(f.And(tuple(demanded)), mission.until):
            continue
        together = answer_to(replace(mission, formula=f.And(tuple(demanded))))
        demanded.reverse()
        spec = tuple(
            Requirement(f"requirement {number}", text_of(part), part) for number, part in enumerate(demanded)
        )
        apart = answer_to(replace(mission_of(mission), spec=spec))
        assert_same(apart, together, mission.yaml())
        if isinstance(apart, Infeasible):
            assert set(apart.conflict) <= {requirement.name for requirement in spec}
            assert apart.conflict


@pytest.mark.parametrize("first", CHUNKS)
def test_a_cell_that_cannot_be_reached_changes_nothing(first: int) -> None:
    for mission, _ in chunk(first):
        island = ("island", ("A", "B"))
        moves = [("island", mission.start, Fraction(1), Fraction(1))]
        larger = replace(mission, cells=(island, *mission.cells), moves=(*mission.moves, *moves))
        assert_same(answer_to(larger), answer_to(mission), mission.yaml())


@pytest.mark.parametrize("first", CHUNKS)
def test_the_untils_differ_only_on_untils(first: int) -> None:
    for mission, _ in chunk(first):
        if any(isinstance(part, (f.Until, f.Release, f.WeakUntil)) for part in parts(mission.formula)):
            continue
        closed, standard = (replace(mission, until=until) for until in ("closed", "standard"))
        assert_same(answer_to(closed), answer_to(standard), mission.yaml())


@pytest.mark.parametrize("first", CHUNKS[:3])
def test_the_same_mission_gets_the_same_plan(first: int) -> None:
    for mission, _ in chunk(first):
        match answer_to(mission):
            case Plan(steps=steps, loop=loop):
                again = answer_to(mission)
                assert isinstance(again, Plan)
                assert (again.steps, again.loop) == (steps, loop), mission.yaml()
            case other:
                assert_same(answer_to(mission), other, mission.yaml())
