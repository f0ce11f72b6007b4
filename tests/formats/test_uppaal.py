"""UPPAAL models are written as the document type asks, and drawn like the map."""

from __future__ import annotations

import shutil
import subprocess
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from mitlplan.automata.lockstep import lockstep
from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Location,
    Network,
    Number,
    Query,
    Synchronisation,
    Target,
    Test,
    Urgency,
    Variable,
)
from mitlplan.automata.transducer import Constraint, Relation
from mitlplan.formats.layout import BEND, CELL, cell_points, copies_of_map, nails, rows
from mitlplan.formats.uppaal import LARGEST, write_uppaal
from mitlplan.logic.normalize import normalize
from mitlplan.translation.seed import repaired
from mitlplan.translation.seed.published_network import published_model
from mitlplan.workspace import Move, graph, grid
from tests.formats.uppaal_structure import faults
from tests.translation.seed.paper import PHI, ring, square
from tests.translation.seed.test_repaired import network, paper_map

HALF = Fraction(1, 2)


def everything() -> tuple[Network, Query]:
    """A network that uses everything there is."""
    late = (Constraint("x[1]", Relation.AT_LEAST, HALF), Constraint("y", Relation.LESS, Fraction(2)))
    sender = Automaton(
        "sender",
        (
            Location(
                "idle", (Constraint("y", Relation.AT_MOST, Fraction(3, 2)),), stopped=frozenset({"x[0]"})
            ),
            Location("busy", urgency=Urgency.URGENT),
            Location("and", urgency=Urgency.COMMITTED, running=frozenset({"y"})),
        ),
        (
            Edge(0, 1, late, frozenset({"y", "x[0]"}), Synchronisation("go[1]", sends=True)),
            Edge(1, 2, tests=(Test(Variable("n"), "<", Number(3)),)),
            Edge(2, 0, assignments=(Assignment("n", Arithmetic("+", Variable("n"), Number(1))),)),
            Edge(2, 2, synchronisation=Synchronisation("all", sends=True)),
        ),
    )
    receiver = Automaton(
        "receiver",
        (Location("wait"), Location("7-done")),
        (
            Edge(0, 1, synchronisation=Synchronisation("go[1]", sends=False)),
            Edge(1, 0, synchronisation=Synchronisation("all", sends=False)),
            Edge(0, 1, tests=(Test(Variable("flag[0]"), "==", Number(1)),)),
        ),
        initial=1,
    )
    both = Network(
        (sender, receiver),
        clocks=("x[0]", "x[1]", "y"),
        channels=(Channel("go[0]"), Channel("go[1]"), Channel("all", broadcast=True)),
        variables=(BoundedInteger("n", 1, 3, 2), BoundedInteger("flag[0]"), BoundedInteger("flag[1]")),
    )
    late_target = Target(
        {"sender": "idle", "receiver": "7-done"},
        (Constraint("y", Relation.AT_LEAST, HALF),),
        (Test(Variable("n"), "==", Number(3)),),
    )
    return both, Query((late_target, Target({"sender": "and"})), clock="y")


def test_the_whole_text_of_a_small_model() -> None:
    gate = Automaton(
        "gate",
        (Location("open", (Constraint("z", Relation.AT_MOST, HALF),)), Location("shut")),
        (Edge(0, 1, (Constraint("z", Relation.AT_LEAST, HALF),), frozenset({"z"})),),
    )
    text = write_uppaal(Network((gate,), ("z",)), Query((Target({"gate": "shut"}),)), notes=["the gate"])
    assert (
        text
        == """\
<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System 1.6//EN' \
'http://www.it.uu.se/research/group/darts/uppaal/flat-1_6.dtd'>
<nta>
	<declaration>// A time unit is 1/2 s: every constant was multiplied by 2.
// the gate
clock z;
</declaration>
	<template>
		<name x="5" y="5">gate</name>
		<location id="id0" x="0" y="0">
			<name x="0" y="15">open</name>
			<label kind="invariant" x="0" y="30">z &lt;= 1</label>
		</location>
		<location id="id1" x="272" y="0">
			<name x="272" y="15">shut</name>
		</location>
		<init ref="id0"/>
		<transition>
			<source ref="id0"/>
			<target ref="id1"/>
			<label kind="guard" x="136" y="-15">z &gt;= 1</label>
			<label kind="assignment" x="136" y="15">z = 0</label>
		</transition>
	</template>
	<system>system gate;</system>
	<queries>
		<query>
			<formula>E&lt;&gt; gate.shut</formula>
			<comment>Is there a plan? The fastest: verifyta -t 2.</comment>
		</query>
	</queries>
</nta>
"""
    )


