"""UPPAAL models are read back as they were written, and nothing is read as what it is not."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.automata.lockstep import lockstep
from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    BoundedInteger,
    Network,
    Number,
    Synchronisation,
    Test,
    Urgency,
    Variable,
    ticks_per_second,
)
from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.errors import ModelError
from mitlplan.formats.uppaal import write_uppaal
from mitlplan.formats.uppaal_query import read_query
from mitlplan.formats.uppaal_read import UppaalModel, read_uppaal
from mitlplan.logic.normalize import normalize
from mitlplan.logic.parse import parse
from mitlplan.translation.seed import repaired
from tests.formats.test_uppaal import MODELS, everything
from tests.oracles.published_reach import reach
from tests.translation.seed.test_repaired import network, paper_map


def model(
    declaration: str = "",
    *,
    local: str = "",
    parameter: str = "",
    invariant: str = "",
    labels: str = "",
    system: str = "system P;",
    location: str = "",
    extra: str = "",
) -> bytes:
    """A model with one template of two locations and one edge."""

    def tagged(tag: str, text: str) -> str:
        return f"<{tag}>{text}</{tag}>" if text else ""

    return f"""<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE nta PUBLIC '-//Uppaal Team//DTD Flat System 1.1//EN' 'http://www.it.uu.se/flat-1_1.dtd'>
