from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.formats.plan_text import plan_to_text
from mitlplan.plan import Infeasible, LimitReached, Loop, Outcome, Plan, Statistics, Step

FINITE = Plan(
    (
        Step("pos0", Fraction(0), Fraction(1), (), Fraction(0)),
        Step("pos1", Fraction(1), Fraction(7, 2), ("A", "B"), None),
        Step("pos3", Fraction(7, 2), Fraction(7, 2), ("A",), Fraction(1, 2)),
    ),
    makespan=Fraction(7, 2),
    bound=Fraction(7, 2),
    checked=True,
)


def text_of(outcome: Outcome) -> str:
    """The text without the spaces that only fill a column."""
    return "\n".join(line.rstrip() for line in plan_to_text(outcome).splitlines())


def test_a_finite_plan_whole() -> None:
    assert text_of(FINITE) == (
        "time cell stay holds slack\n"
        "   0 pos0    1           0\n"
        "   1 pos1  5/2 A, B    any\n"
        " 7/2 pos3    0 A       1/2\n"
        "done at 7/2\n"
        "makespan 7/2 (about 3.5, fastest, 2 moves, checked)"
    )


def test_a_loop() -> None:
    steps = (FINITE.steps[0], replace(FINITE.steps[1], leave=Fraction(2)))
    plan = Plan(steps, Fraction(2), Loop(1, Fraction(1)), bound=Fraction(2))
    assert text_of(plan).splitlines()[-2:] == [
        "loop: at 2 on to pos1, and so on from 1, a round every 1",
        "makespan 2 (fastest, 1 move, not checked)",
    ]


def test_parking() -> None:
    plan = Plan((replace(FINITE.steps[0], leave=None),), Fraction(0), Loop(0, None), bound=Fraction(0))
    assert text_of(plan) == (
        "time cell     stay holds slack\n"
        "   0 pos0 for ever           0\n"
        "parks in pos0\n"
        "makespan 0 (fastest, 0 moves, not checked)"
    )


@pytest.mark.parametrize(
    ("change", "summary"),
    [
        (
            {"attained": False, "epsilon": Fraction(1, 1000)},
            "infimum 7/2, which no plan attains; this one is within 1/1000 (2 moves, checked)",
        ),
        (
            {"attained": False, "epsilon": Fraction(1, 1000), "bound": Fraction(1)},
            "makespan within 1/1000 of 7/2 (none is below 1, 2 moves, checked)",
        ),
        ({"bound": Fraction(3)}, "makespan 7/2 (about 3.5, none is below 3, 2 moves, checked)"),
        ({"bound": None}, "makespan 7/2 (about 3.5, not proved to be the fastest, 2 moves, checked)"),
    ],
)
def test_summaries(change: dict[str, object], summary: str) -> None:
    assert text_of(replace(FINITE, **change)).splitlines()[-1] == summary  # type: ignore[arg-type]


def test_what_is_no_plan() -> None:
    assert text_of(Infeasible("B is too far.", ("order", "visit"))) == (
        "No plan: B is too far.\nTogether impossible on this map: order, visit"
    )
    assert text_of(Infeasible("B is too far.")) == "No plan: B is too far."
    assert text_of(LimitReached("60 seconds are over.", Fraction(7, 2))) == (
        "Stopped: 60 seconds are over.\nNo plan is faster than 7/2."
    )
    assert text_of(LimitReached("60 seconds are over.")) == "Stopped: 60 seconds are over."


def test_statistics_are_one_line() -> None:
    statistics = Statistics("compact", 12, 40, 31, {"read": 0.01, "search": 0.5})
    assert text_of(replace(FINITE, statistics=statistics)).splitlines()[-1] == (
        "compact: 12 locations, 40 edges, 31 zones, 0.51 s"
    )


def test_a_long_plan_keeps_what_changes() -> None:
    steps = [Step(f"c{time}", Fraction(time), Fraction(time + 1), (), None) for time in range(100)]
    steps[50] = replace(steps[50], holds=("A",))
    steps[52] = replace(steps[52], holds=("A",))
    shown = text_of(Plan(tuple(steps), Fraction(100), Loop(10, Fraction(90)))).splitlines()
    assert [" ".join(line.split()[:3]) for line in shown[1:-2]] == [
        "0 c0 1",
        "... 9 cells",
        "10 c10 1",
        "... 39 cells",
        "50 c50 1",
        "51 c51 1",
        "52 c52 1",
        "53 c53 1",
        "... 45 cells",
        "99 c99 1",
    ]


def test_colours_only_where_they_are_wanted() -> None:
    assert "\x1b" not in plan_to_text(FINITE)
    coloured = plan_to_text(FINITE, colours=True)
    assert "\x1b[" in coloured
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured) == plan_to_text(FINITE)


def test_long_names_and_sentences_are_not_cut() -> None:
    name = "a_cell_with_a_very_long_name_" * 5
    plan = Plan((Step(name, Fraction(0), Fraction(0)),), Fraction(0))
    assert name in plan_to_text(plan, width=200)
    sentence = "No way leads round the fire. " * 10
    assert sentence.strip() in plan_to_text(Infeasible(sentence.strip()), width=40)


def test_names_are_no_markup() -> None:
    plan = Plan((Step("[red]x[/red]", Fraction(0), Fraction(0), ("[b]",)),), Fraction(0))
    assert "[red]x[/red]" in plan_to_text(plan)
