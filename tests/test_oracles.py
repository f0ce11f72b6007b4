"""The oracles against hand-made answers, against each other, and against the judge.

What the engine is measured with must itself be beyond doubt: every row of the table in the semantics is
here with the answer that was worked out by hand, and the two planners, which share only the list of moves,
must agree on everything random.
"""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan.logic import formula as f
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.workspace.graph import Move, graph
from mitlplan_fuzz.missions import SeededChoices, SmallMission, draw_formula, random_mission, text_of
from mitlplan_fuzz.oracles.path_checker import fault_in_path
from mitlplan_fuzz.oracles.progression import Cycle, TooLargeError, co_safe, need_of
from mitlplan_fuzz.oracles.rtamt_voice import monitored, reach, speaks_of
from mitlplan_fuzz.oracles.tick_planner import (
    Answer,
    Least,
    NoneUpTo,
    least_by_enumeration,
    least_by_progression,
    signal_of,
)
from tests.mission_strategies import missions

TWO_BY_TWO = SmallMission(
    cells=(("pos0", ("start",)), ("pos1", ("B",)), ("pos2", ()), ("pos3", ("A",))),
    moves=tuple(
        (f"pos{origin}", f"pos{(origin + step) % 4}", Fraction(1), Fraction(1))
        for origin in range(4)
        for step in (1, 3)
    ),
    waiting=False,
    start="pos0",
    formula=f.Constant(value=True),
)


def ask(mission: SmallMission, *, bound: int = 6, resolution: int = 1) -> Answer:
    """What progression answers."""
    return least_by_progression(
        mission.workspace(),
        mission.start_index,
        mission.formula,
        bound=bound,
        until=mission.until,
        horizon=mission.horizon,
        resolution=resolution,
    )


def ask_enumeration(mission: SmallMission, *, bound: int, resolution: int = 1) -> Answer:
    """What enumeration and the judge answer."""
    return least_by_enumeration(
        mission.workspace(),
        mission.start_index,
        mission.formula,
        bound=bound,
        until=mission.until,
        horizon=mission.horizon,
        resolution=resolution,
    )


def makespan(answer: Answer) -> Fraction | None:
    """The makespan, if there is a plan."""
    return answer.makespan if isinstance(answer, Least) else None


# --- By hand -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "waiting", "expected", "kind"),
    [
        ("(!A U B) & F A", False, 3, "finite"),
        ("G F[0,2] A", False, 2, "looping"),
        ("F[0,4] A & F[0,4] B", False, 3, "finite"),
        ("F[2,4] A & F[0,2] B", False, 3, "finite"),
        ("F[0,1] A & F[0,1] B", False, None, ""),
        ("G[0,3] !A & F B", False, 3, "finite"),
        ("G F[0,3] A & G F[0,3] B", False, 4, "looping"),
        ("F(A & F[2,2] A)", False, 3, "finite"),
        ("G !B & F A", False, 2, "looping"),
        ("G !B & F A", True, 1, "parking"),
        ("F[2,4] A", True, 2, "finite"),
        ("!B U A", False, 1, "finite"),
        ("start U A", False, 1, "finite"),
    ],
)
def test_the_table_of_the_semantics(text: str, waiting: bool, expected: int | None, kind: str) -> None:
    mission = replace(TWO_BY_TWO, formula=parse(text), waiting=waiting)
    for answer in (ask(mission), ask_enumeration(mission, bound=5)):
        assert makespan(answer) == expected
        assert expected is None or (isinstance(answer, Least) and answer.kind == kind)


def test_the_closed_until_asks_for_an_overlap() -> None:
    mission = replace(TWO_BY_TWO, formula=parse("start U A"), until="closed")
    assert ask(mission) == NoneUpTo(Fraction(6), exhausted=True)
    assert makespan(ask(replace(mission, formula=parse("!B U A")))) == 1