<nta>{tagged("declaration", declaration)}
<template><name>P</name>{tagged("parameter", parameter)}{tagged("declaration", local)}
<location id="a"><name>A</name><label kind="invariant">{invariant}</label>{location}</location>
<location id="b"/>{extra}<init ref="a"/>
<transition><source ref="a"/><target ref="b"/>
{labels}
</transition></template>
<system>{system}</system></nta>""".encode()


def guard(text: str) -> str:
    return f'<label kind="guard">{text}</label>'


def assignment(text: str) -> str:
    return f'<label kind="assignment">{text}</label>'


def sync(text: str) -> str:
    return f'<label kind="synchronisation">{text}</label>'


def scaled(network: Network) -> Network:
    """The network with its times in time units, names aside."""
    factor = ticks_per_second(network)

    def units(constraints: Guard) -> Guard:
        return tuple(replace(each, bound=each.bound * factor) for each in constraints)

    return replace(
        network,
        automata=tuple(
            replace(
                each,
                locations=tuple(
                    replace(at, name=str(index), invariant=units(at.invariant))
                    for index, at in enumerate(each.locations)
                ),
                edges=tuple(replace(edge, guard=units(edge.guard)) for edge in each.edges),
            )
            for each in network.automata
        ),
    )


def same_but_for_order(network: Network) -> Network:
    return replace(network, variables=tuple(sorted(network.variables, key=lambda each: each.name)))


def test_what_was_written_is_read_back() -> None:
    written, query = everything()
    read = read_uppaal(MODELS["everything"].encode())
    assert same_but_for_order(scaled(read.network)) == same_but_for_order(scaled(written))
    assert len(read.queries) == 2
    asked = read_query(read.queries[1], read)
    assert asked.clock == query.clock
    assert [len(target.locations) for target in asked.targets] == [2, 1]


@pytest.mark.parametrize("name", ["phi1", "phi2", "phi3"])
def test_a_published_model_that_is_read_back_has_the_papers_least_time(name: str) -> None:
    read = read_uppaal(MODELS[name].encode())
    for text in read.queries:
        found = reach(read.network, read_query(text, read), latest=Fraction(8))
        assert found is not None
        assert found.time == {"phi1": 3, "phi2": 2, "phi3": 4}[name]


@pytest.mark.parametrize(
    ("text", "least"),
    [("F[1,2] A & F[0,3] B", 3), ("F[0,1] A & F[0,1] B", None), ("F[1/2,3/2] A", 1), ("G[0,3] !A & F B", 3)],
)
def test_a_repaired_model_that_is_read_back_has_the_same_least_time(text: str, least: int | None) -> None:
    core = normalize(parse(text), "standard", horizon="infinite")
    own = network(paper_map(waiting=False), 0, repaired.translate(core))
    stepped = lockstep(own, ["pos0", "pos1", "pos2", "pos3"], parkings=False)
    read = read_uppaal(write_uppaal(stepped.network, stepped.query).encode())
    factor = ticks_per_second(stepped.network)
    found = reach(read.network, read_query(read.queries[0], read), latest=Fraction(4 * factor))
    assert (found and found.time / factor) == least


def read(text: bytes) -> UppaalModel:
    return read_uppaal(text, file="m.xml")


def test_a_model_in_other_words() -> None:
    found = read(
        model(
            "const int N = 2; typedef int[0,N] small; small n, m = 1; /* so */"
            "bool up = true; clock x, y[N+1]; // and so",
            local="clock z; urgent_not_here".replace("urgent_not_here", "int[0,9] k;"),
            invariant="x &lt; 3 and z &lt;= N*2 &amp;&amp; 1 == y[0]'",
            labels=guard("2 &lt;= x &amp;&amp; z == 1 and not up &amp;&amp; n + 1 != m &amp;&amp; true")
            + assignment("x := 0, y[2] = 0, n++, m = 3 - n, up = false, k += 2"),
            location="<urgent/>",
        )
    ).network
    (automaton,) = found.automata
    assert found.clocks == ("x", "y[0]", "y[1]", "y[2]", "P_z")
    assert found.variables == (
        BoundedInteger("n", 0, 2),
        BoundedInteger("m", 0, 2, 1),
        BoundedInteger("up", 0, 1, 1),
        BoundedInteger("P_k", 0, 9),
    )
    assert automaton.locations[0].urgency is Urgency.URGENT
    assert automaton.locations[0].running == {"y[0]"}
    assert [str(each) for each in automaton.locations[0].invariant] == ["x<3", "P_z<=4"]
    assert automaton.locations[1].name == "b"
    (edge,) = automaton.edges
    assert edge.guard == (
        Constraint("x", Relation.AT_LEAST, Fraction(2)),
        Constraint("P_z", Relation.AT_LEAST, Fraction(1)),
        Constraint("P_z", Relation.AT_MOST, Fraction(1)),
    )
    assert edge.tests == (
        Test(Variable("up"), "==", Number(0)),
        Test(Arithmetic("+", Variable("n"), Number(1)), "!=", Variable("m")),
    )
    assert edge.resets == {"x", "y[2]"}
    assert edge.assignments == (
        Assignment("n", Arithmetic("+", Variable("n"), Number(1))),
        Assignment("m", Arithmetic("-", Number(3), Variable("n"))),
        Assignment("up", Number(0)),
        Assignment("P_k", Arithmetic("+", Variable("P_k"), Number(2))),
    )


def test_templates_with_parameters_become_processes() -> None:
    text = model(
        "chan c[3]; int id;",
        parameter="const int k",
        labels=sync("c[k]!"),
        system="Q = P(1); R = P(2); system Q, R;",
    )
    network = read(text).network
    assert [each.name for each in network.automata] == ["Q", "R"]
    assert [each.edges[0].synchronisation for each in network.automata] == [
        Synchronisation("c[1]", sends=True),
        Synchronisation("c[2]", sends=True),
    ]


def test_a_parameter_with_a_range_stands_for_all_its_values() -> None:
    text = model(
        "int id;", parameter="const int[1,3] k", local="clock x;", labels=guard("id == k"), system="system P;"
    )
    network = read(text).network
    assert [each.name for each in network.automata] == ["P_1", "P_2", "P_3"]
    assert network.clocks == ("P_1_x", "P_2_x", "P_3_x")
    assert network.automata[2].edges[0].tests == (Test(Variable("id"), "==", Number(3)),)


def test_fischers_protocol_is_read() -> None:
    declaration = "const int N = 2; typedef int[1,N] id_t; int id;"
    locations = """<location id="id0"><name>A</name></location>
<location id="id1"><name>req</name><label kind="invariant">x &lt;= k</label></location>
<location id="id2"><name>wait</name></location><location id="id3"><name>cs</name></location>"""
    fischer = f"""<nta><declaration>{declaration}</declaration>
