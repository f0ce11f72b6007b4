"""Transducers in lock step, as a network with committed chains, plan as the search does."""

from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan.automata.lockstep import lockstep
from mitlplan.automata.timed_automaton import Urgency
from mitlplan.logic.normalize import co_safe, normalize
from mitlplan.logic.parse import parse
from mitlplan.search.fastest import Found, Limits, fastest_run
from mitlplan.search.tables import tabulate
from mitlplan.translation.compact.translate import translate as compact
from mitlplan.translation.seed.repaired import translate as seed
from tests.oracles.published_reach import reach
from tests.translation.seed.test_repaired import network, paper_map

NAMES = ["pos0", "pos1", "pos2", "pos3"]


@pytest.mark.parametrize("waiting", [False, True])
@pytest.mark.parametrize("translate", [compact, seed], ids=["compact", "seed"])
@pytest.mark.parametrize(
    "text",
    [
        "(!A U B) & F A",
        "F[0,4] A & F[0,4] B",
        "F[2,4] A & F[0,2] B",
        "G[0,3] !A & F B",
        "G !B & F A",
        "F[2,4] G[0,1] A",
        "F[0,1] A & F[0,1] B",
    ],
)
def test_the_least_time_is_that_of_the_search(text: str, translate: object, waiting: bool) -> None:
    core = normalize(parse(text), "standard", horizon="infinite")
    parkings = not co_safe(core)
    own = network(paper_map(waiting=waiting), 0, translate(core))  # type: ignore[operator]
    searched = fastest_run(tabulate(own), Limits(10).begin(), parkings=parkings)
    stepped = lockstep(own, NAMES, parkings=parkings)
    found = reach(stepped.network, stepped.query, latest=Fraction(6))
    assert (found and found.time) == (searched.time if isinstance(searched, Found) else None)


def test_a_step_passes_the_turn_from_one_to_the_next() -> None:
    core = normalize(parse("F[0,2] A & F B"), "standard", horizon="infinite")
    stepped = lockstep(network(paper_map(waiting=True), 0, seed(core)), NAMES, parkings=True)
    robot, *watchers = stepped.network.automata
    assert stepped.cells == (0, 1, 2, 3, 0, 1, 2, 3, None, None)
    assert [location.name for location in robot.locations[:5]] == [*NAMES, "pos0_"]
    assert robot.locations[robot.initial].urgency is Urgency.COMMITTED
    sent = {str(edge.synchronisation) for edge in robot.edges if edge.synchronisation}
    assert sent == {"go[0]!", "end[0]!", "park[0]!"}
    for place, watcher in enumerate(watchers):
        heard = {str(edge.synchronisation) for edge in watcher.edges if edge.synchronisation}
        turn = {f"{kind}[{place}]?" for kind in ("go", "end", "park")}
        passed = {f"{kind}[{place + 1}]!" for kind in ("go", "end", "park")}
        assert heard == (turn if place == len(watchers) - 1 else turn | passed)
    assert [dict(target.locations) for target in stepped.query.targets] == [
        {watchers[-1].name: "final"},
        {watchers[-1].name: "parked"},
    ]


def test_parking_is_left_out_where_it_is_no_end() -> None:
    core = normalize(parse("F[0,2] A"), "standard", horizon="infinite")
    without = lockstep(network(paper_map(waiting=True), 0, seed(core)), NAMES, parkings=False)
    assert len(without.query.targets) == 1
    never = lockstep(network(paper_map(waiting=False), 0, seed(core)), NAMES, parkings=True)
    assert len(never.query.targets) == 1
    assert not any(channel.name.startswith("park") for channel in never.network.channels)


def test_signals_and_clocks_are_explained() -> None:
    core = normalize(parse("F[0,2] A"), "standard", horizon="infinite")
    stepped = lockstep(network(paper_map(waiting=False), 0, seed(core)), NAMES, parkings=False)
    explained = dict(line.split(" is ") for line in stepped.meanings)
    assert set(explained) == {variable.name for variable in stepped.network.variables} | {
        clock for clock in stepped.network.clocks if clock.startswith("x")
    }