def test_the_label_entered_at_the_end_is_known_at_that_instant_only() -> None:
    # translation.md 6(3): A is entered at 4, and seen from 3.5 it must still be known at 4.5.
    corridor = SmallMission(
        cells=(("c", ("C",)), ("bare", ()), ("a", ("A",))),
        moves=(
            ("c", "bare", Fraction(3), Fraction(3)),
            ("bare", "a", Fraction(1), Fraction(1)),
            ("a", "c", Fraction(3), Fraction(3)),
        ),
        waiting=False,
        start="c",
        formula=parse("G[2,4](F[1,3] A | C)"),
    )
    assert makespan(ask(corridor)) == 5
    assert makespan(ask(corridor, resolution=2)) == 5


@pytest.mark.parametrize(
    ("text", "coarse", "fine"),
    [
        # C holds on [0,2] exactly if the robot leaves after 2: no least time, the infimum is 2.
        ("G[0,2] C & F A", 3, Fraction(9, 4)),
        ("F[0,3) A & G[0,2] C", None, Fraction(9, 4)),
        ("F[0,2] A & G[0,2] C", None, None),
        # Left after 1, back after 2, left again after 3: two strict steps, and the infimum is 3.
        ("G[0,1] C & F(!C & F(C & G[0,1] C & F !C))", 5, Fraction(14, 4)),
    ],
)
def test_an_infimum_shows_at_two_resolutions(text: str, coarse: int | None, fine: Fraction | None) -> None:
    free = SmallMission(
        cells=(("c", ("C",)), ("a", ("A",))),
        moves=(("c", "a", Fraction(1), Fraction(1)), ("a", "c", Fraction(1), Fraction(1))),
        waiting=True,
        start="c",
        formula=parse(text),
    )
    assert makespan(ask(free)) == coarse
    assert makespan(ask(free, resolution=4)) == fine


def test_a_finite_horizon_lets_always_end_with_the_mission() -> None:
    mission = replace(TWO_BY_TWO, formula=parse("G !B & F A"), horizon="finite")
    assert makespan(ask(mission)) == 1
    assert makespan(ask(replace(mission, formula=parse("G F[0,2] A")))) == 1
    assert makespan(ask(replace(mission, formula=parse("G[0,3] !B & F A")))) == 3


def test_co_safety_is_read_off_the_negation_normal_form() -> None:
    assert co_safe(parse("F A & !(B R[0,3] A)"))
    assert co_safe(parse("!(G !A)"))
    assert not co_safe(parse("!(F A)"))
    assert not co_safe(parse("F A -> F B"))
    assert not co_safe(parse("A W B"))


# --- Against each other ------------------------------------------------------------------------------------


def assert_agreement(mission: SmallMission, *, bound: int, resolution: int = 1) -> None:
    """The two planners agree, and the judge agrees with the witness."""
    try:
        answer = ask(mission, bound=bound, resolution=resolution)
    except TooLargeError:
        return
    enumerated = ask_enumeration(mission, bound=bound, resolution=resolution)
    assert makespan(answer) == makespan(enumerated), mission.yaml()
    if isinstance(answer, Least):
        assert_sound(mission, answer)


def assert_sound(mission: SmallMission, answer: Least) -> None:
    """The witness is a walk on the map that satisfies the mission."""
    signal = signal_of(mission.workspace(), answer)
    assert satisfies(mission.formula, signal, until=mission.until, horizon=mission.horizon), mission.yaml()
    stays = [(mission.cells[cell][0], entered) for cell, entered in answer.stays]
    loop = None if answer.loop_start is None else stays[answer.loop_start][0]
    end = None if answer.kind == "parking" else answer.makespan
    assert fault_in_path(mission, stays, end, loop) is None, mission.yaml()


@pytest.mark.parametrize("chunk", range(6))
def test_progression_agrees_with_enumeration(chunk: int) -> None:
    for seed in range(chunk * 250, (chunk + 1) * 250):
        mission = random_mission(seed)
        assert_agreement(mission, bound=5 if mission.tick_timed else 4)