<template><name>P</name><parameter>const id_t pid</parameter>
<declaration>clock x; const int k = 2;</declaration>{locations}<init ref="id0"/>
<transition><source ref="id0"/><target ref="id1"/>{guard("id == 0")}{assignment("x = 0")}</transition>
<transition><source ref="id1"/><target ref="id2"/>{guard("x &lt;= k")}{assignment("x = 0, id = pid")}
</transition>
<transition><source ref="id2"/><target ref="id3"/>{guard("x &gt; k &amp;&amp; id == pid")}</transition>
<transition><source ref="id3"/><target ref="id0"/>{assignment("id = 0")}</transition>
</template><system>system P;</system>
<queries><query><formula>E&lt;&gt; P_1.cs &amp;&amp; P_2.cs</formula><comment/></query></queries>
</nta>""".encode()
    found = read(fischer)
    assert reach(found.network, read_query(found.queries[0], found), latest=Fraction(30)) is None
    alone = reach(found.network, read_query("E<> P_2.cs", found), latest=Fraction(30))
    assert alone is not None
    assert alone.time == 3  # just over 2, on the grid of whole units


def problem(text: bytes) -> str:
    with pytest.raises(ModelError) as caught:
        read(text)
    return str(caught.value)


def test_what_is_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = b"<nta><declaration>clock x, y;</declaration><system></system></nta>"
    monkeypatch.setattr("mitlplan.formats.uppaal_syntax.MOST_WORDS", 3)
    assert problem(sound) == "m.xml:1: declaration: more than 3 words in one text are not read"
    monkeypatch.setattr("mitlplan.formats.uppaal_tree.MOST_ELEMENTS", 2)
    assert problem(sound) == "m.xml:1: the model is too large or too deep to be read"
    monkeypatch.setattr("mitlplan.formats.uppaal_tree.MOST_BYTES", len(sound) - 1)
    assert problem(sound) == "m.xml: the file has more than 0 MB, which is not read"


@pytest.mark.parametrize(
    ("declaration", "message"),
    [
        ("clock x; double d;", "'double' is not read; only clocks, channels and integers are"),
        ("urgent chan c;", "urgent channels are not read"),
        ("clock x, x;", "x is declared twice"),
        ("int n[2] = 1;", "initial values of an array are not read"),
        ("int[0,1] n = 2;", "the initial value 2 lies outside [0,1]"),
        ("int[2,1] n;", "no integer lies in [2,1]"),
        ("clock c[2][2];", "an array of arrays is not read"),
        ("clock c[200000];", "more than 100000 clocks, channels and integers are not read"),
        ("int n; clock c[n];", "a constant was expected here, not a variable"),
        ("void f() { }", "'void' is not read; only clocks, channels and integers are"),
        ("clock $;", "'$' is not understood here"),
        ("const int N = 12345678901;", "the number 12345678901 is too large"),
    ],
)
def test_declarations_that_are_not_read(declaration: str, message: str) -> None:
    line = 3 + declaration.count("\n")
    assert problem(model(declaration)) == f"m.xml:{line}: declaration: {message}"


@pytest.mark.parametrize(
    ("declaration", "condition", "message"),
    [
        ("clock x;", "x &lt; 1 || x &gt; 2", "'||' is not read in a guard; write two edges"),
        ("clock x, y;", "x - y &lt; 1", "a difference of clocks is not read"),
        ("clock x, y;", "x &lt; y", "two clocks are compared, which is not read"),
        ("clock x;", "x != 1", "a clock compared by '!=' is not read; write two edges"),
        ("clock x;", "x &lt; -1", "the clock x is never negative, but compared with -1"),
        ("clock x;", "x", "x is no condition"),
        ("clock x;", "x &lt; 1 1", "'1' was not expected here"),
        ("clock x;", "f(x) == 1", "the function f is not read; only what the network itself does is"),
        ("", "x &lt; 1", "x is not declared"),
        ("int n;", "n / 2 == 1", "'/' is not read in an expression over integers"),
        ("int n[2];", "n == 1", "n is an array; one element was expected"),
        ("int n[2];", "n[2] == 1", "n has no element 2, only 0 to 1"),
        ("int n[2]; int i;", "n[i] == 1", "a constant was expected here, not a variable"),
    ],
)
def test_guards_that_are_not_read(declaration: str, condition: str, message: str) -> None:
    assert problem(model(declaration, labels=guard(condition))) == f"m.xml:8: guard of P: A -> b: {message}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (model("clock x\nclock y;"), "m.xml:4: declaration: ';' was expected, not 'clock'"),
        (
            model("clock x;", invariant="x' == 2"),
            "m.xml:5: invariant of P.A: only clocks have rates, and only the rates 0 and 1 are read",
        ),
        (
            model("int n;", invariant="n == 0"),
            "m.xml:5: invariant of P.A: an invariant over integers is not read",
        ),
        (
            model("clock x;", labels=assignment("x = 1")),
            "m.xml:8: assignment of P: A -> b: a clock can only be reset to 0",
        ),
        (
            model("chan c;", labels=assignment("c = 1")),
            "m.xml:8: assignment of P: A -> b: c cannot be assigned to",
        ),
        (model("int n;", labels=sync("n!")), "m.xml:8: synchronisation of P: A -> b: n is no channel"),
        (
            model("chan c;", labels=sync("c")),
            "m.xml:8: synchronisation of P: A -> b: '?' was expected, not the end",
        ),
        (
            model("", labels='<label kind="select">i : int[0,1]</label>'),
            "m.xml:8: select of P: A -> b: a label of kind select is not read",
        ),
        (
            model("", location='<label kind="exponentialrate">1</label>'),
            "m.xml:5: location P.A: a label of kind exponentialrate is not read",
        ),
        (model("", extra='<branchpoint id="c"/>'), "m.xml:4: template P: branch points are not read"),
        (model("", parameter="int &amp;n"), "m.xml:4: parameter of P: parameters by reference are not read"),
        (model("", parameter="clock x"), "m.xml:4: parameter of P: only integer parameters are read"),
        (model("", parameter="int n"), "m.xml:10: system: the parameter n of P has no value and no range"),
        (model("", parameter="int[0,999999] n"), "m.xml:10: system: more than 100000 processes are not read"),
        (model("", system="Q = P(1); system Q;"), "m.xml:10: system: P has 0 parameters, not 1"),
        (model("", system="Q = R(); system Q;"), "m.xml:10: system: there is no template R"),
        (model("", system="system R;"), "m.xml:10: system: there is no template or process R"),
        (model("", system="system P &lt; P;"), "m.xml:10: system: ';' was expected, not '<'"),
        (model("", system="int n;"), "m.xml: there is no system line: which templates run is not said"),
        (b"<nta>", "m.xml:1: this is no XML: no element found"),
        (b"<html/>", "m.xml: this is no UPPAAL model: the outermost element is not nta"),
        (b"<nta><system>system ;</system></nta>", "m.xml:1: system: a name was expected, not ';'"),
    ],
)
def test_what_is_not_read_is_an_error_with_its_place(text: bytes, message: str) -> None:
    assert problem(text) == message


def test_entities_are_refused() -> None:
    bomb = b'<!DOCTYPE nta [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><nta><system>&b;</system></nta>'
    assert problem(bomb) == "m.xml: entities are not read"
    stolen = b'<!DOCTYPE nta [<!ENTITY a SYSTEM "file:///etc/passwd">]><nta><system>&a;</system></nta>'
    assert problem(stolen) == "m.xml: entities are not read"


def test_nesting_is_limited() -> None:
    deep = "(" * 5000 + "1" + ")" * 5000
    assert "nested more than 50 deep" in problem(model("clock x;", labels=guard(f"x &lt; {deep}")))
    assert "more than 50 operators in a row" in problem(
        model("clock x;", labels=guard("x &lt; 0" + "+1" * 5000))
    )
    assert "too deep" in problem(b"<nta>" * 50)


def test_a_long_conjunction_is_read() -> None:
    found = read(model("clock x;", labels=guard(" &amp;&amp; ".join(["x &lt; 9"] * 5000))))
    assert len(found.network.automata[0].edges[0].guard) == 5000


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("A[] P.A", "only 'E<> ...' and 'inf{...}: clock' are read"),
        ("E<> P.C", "there is no P.C"),
        ("E<> not P.A", "'not' is not read in a query"),
        ("E<> n", "n is not declared"),
        ("inf{P.A}: k", "inf{...}: is asked for the least value of a clock"),
        ("E<> deadlock", "deadlock is not declared"),
        ("E<> P.A P.A", "'P' was not expected here"),
    ],
)
def test_queries_that_are_not_read(query: str, message: str) -> None:
    found = read(model("clock x; int k;"))
    with pytest.raises(ModelError) as caught:
        read_query(query, found)
    assert str(caught.value) == f"m.xml:1: query {query}: {message}"


def test_a_query_becomes_its_cases() -> None:
    found = read(model("clock x; int k;", local="clock z[2];"))
    asked = read_query("E<> (P.A || P.b) && (x >= 2 or k == 1) && P.z[1] < 3", found)
    cases = [(dict(target.locations), len(target.guard), len(target.tests)) for target in asked.targets]
    assert cases == [({"P": "A"}, 2, 0), ({"P": "A"}, 1, 1), ({"P": "b"}, 2, 0), ({"P": "b"}, 1, 1)]
    assert read_query("E<> P.A && P.b", found).targets == ()
