"""TChecker models are written as its format asks, and mean the same."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.automata.folding import fold_columns
from mitlplan.automata.lockstep import Lockstep, lockstep
from mitlplan.automata.timed_automaton import Automaton, Edge, Location, Network, Query, Target
from mitlplan.automata.transducer import Constraint, Relation
from mitlplan.errors import ToolError
from mitlplan.formats.tchecker import write_tchecker
from mitlplan.logic.normalize import normalize
from mitlplan.logic.parse import parse
from mitlplan.translation.compact.translate import translate as compact
from mitlplan.translation.seed.published_network import published_model
from mitlplan.translation.seed.repaired import translate as seed
from mitlplan.workspace import Workspace, grid
from tests.formats.tck import read_tck
from tests.formats.test_uppaal import everything
from tests.oracles.published_reach import reach
from tests.translation.seed.paper import PHI, ring
from tests.translation.seed.test_repaired import network, paper_map


def stepped(text: str, workspace: Workspace, translate: object = seed) -> Lockstep:
    core = normalize(parse(text), "standard", horizon="infinite")
    own = network(workspace, 0, translate(core))  # type: ignore[operator]
    return lockstep(own, list(workspace.names), parkings=False)


def test_the_whole_text_of_a_small_model() -> None:
    half = Fraction(1, 2)
    gate = Automaton(
        "gate",
        (Location("open", (Constraint("z", Relation.AT_MOST, half),)), Location("shut")),
        (Edge(0, 1, (Constraint("z", Relation.AT_LEAST, half),), frozenset({"z"})),),
    )
    query = Query((Target({"gate": "shut"}),))
    assert write_tchecker(Network((gate,), ("z", "t")), query, bound=Fraction(1, 3), notes=["the gate"]) == (
        "# A time unit is 1/6 s: every constant was multiplied by 6.\n"
        "# the gate\n"
        "# tck-reach -a covreach -l goal0\n"
        "system:mitlplan\n"
        "clock:1:z\n"
        "clock:1:t\n"
        "event:tau\n"
        "process:gate\n"
        "location:gate:open{initial: : invariant: z <= 3}\n"
        "location:gate:shut{labels: goal0}\n"
        "edge:gate:open:shut:tau{provided: z >= 3 && t <= 2 : do: z = 0}\n"
    )


@pytest.mark.parametrize("translate", [seed, compact], ids=["seed", "compact"])
@pytest.mark.parametrize(("text", "least"), [("F[1/2,3/2] A & F[0,4] B", 3), ("F[0,1] A & F[0,1] B", None)])
def test_a_model_that_is_read_back_has_the_same_least_time(
    translate: object, text: str, least: int | None
) -> None:
    own = stepped(text, paper_map(waiting=False), translate)
    read, query = read_tck(write_tchecker(own.network, own.query))
    found = reach(read, query, latest=Fraction(10))
    scale = 2 if "1/2" in text else 1
    assert (found and found.time / scale) == least


@pytest.mark.parametrize(("bound", "reached"), [("3", True), ("5/2", False)])
def test_a_bound_is_put_on_the_way_to_the_goal(bound: str, reached: bool) -> None:
    own = stepped("F[0,4] A & F[0,4] B", paper_map(waiting=False))
    read, query = read_tck(write_tchecker(own.network, own.query, bound=Fraction(bound)))
    assert (reach(read, query, latest=Fraction(12)) is not None) == reached


def test_everything_but_stopped_clocks_is_written() -> None:
    both, query = everything()
    plain = [replace(at, stopped=frozenset()) for at in both.automata[0].locations]
    running = replace(both, automata=(replace(both.automata[0], locations=tuple(plain)), both.automata[1]))
    one = Query((Target({"sender": "busy"}),))
    read, _ = read_tck(write_tchecker(running, one))
    assert [len(each.edges) for each in read.automata] == [4, 3]
    assert [(channel.name, channel.broadcast) for channel in read.channels] == [
        ("go_0", False),
        ("go_1", False),
        ("all", True),
    ]
    with pytest.raises(ToolError, match="no stopped clocks"):
        write_tchecker(both, one)
    with pytest.raises(ToolError, match="locations alone, in each automaton independently"):
        write_tchecker(running, query)


def test_the_published_generator_needs_stopped_clocks() -> None:
    model = published_model(PHI["phi2"], ring())
    with pytest.raises(ToolError, match="no stopped clocks"):
        write_tchecker(model.network, model.query)
    untimed = published_model(PHI["phi1"], ring())
    read, query = read_tck(write_tchecker(untimed.network, untimed.query))
    found = reach(read, query, latest=Fraction(8))
    assert found is not None
    assert found.time == 3


def test_an_edge_without_a_partner_is_left_out() -> None:
    both, _ = everything()
    alone = replace(both, automata=(replace(both.automata[1], name="alone"),))
    read, _ = read_tck(write_tchecker(alone, Query((Target({"alone": "wait"}),))))
    assert [edge.synchronisation for edge in read.automata[0].edges] == [None]


def folded(own: Lockstep, columns: int) -> Network:
    robot, *watchers = own.network.automata
    coordinates = [None if cell is None else divmod(cell, columns) for cell in own.cells]
    automaton, column = fold_columns(robot, coordinates, "column")
    return replace(own.network, automata=(automaton, *watchers), variables=(*own.network.variables, column))


@pytest.mark.parametrize("text", ["(!A U B) & F A", "F[0,3] A & G[0,2] !B"])
def test_a_grid_with_a_location_a_row_means_the_same(text: str) -> None:
    workspace = grid(3, 4, blocked=[[1, 1]], regions={"A": [[2, 0]], "B": [[0, 2], [0, 3]]})
    own = stepped(text, workspace)
    cells = [divmod(int(name[1]) * 4 + int(name[3]), 4) for name in workspace.names]
    robot, *watchers = own.network.automata
    coordinates = [None if cell is None else cells[cell] for cell in own.cells]
    automaton, column = fold_columns(robot, coordinates, "column")
    variables = (*own.network.variables, column)
    smaller = replace(own.network, automata=(automaton, *watchers), variables=variables)
    assert len(automaton.locations) < len(robot.locations) / 1.5
    expected = reach(own.network, own.query, latest=Fraction(12))
    found = reach(smaller, own.query, latest=Fraction(12))
    assert (found and found.time) == (expected and expected.time)
    read, query = read_tck(write_tchecker(smaller, own.query))
    again = reach(read, query, latest=Fraction(12))
    assert (again and again.time) == (expected and expected.time)


def test_a_large_grid_has_few_locations_and_edges() -> None:
    own = stepped("F A", grid(20, 20, regions={"A": [[19, 19]]}))
    robot = own.network.automata[0]
    small = folded(own, 20).automata[0]
    assert (len(robot.locations), len(robot.edges)) == (802, 2721)
    assert len(small.locations) == 42
    assert len(small.edges) < 220
