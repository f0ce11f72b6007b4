"""The command that searches UPPAAL models."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from mitlplan.cli import app

LAMP = """<nta>
<declaration>clock x, y; chan press;</declaration>
<template><name>Lamp</name>
<location id="a"><name>off</name></location><location id="b"><name>low</name></location>
<location id="c"><name>bright</name></location><init ref="a"/>
<transition><source ref="a"/><target ref="b"/><label kind="synchronisation">press?</label>
<label kind="assignment">x = 0</label></transition>
<transition><source ref="b"/><target ref="c"/><label kind="guard">x &lt; 5</label>
<label kind="synchronisation">press?</label></transition>
</template>
<template><name>User</name>
<location id="u"><name>idle</name></location><init ref="u"/>
<transition><source ref="u"/><target ref="u"/><label kind="guard">y &gt; 2</label>
<label kind="synchronisation">press!</label><label kind="assignment">y = 0</label></transition>
</template>
<system>system Lamp, User;</system>
<queries><query><formula>E&lt;&gt; Lamp.bright</formula></query></queries>
</nta>"""

# The stopwatch w runs in `work` only; 3 units of work with rests of at least 1 after at most 2 take 4.
WORKER = """<nta>
<declaration>clock w, r;</declaration>
<template><name>Worker</name>
<location id="a"><name>work</name><label kind="invariant">r &lt;= 2</label></location>
<location id="b"><name>rest</name><label kind="invariant">w' == 0</label></location>
<location id="c"><name>done</name></location><init ref="a"/>
<transition><source ref="a"/><target ref="b"/><label kind="assignment">r = 0</label></transition>
<transition><source ref="b"/><target ref="a"/><label kind="guard">r &gt;= 1</label>
<label kind="assignment">r = 0</label></transition>
<transition><source ref="a"/><target ref="c"/><label kind="guard">w == 3</label></transition>
</template>
<system>system Worker;</system>
<queries><query><formula>E&lt;&gt; Worker.done</formula></query></queries>
</nta>"""

# Both clocks stand still in turn; in fact w and v add up to the time t, but zones forget that.
BOTH = """<nta>
<declaration>clock w, v, t;</declaration>
<template><name>P</name>
<location id="a"><name>one</name><label kind="invariant">v' == 0</label></location>
<location id="b"><name>other</name><label kind="invariant">w' == 0</label></location>
<location id="c"><name>done</name></location><init ref="a"/>
<transition><source ref="a"/><target ref="b"/></transition>
<transition><source ref="b"/><target ref="c"/>
<label kind="guard">w &lt;= 1 &amp;&amp; v &lt;= 1 &amp;&amp; t &gt;= BOUND</label></transition>
</template>
<system>system P;</system>
<queries><query><formula>E&lt;&gt; P.done</formula></query></queries>
</nta>"""


def reach(folder: Path, model: str, *options: str) -> Result:
    file = folder / "model.xml"
    file.write_text(model)
    return CliRunner().invoke(app, ["reach", str(file), *options])


def answer(result: Result) -> dict[str, object]:
    document = json.loads(result.stdout)
    assert isinstance(document, dict)
    return document


def test_the_fastest_trace_with_its_infimum(tmp_path: Path) -> None:
    result = reach(tmp_path, LAMP, "--format", "json")
    found = answer(result)
    assert result.exit_code == 0
    assert (found["status"], found["time"], found["bound"], found["attained"]) == ("reached", "4", "4", False)
    trace = found["trace"]
    assert isinstance(trace, list)
    assert [stop["locations"]["Lamp"] for stop in trace] == ["off", "low", "bright"]
    assert [len(stop["edges"]) for stop in trace] == [2, 2, 0]
    assert trace[0]["edges"][0]["synchronisation"] == "press!"


def test_the_text_tells_every_move_and_its_time(tmp_path: Path) -> None:
    lines = reach(tmp_path, LAMP).stdout.splitlines()
    assert lines[0].startswith("reached at any time after 4; this one at ")
    assert "Lamp.off User.idle" in lines[1]
    assert "User: idle -> idle press! [y > 2; y = 0]; Lamp: off -> low press? [x = 0]" in lines[2]
    assert lines[-1].endswith("reached")


def test_what_cannot_be_reached(tmp_path: Path) -> None:
    result = reach(tmp_path, LAMP.replace("x &lt; 5", "x &lt; 2"), "--format", "json")
    assert (result.exit_code, answer(result)["status"], answer(result)["trace"]) == (1, "unreachable", None)
    assert reach(tmp_path, LAMP.replace("x &lt; 5", "x &lt;= 2")).stdout == "unreachable\n"


def test_another_query_with_bounds_on_clocks(tmp_path: Path) -> None:
    result = reach(tmp_path, LAMP, "--query", "E<> Lamp.low and x >= 7", "--format", "json")
    found = answer(result)
    assert (found["time"], found["attained"]) == ("9", False)
    assert reach(tmp_path, LAMP, "--query", "E<> Lamp.low and y >= 7 and x < 7").exit_code == 1


def test_a_stopwatch_that_is_read(tmp_path: Path) -> None:
    """Zones over-approximate here; the times are exact all the same."""
    found = answer(reach(tmp_path, WORKER, "--format", "json"))
    assert (found["status"], found["time"]) == ("reached", "4")


@pytest.mark.parametrize(("bound", "status", "code"), [("2", "reached", 0), ("3", "unknown", 3)])
def test_a_spurious_trace_is_never_an_answer(bound: str, status: str, code: int, tmp_path: Path) -> None:
    result = reach(tmp_path, BOTH.replace("BOUND", bound), "--format", "json")
    assert (result.exit_code, answer(result)["status"]) == (code, status)
    if status == "unknown":
        assert "stopped clocks" in str(answer(result)["reason"])


def test_a_time_limit(tmp_path: Path) -> None:
    """Counting to millions, one by one, takes longer than a tenth of a second."""
    loop = '<transition><source ref="u"/><target ref="u"/><label kind="assignment">%s++</label></transition>'
    counting = LAMP.replace("clock x, y;", "clock x, y; int n; int k;").replace(
        "y = 0</label></transition>", f"y = 0</label></transition>{loop % 'n'}{loop % 'k'}"
    )
    result = reach(tmp_path, counting, "--query", "E<> n == 9 && n == 8", "--time-limit", "0.1")
    assert result.exit_code == 3
    assert result.stdout.startswith("limit: the time limit of 0.1 s was reached")


@pytest.mark.parametrize(
    ("model", "options", "sentence"),
    [
        (LAMP.replace("<query><formula>E&lt;&gt; Lamp.bright</formula></query>", ""), (), "no query"),
        (LAMP, ("--query", "A[] Lamp.off"), "only 'E<> ...'"),
        (LAMP, ("--query", "E<> Lamp.broken"), "broken"),
        (LAMP, ("--query", "inf{Lamp.bright}: x"), "inf is told of clocks that run from the start"),
        (LAMP.replace("clock x, y;", "clock x, y; hybrid clock h;"), (), "hybrid"),
        ("no xml", (), "model.xml"),
    ],
)
def test_bad_input_is_one_sentence(
    model: str, options: tuple[str, ...], sentence: str, tmp_path: Path
) -> None:
    result = reach(tmp_path, model, *options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["reach", str(tmp_path / "none.xml")])
    assert result.exit_code == 2
    assert "none.xml: cannot be read: No such file or directory" in result.stderr