def test_progression_agrees_with_enumeration_on_half_ticks() -> None:
    for seed in range(10_000, 10_300):
        mission = random_mission(seed)
        assert_agreement(mission, bound=4 if mission.tick_timed else 3, resolution=2)


@given(mission=missions())
@settings(max_examples=50)
def test_progression_agrees_with_enumeration_on_what_hypothesis_finds(mission: SmallMission) -> None:
    assert_agreement(mission, bound=4)


def test_half_ticks_are_fine_enough_where_times_are_fixed() -> None:
    """Between two ticks all ends are alike: a quarter tick shows the same infimum, n + 1/2 as n + 1/4."""
    for seed in range(20_000, 21_000):
        mission = random_mission(seed)
        if not mission.tick_timed:
            continue
        try:
            halves = makespan(ask(mission, resolution=2))
            quarters = makespan(ask(mission, resolution=4))
        except TooLargeError:
            continue
        if halves is not None and halves.denominator == 2:
            halves -= Fraction(1, 4)
        assert halves == quarters, mission.yaml()


def random_labels(stream: random.Random, length: int) -> list[frozenset[str]]:
    return [frozenset(name for name in "AB" if stream.random() < 0.5) for _ in range(length)]


def test_the_cells_of_a_cycle_agree_with_the_judge() -> None:
    stream = random.Random(3)
    for _ in range(1500):
        formula = draw_formula(SeededChoices(stream), ("A", "B"))
        labels = random_labels(stream, stream.randrange(1, 6))
        until = "closed" if stream.random() < 0.3 else "standard"
        segments = tuple(Segment(Fraction(tick), label) for tick, label in enumerate(labels))
        signal = Signal(segments, Fraction(len(labels)), repeat_from=Fraction(0))
        expected = bool(Cycle(labels).truth(need_of(formula, until=until)) & 1)
        assert satisfies(formula, signal, until=until) == expected, (text_of(formula), labels, until)


@given(seed=st.integers(0, 10**9))
@settings(max_examples=60)
def test_a_finer_resolution_is_never_slower(seed: int) -> None:
    mission = random_mission(seed)
    try:
        coarse, fine = ask(mission, bound=4), ask(mission, bound=4, resolution=2)
    except TooLargeError:
        return
    if isinstance(coarse, Least):
        assert isinstance(fine, Least)
        assert fine.makespan <= coarse.makespan


# --- What the oracles refuse -------------------------------------------------------------------------------


def test_a_time_between_ticks_is_refused() -> None:
    workspace = graph({"a": [], "b": []}, [Move("a", "b", "1/2")])
    with pytest.raises(ValueError, match="whole numbers of ticks"):
        least_by_progression(workspace, 0, parse("F A"), bound=1)
    with pytest.raises(ValueError, match="no whole number of ticks"):
        need_of(parse("F[0,1/2] A"))


# --- A foreign voice ---------------------------------------------------------------------------------------


def test_rtamt_agrees_with_the_judge_and_the_cycles() -> None:
    stream = random.Random(11)
    heard = 0
    while heard < 400:
        until = "closed" if stream.random() < 0.4 else "standard"
        formula = draw_formula(SeededChoices(stream), ("A", "B"), open_ends=False, until=until)
        if not speaks_of(formula, until):
            continue
        heard += 1
        labels = random_labels(stream, stream.randrange(1, 6))
        segments = tuple(Segment(Fraction(tick), label) for tick, label in enumerate(labels))
        signal = Signal(segments, Fraction(len(labels)), repeat_from=Fraction(0))
        samples = [labels[tick % len(labels)] for tick in range(reach(formula) + 2)]
        expected = monitored(formula, samples, ("A", "B"), until)
        assert satisfies(formula, signal, until=until) == expected, (text_of(formula), labels, until)
        assert bool(Cycle(labels).truth(need_of(formula, until=until)) & 1) == expected