def test_declarations_guards_and_queries() -> None:
    root = ET.fromstring(write_uppaal(*everything()))  # noqa: S314
    assert (root.findtext("declaration") or "").splitlines()[1:] == [
        "clock x[2], y;",
        "chan go[2];",
        "broadcast chan all;",
        "int[1,3] n = 2;",
        "int[0,1] flag[2];",
    ]
    labels = {(label.get("kind"), label.text) for label in root.iter("label")}
    assert labels == {
        ("invariant", "y <= 3 && x[0]' == 0"),
        ("invariant", "y' == 1"),
        ("guard", "x[1] >= 1 && y < 4"),
        ("guard", "n < 3"),
        ("guard", "flag[0] == 1"),
        ("synchronisation", "go[1]!"),
        ("synchronisation", "go[1]?"),
        ("synchronisation", "all!"),
        ("synchronisation", "all?"),
        ("assignment", "x[0] = 0, y = 0"),
        ("assignment", "n = (n + 1)"),
    }
    assert [formula.text for formula in root.iter("formula")] == [
        "E<> (sender.idle && receiver.l7_done && y >= 1 && n == 3) || (sender.and_2)",
        "inf{(sender.idle && receiver.l7_done && y >= 1 && n == 3) || (sender.and_2)}: y",
    ]


def models() -> dict[str, str]:
    """Every kind of model that is written."""
    texts = {name: write_uppaal(*_published(name)) for name in PHI}
    texts["everything"] = write_uppaal(*everything())
    for name, formula in PHI.items():
        core = normalize(formula, "standard", horizon="infinite")
        own = network(paper_map(waiting=True), 0, repaired.translate(core))
        stepped = lockstep(own, ["pos0", "pos1", "pos2", "pos3"], parkings=True)
        texts[f"{name} repaired"] = write_uppaal(stepped.network, stepped.query, notes=stepped.meanings)
    return texts


def _published(name: str) -> tuple[Network, Query]:
    model = published_model(PHI[name], ring())
    return model.network, model.query


MODELS = models()


@pytest.mark.parametrize("name", MODELS)
def test_every_model_has_the_structure_that_the_document_type_asks_for(name: str) -> None:
    assert faults(MODELS[name]) == []


@pytest.mark.skipif(shutil.which("syntaxcheck") is None, reason="libutap's syntaxcheck is not on the PATH")
@pytest.mark.parametrize("name", MODELS)
def test_every_model_passes_syntaxcheck(name: str, tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text(MODELS[name])
    subprocess.run(["syntaxcheck", str(file)], check=True)  # noqa: S603, S607


def test_names_of_the_paper_are_kept() -> None:
    root = ET.fromstring(MODELS["phi1"])  # noqa: S314
    names = [name.text for name in root.iterfind("template/location/name")]
    assert names[:7] == ["loc0", "loc1", "loc2", "loc3", "loc4", "loc5_b", "loc6_b"]
    assert names[-1] == "final"
    assert root.findtext("system") == "system sys;"
    assert ET.fromstring(MODELS["phi3"]).findtext("system") == "system sys, sys0, sys1;"  # noqa: S314


def test_a_time_that_is_too_large_is_refused() -> None:
    slow = Automaton("a", (Location("l", (Constraint("z", Relation.AT_MOST, Fraction(LARGEST + 1)),)),), ())
    with pytest.raises(OverflowError, match="more than UPPAAL's 1073741824"):
        write_uppaal(Network((slow,), ("z",)), Query(()))


def test_the_map_looks_like_the_map() -> None:
    assert cell_points(paper_map(waiting=False)) == [(0, 0), (CELL, 0), (CELL, CELL), (0, CELL)]
    assert cell_points(grid(2, 3)) == [(column * CELL, row * CELL) for row in range(2) for column in range(3)]
    pair = graph({"a": [], "b": []}, [Move("a", "b", 1)])
    assert len(set(cell_points(pair))) == 2
    assert cell_points(graph({"a": []}, [])) == [(0, 0)]


@pytest.mark.parametrize("name", PHI)
def test_no_two_locations_are_drawn_on_one_place(name: str) -> None:
    model = published_model(PHI[name], square(3))
    places = copies_of_map(model.cells, model.layers, cell_points(grid(3, 3)))
    assert len(set(places)) == len(places)


def test_copies_of_the_map_stand_side_by_side() -> None:
    places = copies_of_map([0, 1, 0, 1, None], [0, 0, 1, 1, 2], [(0, 0), (CELL, 0)])
    assert places == ((0, 0), (CELL, 0), (2 * CELL, 0), (3 * CELL, 0), (0, 2 * CELL))


def test_edges_get_round_each_other_and_round_locations() -> None:
    line = Automaton(
        "line",
        tuple(Location(name) for name in "abc"),
        (Edge(0, 1), Edge(1, 0), Edge(0, 2), Edge(2, 2), Edge(2, 2), Edge(1, 2)),
    )
    places = ((0, 0), (CELL, 0), (2 * CELL, 0))
    through = nails(line, places)
    assert through[0] != through[1]
    assert through[2] == ((CELL, BEND),)
    assert len(through[3]) == len(through[4]) == 2
    assert through[3] != through[4]
    assert through[5] == ()
    assert all(one != other for one, other in combinations([nail for nail in through if nail], 2))


def test_rows_are_about_as_long_as_there_are_rows() -> None:
    assert len(set(rows(10))) == 10
    assert max(x for x, _ in rows(10)) == 3 * CELL
