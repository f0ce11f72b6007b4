"""The repaired construction plans as the compact one does, and moves as the exact transducers do."""

from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan.automata.transducer import Network
from mitlplan.errors import TranslationError
from mitlplan.logic.core import Core, holds
from mitlplan.logic.normalize import co_safe, normalize
from mitlplan.logic.parse import parse
from mitlplan.search.fastest import Exhausted, Found, Limits, Stopped, fastest_run
from mitlplan.search.lasso import lassos
from mitlplan.search.tables import tabulate
from mitlplan.translation.compact import translate as compact
from mitlplan.translation.compact.translate import Obligations
from mitlplan.translation.seed import exact_transducers, repaired, two_sided
from mitlplan.workspace import Move, Workspace, graph
from mitlplan.workspace.abstract import abstract
from mitlplan_fuzz.missions import SmallMission, random_mission

LIMITS = Limits(seconds=2)
LATEST = Fraction(14)


def network(workspace: Workspace, start: int, obligations: Obligations) -> Network:
    predicates = {
        name: frozenset(index for index, label in enumerate(workspace.label_sets) if holds(core, label))
        for name, core in obligations.predicates.items()
    }
    return Network(abstract(workspace, start), obligations.transducers, predicates)


def core_of(mission: SmallMission) -> Core:
    return normalize(mission.formula, mission.until, horizon=mission.horizon)


def answer(result: Found | Exhausted | Stopped) -> object:
    match result:
        case Found(time=time, attained=attained):
            return time, attained
        case _:
            return type(result)


@pytest.mark.parametrize("block", range(8))
def test_it_agrees_with_the_compact_construction(block: int) -> None:
    compared = 0
    for number in range(60 * block, 60 * (block + 1)):
        mission = random_mission(number)
        core = core_of(mission)
        finite = mission.horizon == "finite"
        try:
            seed = repaired.translate(core, until_the_end=finite)
        except TranslationError:
            continue
        workspace, start = mission.workspace(), mission.start_index
        other = network(workspace, start, compact.translate(core, until_the_end=finite))
        own = network(workspace, start, seed)
        endless = not finite and not co_safe(core)
        results = [
            fastest_run(tabulate(each), LIMITS.begin(), parkings=endless, horizon=LATEST)
            for each in (own, other)
        ]
        if any(isinstance(result, Stopped) for result in results):
            continue
        compared += 1
        assert answer(results[0]) == answer(results[1]), mission.yaml()
        if endless:
            rounds = [lassos(tabulate(each, objective=False), LIMITS.begin()) for each in (own, other)]
            if not any(isinstance(each, Stopped) for each in rounds):
                assert len({isinstance(each, Exhausted) for each in rounds}) == 1, mission.yaml()
    assert compared > 20


def paper_map(*, waiting: bool) -> Workspace:
    cells = {"pos0": [], "pos1": ["B"], "pos2": [], "pos3": ["A"]}
    names = list(cells)
    moves = [Move(one, names[(index + 1) % 4], 1, both=True) for index, one in enumerate(names)]
    return graph(cells, moves, waiting=waiting)


@pytest.mark.parametrize(
    ("text", "waiting", "least"),
    [
        ("(!A U B) & F A", False, 3),
        ("F[0,4] A & F[0,4] B", False, 3),
        ("F[2,4] A & F[0,2] B", False, 3),
        ("G[0,3] !A & F B", False, 3),
        ("G !B & F A", True, 1),
        ("F[2,4] A", True, 2),
        ("G[2,4](F[1,3] A | B)", False, 5),
        ("G[0,2] !A", False, 2),
        # Asked at 0, silent, and asked again at 1, when what was said at 0 is still to be replayed.
        ("F[0,1] (F[3,4] A & A) & F[3,4] A", False, 5),
        ("F[4,5] A & F[2,3] B", False, 5),
        ("F(A & F[5,6] A) & G[0,7] F[0,2] (A | B)", False, 7),
        # One part is asked of two instants, the second before what was owed for the first is paid.
        ("F[1,2] A & F[0,1] (A & F[1,2] A)", False, 3),
        ("!(F[0,2] B) & F[0,1] (A & F[0,2] B)", False, 3),
    ],
)
def test_least_makespans_on_the_papers_map(text: str, waiting: bool, least: int) -> None:
    core = normalize(parse(text), "standard", horizon="infinite")
    tables = tabulate(network(paper_map(waiting=waiting), 0, repaired.translate(core)))
    assert answer(fastest_run(tables, LIMITS.begin(), parkings=not co_safe(core))) == (least, True)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("G F[0,2) A", "whose open bound"),
        ("F(0,2] A", "whose open bound"),
        ("G (A U[1,2] B)", "a standard until with a lower bound above 0"),
        ("F[2,2] A", "widen the interval"),
        ("G(A -> F[100,101] B)", "needs 200 clocks"),
    ],
)
def test_what_it_cannot_say_is_refused_with_advice(text: str, problem: str) -> None:
    with pytest.raises(TranslationError, match=problem):
        repaired.translate(normalize(parse(text), "standard", horizon="infinite"))


def test_a_late_start_with_a_finite_horizon_is_refused() -> None:
    core = normalize(parse("G[2,inf) A"), "standard", horizon="finite")
    with pytest.raises(TranslationError, match="for horizon: finite"):
        repaired.translate(core, until_the_end=True)


def test_an_operator_that_occurs_twice_is_translated_once() -> None:
    core = normalize(parse("G F[0,2] A & F(B & G[0,2] !A)"), "standard", horizon="infinite")
    names = [transducer.name for transducer in repaired.translate(core).transducers]
    assert names.count("F[0,2] A") == 1
    assert "G[0,2] !A" not in names


OPERAND, OTHER = two_sided.value(0), two_sided.value(1)


def test_the_steps_of_an_eventually_are_the_edges_of_the_exact_one() -> None:
    iota = exact_transducers.eventually_within(Fraction(2), "x")
    names = [location.name for location in iota.locations]
    steps = two_sided.eventually_within("F[0,2] p", Fraction(2), OPERAND, OTHER, "x")
    taken = {(edge.source, edge.target) for edge in steps.edges if {edge.source, edge.target} <= set(names)}
    exact = {(names[edge.source], names[edge.target]) for edge in iota.edges}
    assert taken == exact | {(name, name) for name in names}


def test_the_steps_of_an_until_are_the_edges_of_the_exact_one() -> None:
    iota = exact_transducers.until()
    names = ["neither", "never", "promised", "reached"]
    steps = two_sided.until("p U q", OPERAND, OPERAND, OTHER, until_the_end=False)
    taken = {(edge.source, edge.target) for edge in steps.edges if {edge.source, edge.target} <= set(names)}
    exact = {(names[edge.source], names[edge.target]) for edge in iota.edges}
    assert taken == exact | {(name, name) for name in names}
    kept = {edge.target for edge in steps.edges if edge.marked}
    assert {names[index] for index in iota.buechi[0]} == kept - {"silent"}
