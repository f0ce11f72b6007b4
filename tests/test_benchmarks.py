"""The hand-made products that the planner is measured against are products of the same missions."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from benchmarks.contest import OURS, WrongAnswerError, hold, ratio_in_turns
from benchmarks.families import Instance, goals, on, paper, responses, slow_warehouse
from benchmarks.peers import Visits, on_distances, on_product, subset_programming
from benchmarks.product import DONE, build, explore, fetch, ordered, visit
from benchmarks.report import Section, milliseconds, ratio, remarks, table, write
from mitlplan.mission import Mission
from mitlplan.plan import Infeasible, Plan
from mitlplan.planner import plan
from mitlplan.workspace import grid

OPEN = np.ones((5, 5), dtype=np.uint8)
WITH_WALLS = np.array([[1, 1, 1, 1], [1, 0, 0, 1], [1, 1, 0, 1], [0, 1, 1, 1]], dtype=np.uint8)


def planned(mission: Mission) -> Fraction | None:
    match plan(mission):
        case Plan() as found:
            return found.makespan
        case Infeasible():
            return None
        case stopped:
            raise AssertionError(stopped)


def answers(instance: Instance) -> dict[str, Fraction | None]:
    return {peer.name: peer.prepare()() for peer in instance.peers}


@pytest.mark.parametrize("size", [2, 3, 4, 5, 6, 9])
@pytest.mark.parametrize("name", ["phi1", "phi3", "phi4", "phi4, peers count"])
def test_the_papers_formulas_take_three_sides_by_every_way(name: str, size: int) -> None:
    instance = paper(name, size)
    assert planned(instance.mission) == 3 * (size - 1)
    assert set(answers(instance).values()) == {Fraction(3 * (size - 1))}


@pytest.mark.parametrize("window", [(3, 5), (4, 4), (5, 9), (7, 8), (8, 8), (9, 11), (6, 6)])
def test_counting_and_parity_agree_with_the_planner_on_any_window(window: tuple[int, int]) -> None:
    from benchmarks.families import corners
    from benchmarks.product import windows_by_counting, windows_by_parity

    workspace = corners(3)
    # A window of a single instant is written as a pair of bounds, one of them open.
    interval = f"[{window[0]},{window[1]}]" if window[0] < window[1] else f"[{window[0]},{window[1]}.5)"
    expected = planned(on(workspace, 0, f"F{interval} A", "F[0,4] B"))
    for made in (windows_by_counting("A", window, "B", 4), windows_by_parity("A", window, "B")):
        for peer in on_product(lambda made=made: build(workspace, 0, *made)):  # type: ignore[misc]
            assert peer.prepare()() == expected, (peer.name, window)


@pytest.mark.parametrize("feasible", [True, False])
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_every_peer_finds_the_shortest_walk_through_the_goals(count: int, *, feasible: bool) -> None:
    for terrain in (OPEN, WITH_WALLS):
        instance = goals(terrain, "small", count, feasible=feasible)
        expected = instance.expected if feasible else None
        assert planned(instance.mission) == expected
        found = answers(instance)
        assert {"scipy Dijkstra", "subset DP", "HiGHS"} <= set(found)
        assert set(found.values()) == {expected}


@pytest.mark.parametrize(("count", "size"), [(1, 3), (1, 4), (1, 5), (1, 6), (2, 4), (2, 5), (2, 6), (3, 6)])
def test_ages_of_demands_are_counted_as_the_planner_times_them(count: int, size: int) -> None:
    instance = responses(count, size)
    expected = planned(instance.mission)
    assert expected is not None
    assert set(answers(instance).values()) == {expected}


@pytest.mark.parametrize("within", [3, 4, 5, 7])
def test_tight_demands_are_refused_by_both(within: int) -> None:
    from benchmarks.product import respond

    workspace = grid(3, 4, regions={"p": [(0, 2)], "q": [(2, 0)], "goal": [(0, 3)], "wall": [(1, 2)]})
    one = on(workspace, 0, "F goal", f"G (p -> F[0,{within}] q)", "G !wall", horizon="finite")
    recipe, finish = respond((("p", "q"),), within, "goal")

    def advance(state: object, label: frozenset[str]) -> object:
        return "dead" if "wall" in label else recipe[1](state, label)

    expected = planned(one)
    for peer in on_product(lambda: build(workspace, 0, (recipe[0], advance), finish)):
        assert peer.prepare()() == expected


@pytest.mark.parametrize(("by", "within"), [((None, 12), 6), ((2, 12), 6), ((3, None), 4), ((None, 12), 3)])
@pytest.mark.parametrize("avoid", [None, "fire"])
def test_fetching_needs_no_counter(by: tuple[int | None, int | None], within: int, avoid: str | None) -> None:
    workspace = grid(4, 4, waiting=True, regions={"p": [(0, 3)], "bay": [(3, 3)], "fire": [(0, 1), (2, 3)]})
    spec = ["!bay U p", f"G (p -> F[0,{within}] bay)"]
    if by[0] is not None:
        spec.append(f"F[0,{by[0]}] p")
    if by[1] is not None:
        spec.append(f"F[0,{by[1]}] bay")
    else:
        spec.append("F bay")
    if avoid is not None:
        spec.append("G !fire")
    made = fetch("p", "bay", cells=16, avoid=avoid, by=by, within=within)
    expected = planned(on(workspace, 0, *spec))
    for peer in on_product(lambda: build(workspace, 0, *made)):
        assert peer.prepare()() == expected


def test_the_slow_warehouse_takes_as_much_longer_as_it_is_slower() -> None:
    instance = slow_warehouse()
    assert instance.expected == Fraction(154000, 7)
    assert set(answers(instance).values()) == {Fraction(154000, 7)}


def test_a_violated_start_has_no_product() -> None:
    workspace = grid(2, 2, regions={"A": [(0, 0)], "B": [(1, 1)]})
    for peer in on_product(lambda: build(workspace, 0, *ordered())):
        assert peer.prepare()() is None
    assert planned(on(workspace, 0, "!A U B", "F A")) is None


def test_goals_out_of_reach_are_missed_by_every_peer() -> None:
    workspace = grid(2, 3, blocked=[(0, 1), (1, 1)], regions={"g": [(0, 2)]})
    for peer in (
        *on_product(lambda: build(workspace, 0, *visit("g", within=9))),
        *on_distances(Visits(workspace, 0, (1,), 9)),
    ):
        assert peer.prepare()() is None


def test_the_automaton_of_progress_ends_when_all_is_done() -> None:
    recipe, _ = visit("A", "B")
    progress = explore(*recipe, (frozenset(), frozenset("A"), frozenset("B"), frozenset("AB")))
    assert len(progress.states) == 4
    assert progress.table[progress.states.index(DONE)].tolist() == [-1] * 4


def test_subset_programming_is_the_best_of_all_orders() -> None:
    from itertools import pairwise, permutations

    random = np.random.default_rng(7)
    for count in (1, 2, 3, 5):
        distances = random.integers(1, 30, size=(count + 1, count))
        best = min(
            distances[0, order[0]] + sum(distances[a + 1, b] for a, b in pairwise(order))
            for order in permutations(range(count))
        )
        assert subset_programming(distances) == best


def test_a_contest_holds_everybody_to_one_answer() -> None:
    instance = paper("phi4", 3)
    row = hold(instance, limit=30, rounds=2, budget=30, absent={"scipy Dijkstra": "not today"})
    assert row.answer == 6
    assert len(row.ours.solve) == 2
    assert row.ours.states > 0
    assert row.times["scipy Dijkstra"].given_up == "not today"
    wrong = Instance(instance.name, "", instance.mission, Fraction(7), instance.peers)
    with pytest.raises(WrongAnswerError, match=f"phi4 : {OURS} says 6, but it is 7"):
        hold(wrong, limit=30, rounds=1, budget=1, absent={})


def test_a_mission_takes_about_as_long_as_itself() -> None:
    one = paper("phi3", 8).mission
    assert 0.2 < ratio_in_turns(one, one, rounds=5) < 5


def test_the_page_shows_every_row_and_says_who_is_slower() -> None:
    rows = [hold(paper("phi1", size), limit=30, rounds=1, budget=1, absent={}) for size in (2, 3)]
    lines = list(table(rows))
    assert len(lines) == 4
    assert len({line.replace("\\|", "").count("|") for line in lines}) == 1
    assert lines[2].startswith("| phi1 | n = 2 | 3 | ")
    said = list(remarks(Section("paper", "", rows)))
    assert len(said) == len(rows[0].times) - 1


def test_the_page_names_commit_machine_and_command(tmp_path: Path) -> None:
    rows = [hold(paper("phi1", 2), limit=30, rounds=1, budget=1, absent={})]
    page = tmp_path / "docs" / "performance.md"
    section = Section("paper", "The paper's formulas", rows)
    write(page, [section], command="bench it", rounds=1, load=(0.5, 1, 2), facts={"shown": "189"})
    text = page.read_text(encoding="utf-8")
    assert "- command: `bench it`" in text
    assert re.search(r"^- Commit \w+", text, re.MULTILINE)
    assert re.search(r"^- machine: .*Python 3\..*load average 0\.5, 1\.0, 2\.0", text, re.MULTILINE)
    assert "189 missions" in text
    assert "| phi1 | n = 2 | 3 |" in text


@pytest.mark.parametrize(
    ("value", "shown"), [(0.0000456, "0.05"), (0.00123, "1.23"), (0.0456, "45.6"), (1.234, "1234")]
)
def test_milliseconds_have_three_digits(value: float, shown: str) -> None:
    assert milliseconds(value) == shown


@pytest.mark.parametrize(("value", "shown"), [(0.034, "0.03"), (1.26, "1.3"), (12.6, "13")])
def test_ratios_have_two(value: float, shown: str) -> None:
    assert ratio(value) == shown
