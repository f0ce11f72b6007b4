"""The published construction has the sizes that the paper and its program report."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.automata.iota import Iota
from mitlplan.automata.transducer import Constraint, MapAutomaton, Relation
from mitlplan.errors import TranslationError
from mitlplan.logic.parse import parse
from mitlplan.translation.seed.published import published_automaton
from mitlplan.translation.seed.published_network import published_model
from mitlplan.translation.seed.published_transducers import Flavour, generator, timed_eventually
from tests.translation.seed.paper import PHI, ring, square


@pytest.mark.parametrize(
    ("name", "size", "clocks"),
    [("phi1", (8, 24), 8), ("phi2", (17, 27), 8), ("phi3", (38, 100), 14), ("phi4", (49, 132), 16)],
)
def test_formula_automata_are_as_large_as_the_papers(name: str, size: tuple[int, int], clocks: int) -> None:
    automaton = published_automaton(PHI[name])
    assert automaton.size == size
    assert len(automaton.clocks) + 1 == clocks  # and the clock of the map


@pytest.mark.parametrize(
    ("name", "size"), [("phi1", (11, 22)), ("phi2", (29, 69)), ("phi3", (138, 532)), ("phi4", (184, 681))]
)
def test_products_with_the_2x2_map_are_as_large_as_the_papers(name: str, size: tuple[int, int]) -> None:
    assert published_model(PHI[name], ring()).counted == size


@pytest.mark.parametrize(
    ("name", "chart", "size"),
    [
        ("phi1", square(4), (59, 182)),
        ("phi1", square(8), (251, 886)),
        ("phi2", square(8, a=(7, 0)), (389, 1797)),
        ("phi2", square(8, a=(7, 3)), (389, 1796)),
        ("phi2", square(8, a=(4, 4)), (389, 1795)),
    ],
    ids=["phi1 4x4", "phi1 8x8", "phi2 8x8 corner", "phi2 8x8 edge", "phi2 8x8 inside"],
)
def test_products_with_larger_maps(name: str, chart: MapAutomaton, size: tuple[int, int]) -> None:
    assert published_model(PHI[name], chart).counted == size


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("phi1", {"sys": (12, 26)}),
        ("phi2", {"sys": (22, 62), "sys0": (8, 11), "sys1": (2, 1)}),
        ("phi3", {"sys": (120, 480), "sys0": (17, 49), "sys1": (4, 4)}),
        ("phi4", {"sys": (158, 604), "sys0": (25, 73), "sys1": (4, 4)}),
    ],
)
def test_the_models_are_split_as_the_published_ones(name: str, sizes: dict[str, tuple[int, int]]) -> None:
    automata = published_model(PHI[name], ring()).network.automata
    assert {each.name: (len(each.locations), len(each.edges)) for each in automata} == sizes


def test_the_locations_of_phi1_are_numbered_as_in_the_published_model() -> None:
    (system,) = published_model(PHI["phi1"], ring()).network.automata
    assert system.locations[system.initial].name == "loc0"
    marked = [location.name for location in system.locations if location.name.endswith("_b")]
    assert marked == ["loc5_b", "loc6_b", "loc9_b", "loc10_b"]
    names = [location.name for location in system.locations]
    joined = {(names[edge.source], names[edge.target]) for edge in system.edges}
    assert {("loc0", "loc2"), ("loc2", "loc7"), ("loc7", "loc6_b"), ("loc6_b", "final")} <= joined


@pytest.mark.parametrize("chart", [ring(), square(4)], ids=["2x2", "4x4"])
@pytest.mark.parametrize("name", PHI)
def test_every_copy_of_the_map_has_a_cell_once(name: str, chart: MapAutomaton) -> None:
    """What is in no cell is on no copy."""
    model = published_model(PHI[name], chart)
    places = list(zip(model.layers, model.cells, strict=True))
    on_the_map = [place for place in places if place[1] is not None]
    assert len(set(on_the_map)) == len(on_the_map)
    copies = {layer for layer, _ in on_the_map}
    assert copies == set(range(len(copies)))
    assert {layer for layer, cell in places if cell is None} <= {len(copies)}


def _constants(automaton: Iota) -> set[tuple[str, Constraint]]:
    return {
        (location.name.split(" x ")[-1], constraint)
        for location in automaton.locations
        for constraint in location.invariant
    }


def test_the_program_differs_from_the_paper_in_three_details() -> None:
    formula = PHI["phi2"]
    paper = published_automaton(formula)
    program = published_automaton(formula, flavour=Flavour.PROGRAM)
    assert paper.size == program.size

    changed = _constants(paper.checkers[0]) ^ _constants(program.checkers[0])
    assert {(name, str(constraint)) for name, constraint in changed} == {
        ("CHK_3", "z[5]<2"),
        ("CHK_3", "z[5]<=2"),
        ("CHK_6", "z[5]<2"),
        ("CHK_6", "z[5]<=2"),
    }
    forgotten = [
        (one.resets - other.resets)
        for one, other in zip(paper.checkers[0].edges, program.checkers[0].edges, strict=True)
        if one.resets != other.resets
    ]
    assert set(forgotten) == {frozenset({"z[5]"})}
    lower = {str(bound) for edge in program.main.edges for bound in edge.guard} - {
        str(bound) for edge in paper.main.edges for bound in edge.guard
    }
    assert lower == {"z[2]>=2", "z[4]>=2"}


def test_the_generator_resets_the_clock_of_each_edge_of_its_guess() -> None:
    """Fig. 5: x_1 or y_1 where the guess begins, then y_1, x_2, y_2, and round to x_1."""
    operator = timed_eventually(Fraction(2), Fraction(4), iter(["x1", "y1", "x2", "y2", "x3", "y3", "z"]))
    iota = generator(operator, Flavour.PAPER)
    names = [location.name for location in iota.locations]
    assert {(names[edge.source], names[edge.target], *edge.resets) for edge in iota.edges} == {
        ("Gen0", "Gen_1", "x1"),
        ("Gen0", "Gen_2", "y1"),
        ("Gen_1", "Gen_2", "y1"),
        ("Gen_2", "Gen_3", "x2"),
        ("Gen_3", "Gen_4", "y2"),
        ("Gen_4", "Gen_5", "x3"),
        ("Gen_5", "Gen_6", "y3"),
        ("Gen_6", "Gen_1", "x1"),
    }


def test_one_edge_waits_for_the_rise_and_one_for_the_fall() -> None:
    (checker,) = published_automaton(parse("F[2,4] A")).checkers
    at_least = {
        str(bound) for edge in checker.edges for bound in edge.guard if bound.relation is Relation.AT_LEAST
    }
    assert at_least == {"z[2]>=4", "z[4]>=4", "z[6]>=4", "z[1]>=2", "z[3]>=2", "z[5]>=2", "z[2]>=2"}


@pytest.mark.parametrize("text", ["X A", "F[0,3) A", "F[2,inf) A", "F[2,2] A"])
def test_what_the_paper_has_no_transducer_for_is_refused(text: str) -> None:
    with pytest.raises(TranslationError, match="the published construction"):
        published_automaton(parse(text))


@pytest.mark.parametrize("text", ["F[0,2] A & F B", "F[0,2] (A & F[0,2] B)", "A U F[0,2] B"])
def test_mixtures_that_the_program_ignores_are_refused(text: str) -> None:
    with pytest.raises(TranslationError, match="cannot handle a timed operator"):
        published_model(parse(text), ring())


def test_a_choice_of_first_guesses_is_told_to_the_generator() -> None:
    network = published_model(parse("F[0,2] A | F[0,2] B"), ring()).network
    assert [variable.most for variable in network.variables] == [2]
    start = network.automata[0].locations[network.automata[0].initial]
    assert start.name == "start"


def test_two_checkers_that_verify_at_once_announce_one_after_the_other() -> None:
    network = published_model(parse("F[0,2] A & F[0,4] A"), ring()).network
    stops = [at for at in network.automata[0].locations if at.name.startswith("sys_")]
    assert stops
    assert all(replace(at, name="") == replace(stops[0], name="") for at in stops)
