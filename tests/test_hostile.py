# ruff: noqa: E501  (tables of cases)
"""Files that were made to break their reader: one sentence, exit code 2, and memory that stays bounded.

The real program reads them in a process that may take a gibibyte of addresses and no more, its
imports among them; what is large is made on the fly. Fuzzing finds what nobody thought of (mitlplan-fuzz
--readers); here is what attackers of other readers did think of.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

GIBIBYTE = 2**30
HUNDRED_MEGABYTES = 100 * 10**6
LONGEST_ANSWER = 1200

UNDER_A_LIMIT = """
import contextlib, io, json, resource, sys
resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]), resource.RLIM_INFINITY))
from mitlplan.cli import main
for arguments in json.load(sys.stdin):
    sys.argv = ["mitlplan", *arguments]
    out, err, code = io.StringIO(), io.StringIO(), "none"
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as end:
            code = end.code
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""

Content = Callable[[], bytes]

MISSION = """mitlplan: 1
workspace: {grid: {rows: 2, columns: 2, move_time: 1, regions: {A: [[1, 1]]}}}
robot: {start: r0c0}
spec: F A
"""


def answers(folder: Path, commands: Sequence[Sequence[str]]) -> list[tuple[int, str, str]]:
    """Exit code, stdout and stderr of the program for each list of arguments."""
    # The sanitizers reserve more addresses than there is memory.
    most = resource.RLIM_INFINITY if "MITLPLAN_NATIVE" in os.environ else GIBIBYTE
    run = subprocess.run(  # noqa: S603  (our own program)
        [sys.executable, "-c", UNDER_A_LIMIT, str(most)],
        cwd=folder,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        input=json.dumps(commands),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, run
    return [tuple(json.loads(line)) for line in run.stdout.splitlines()]


def objections(
    folder: Path, cases: Mapping[str, tuple[Sequence[str], str]]
) -> dict[str, tuple[int, str, str]]:
    """What was not refused as it should be; of each case, the arguments and what the sentence must say."""
    found = {}
    commands = [list(arguments) for arguments, _ in cases.values()]
    for (case, (_, told)), answer in zip(cases.items(), answers(folder, commands), strict=True):
        code, out, said = answer
        well = (
            (code, out) == (2, "") and told in said and len(said) < LONGEST_ANSWER and "Traceback" not in said
        )
        if not well:
            found[case] = (code, out[:LONGEST_ANSWER], said[:LONGEST_ANSWER])
    return found


def changed(old: str, new: str) -> Content:
    """The mission with something else in one place."""
    text = MISSION.replace(old, new)
    assert text != MISSION
    return lambda: text.encode("utf-8", "surrogateescape")


def _laughs() -> bytes:
    names = "abcdefghij"
    rows = ["a: &a [lol, lol, lol, lol, lol, lol, lol, lol, lol]"]
    rows += [f"{two}: &{two} [{', '.join([f'*{one}'] * 9)}]" for one, two in pairwise(names)]
    return "\n".join(rows).encode()


def _repeated(before: str, what: bytes, size: int, after: str) -> Content:
    return lambda: before.encode() + what * (size // len(what)) + after.encode()


DEEP = 100_000

MISSIONS: dict[str, tuple[str, Content, str]] = {
    "alias bomb": ("m.yaml", _laughs, "anchors"),
    "merge keys": ("m.yaml", lambda: b"a: &a {b: 1}\n<<: *a\n", "anchors"),
    "python objects": ("m.yaml", lambda: b"a: !!python/object/apply:os.system [id]\n", "tag"),
    "deep yaml lists": ("m.yaml", lambda: b"[" * DEEP, "nested too deep"),
    "deep yaml blocks": ("m.yaml", lambda: b"- " * DEEP, "nested too deep"),
    "deep json lists": ("m.json", lambda: b"[" * DEEP, "nested too deep"),
    "deep json objects": ("m.json", lambda: b'{"a":' * DEEP, "nested too deep"),
    "a yaml line of 100 MB": ("m.yaml", _repeated("spec: ", b"x", HUNDRED_MEGABYTES, "\n"), "too large"),
    "a json line of 100 MB": ("m.json", _repeated('{"spec": "', b"x", HUNDRED_MEGABYTES, '"}'), "too large"),
    "a yaml line of 2 MB": ("m.yaml", _repeated("spec: ", b"x", 2 * 10**6, "\n"), "m.yaml"),
    "a json line of 30 MB": ("m.json", _repeated('{"spec": "', b"x", 30 * 10**6, '"}'), "m.json"),
    "many json values": ("m.json", _repeated("[", b"1,", 30 * 10**6, "1]"), "too much"),
    "a key of 30 MB": ("m.json", _repeated('{"', b"x", 30 * 10**6, '": 1}'), "m.json"),
    "an empty file": ("m.yaml", lambda: b"", "empty"),
    "no UTF-8": ("m.yaml", lambda: MISSION.encode() + b"# \xff\xfe\n", "UTF-8"),
    "no UTF-8 in JSON": ("m.json", lambda: b'{"mitlplan": "\xc3"}', "UTF-8"),
    "UTF-16": ("m.yaml", lambda: MISSION.encode("utf-16"), "UTF-8"),
    "NUL": ("m.yaml", lambda: b"a: \0\n", "U+0000"),
    "NUL in JSON": ("m.json", lambda: b'{"mitlplan\0": 1}', "m.json"),
    "escaped NUL": ("m.json", lambda: b'{"mitlplan\\u0000": 1}', "m.json"),
    "half a character": ("m.json", lambda: b'{"mitlplan": "\\ud800"}', "half of a character"),
    "1e999999999": ("m.yaml", changed("move_time: 1", "move_time: 1e999999999"), "move_time"),
    "1e400": ("m.yaml", changed("move_time: 1", "move_time: 1e400"), "out of range"),
    "1e-999999999": ("m.yaml", changed("move_time: 1", "move_time: 1e-999999999"), "move_time"),
    "NaN": ("m.yaml", changed("move_time: 1", "move_time: .nan"), "not a number"),
    "infinity": ("m.yaml", changed("move_time: 1", "move_time: .inf"), "not a number"),
    "NaN in JSON": ("m.json", lambda: b'{"mitlplan": NaN}', "mitlplan"),
    "a number of a million digits": ("m.yaml", changed("move_time: 1", "move_time: " + "9" * 10**6), "too long"),
    "a fraction by zero": ("m.yaml", changed("move_time: 1", "move_time: 1/0"), "divides by zero"),
    "a huge grid": ("m.yaml", changed("rows: 2, columns: 2", "rows: 999999999, columns: 999999999"), "cells"),
    "a grid of 1e999999999 rows": ("m.yaml", changed("rows: 2", "rows: 1e999999999"), "rows"),
    "a grid of 10**4000 rows": ("m.yaml", changed("rows: 2", "rows: 1" + "0" * 4000), "rows"),
    "a grid of -1 rows": ("m.yaml", changed("rows: 2", "rows: -1"), "rows"),
    "a huge region": ("m.yaml", changed("[[1, 1]]", "{rows: [0, 999999999], columns: [0, 999999999]}"), "A"),
    "a place far away": ("m.yaml", changed("[[1, 1]]", "[[999999999999999999999, 1]]"), "A"),
    "a start with a long name": ("m.yaml", changed("r0c0", "r" + "9" * 10**6 + "c0"), "robot.start"),
    "a long proposition": ("m.json", lambda: json.dumps({"mitlplan": 1, "workspace": {"grid": {"rows": 1, "columns": 1,
        "move_time": 1}}, "robot": {"start": "r0c0"}, "spec": "F " + "A" * 190_000}).encode(), "No cell carries"),
    "a map of itself": ("m.yaml", changed("grid: {rows: 2, columns: 2", "movingai: {file: m.yaml"), "m.yaml"),
    "a map that never ends": ("m.yaml", changed("grid: {rows: 2, columns: 2", "movingai: {file: /dev/zero"), "large"),
}  # fmt: skip


FORMULAS: dict[str, tuple[str, str]] = {
    "nothing": ("", "empty"),
    "open parentheses": ("(" * 100_000, "text ends"),
    "deep negations": ("!" * 100_000 + "A", "levels deep"),
    "deep operators": ("F " * 50_000 + "A", "levels deep"),
    "deep implications": ("A -> " * 30_000 + "A", "levels deep"),
    "too long": ("A & " * 60_000 + "A", "characters"),
    "1e999999999": ("F[0,1e999999999] A", "1e999999999"),
    "many digits": ("F[0," + "9" * 5000 + "] A", "digits"),
    "NaN": ("F[0,NaN] A", "NaN"),
    "nan": ("F[nan,1] A", "nan"),
    "minus": ("F[-1,1] A", "-"),
    "empty interval": ("F(1,1] A", "(1,1]"),
    "a fraction by zero": ("F[0,1/0] A", "0"),
    "a control character": ("A \x07 B", "U+0007"),
    "half a character": ("A \udcff", "A"),
}

MAP = "type octile\nheight 2\nwidth 2\nmap\n..\n..\n"

MAPS: dict[str, tuple[Content, str]] = {
    "empty": (lambda: b"", "no MovingAI map"),
    "a line of 100 MB": (_repeated("type octile\nheight 1\nwidth 1\nmap\n", b".", HUNDRED_MEGABYTES, "\n"), "large"),
    "100 MB of lines": (_repeated("", b"\n", HUNDRED_MEGABYTES, ""), "large"),
    "a word of 4 MB": (_repeated("", b"x", 4 * 10**6, ""), "no MovingAI map"),
    "a height of 1e999999999": (lambda: MAP.replace("height 2", "height 1e999999999").encode(), "height"),
    "a huge height": (lambda: MAP.replace("height 2", "height 9999999").encode(), "9999999"),
    "a height of many digits": (lambda: MAP.replace("height 2", "height " + "9" * 10**6).encode(), "height"),
    "a negative height": (lambda: MAP.replace("height 2", "height -2").encode(), "height"),
    "another script's digits": (lambda: MAP.replace("height 2", "height \u0662").encode(), "height"),
    "NUL": (lambda: MAP.replace("..\n..", "..\n.\0").encode(), "terrain"),
    "no UTF-8": (lambda: MAP.encode().replace(b"..\n..", b"..\n.\xff"), "terrain"),
    "no rows": (lambda: MAP.replace("height 2", "height 0").replace("..\n", "").encode(), "row"),
}  # fmt: skip

PLAN = """{"mitlplan": 1, "status": "plan", "makespan": "2", "bound": "2", "attained": true, "epsilon": null,
 "steps": [{"cell": "r0c0", "enter": "0", "leave": "1", "holds": [], "slack": "0"},
 {"cell": "r0c1", "enter": "1", "leave": "2", "holds": [], "slack": "0"},
 {"cell": "r1c1", "enter": "2", "leave": "2", "holds": ["A"], "slack": "0"}],
 "loop": null, "checked": true, "fault": null, "reason": null, "conflict": []}
"""


def in_plan(old: str, new: str) -> Content:
    """The plan with something else in one place."""
    assert old in PLAN
    return lambda: PLAN.replace(old, new, 1).encode()


PLANS: dict[str, tuple[Content, str]] = {
    "empty": (lambda: b"", "plan.json"),
    "deep": (lambda: b'{"steps":' * DEEP, "nested too deep"),
    "a line of 100 MB": (_repeated('{"status": "', b"x", HUNDRED_MEGABYTES, '"}'), "too large"),
    "a line of 30 MB": (_repeated('{"status": "', b"x", 30 * 10**6, '"}'), "plan.json"),
    "many values": (_repeated('{"steps": [', b"1,", 30 * 10**6, "1]}"), "too much"),
    "YAML": (lambda: b"mitlplan: 1\n", "JSON"),
    "NaN": (in_plan('"enter": "1"', '"enter": NaN'), "enter"),
    "infinity": (in_plan('"makespan": "2"', '"makespan": Infinity'), "makespan"),
    "1e999999999": (in_plan('"enter": "1"', '"enter": 1e999999999'), "enter"),
    "many digits": (in_plan('"enter": "1"', '"enter": ' + "9" * 10**6), "enter"),
    "a loop from nowhere": (in_plan('"loop": null', '"loop": {"start": 99999999999999999999, "period": "1"}'), "loop"),
    "NUL": (in_plan("r0c1", "r0\0c1"), "plan.json"),
    "no UTF-8": (lambda: PLAN.encode().replace(b"r0c1", b"\xff"), "UTF-8"),
    "half a character": (in_plan("r0c1", "\\udfff"), "half of a character"),
    "twice": (in_plan('"status": "plan"', '"status": "plan", "status": "plan"'), "twice"),
}  # fmt: skip

MODEL = """<?xml version="1.0" encoding="utf-8"?>
<nta><declaration>clock x; int[0,3] i;</declaration><template><name>P</name><location id="a"><name>A</name></location>
<init ref="a"/><transition><source ref="a"/><target ref="a"/><label kind="guard">x &gt;= 1</label></transition>
</template><system>Q = P(); system Q;</system><queries><query><formula>E&lt;&gt; Q.A</formula></query></queries></nta>
"""


def in_model(old: str, new: str) -> Content:
    """The model with something else in one place."""
    assert old in MODEL
    return lambda: MODEL.replace(old, new, 1).encode("utf-8", "surrogateescape")


def _xml_laughs() -> bytes:
    names = "abcdefghij"
    entities = ['<!ENTITY a "lol">']
    entities += [f'<!ENTITY {two} "{f"&{one};" * 10}">' for one, two in pairwise(names)]
    return f"<!DOCTYPE nta [{''.join(entities)}]><nta><system>&j;</system></nta>".encode()


MODELS: dict[str, tuple[Content, str]] = {
    "empty": (lambda: b"", "XML"),
    "billion laughs": (_xml_laughs, "entities are not read"),
    "quadratic blowup": (
        lambda: b'<!DOCTYPE nta [<!ENTITY a "' + b"a" * 10**5 + b'">]><nta>' + b"&a;" * 10**5 + b"</nta>",
        "entities are not read",
    ),
    "an external entity": (
        lambda: b'<!DOCTYPE nta [<!ENTITY a SYSTEM "file:///etc/passwd">]><nta><system>&a;</system></nta>',
        "entities are not read",
    ),
    "a parameter entity": (
        lambda: b'<!DOCTYPE nta [<!ENTITY % a SYSTEM "file:///etc/passwd"> %a;]><nta/>',
        "entities are not read",
    ),
    "deep": (lambda: b"<a>" * DEEP, "too deep"),
    "a line of 100 MB": (_repeated("<nta><system>", b"x", HUNDRED_MEGABYTES, "</system></nta>"), "MB"),
    "a line of 60 MB": (_repeated("<nta><system>", b"x ", 60 * 10**6, "</system></nta>"), "model.xml"),
    "an attribute of 60 MB": (_repeated('<nta a="', b"x", 60 * 10**6, '"/>'), "model.xml"),
    "deep expressions": (in_model("x &gt;= 1", "(" * DEEP), "deep"),
    "long sums": (in_model("x &gt;= 1", "i == 1" + " + 1" * DEEP), "in a row"),
    "a huge number": (in_model("x &gt;= 1", "x &gt;= " + "9" * 10**6), "too large"),
    "1e999999999": (in_model("x &gt;= 1", "x &gt;= 1e999999999"), "model.xml"),
    "a huge product": (in_model("x &gt;= 1", "x &gt;= " + "*".join(["999999999"] * 50)), "beyond"),
    "a huge array": (in_model("clock x;", "clock x, y[999999999];"), "model.xml"),
    "arrays of arrays": (in_model("clock x;", "clock x, y[9999][9999][9999];"), "model.xml"),
    "many processes": (in_model("<name>P</name>", "<name>P</name><parameter>int[0,999999999] k</parameter>"), "model.xml"),
    "NUL": (in_model("clock x;", "clock x;\0"), "XML"),
    "no UTF-8": (lambda: MODEL.encode().replace(b"clock x;", b"clock \xff;"), "XML"),
    "an encoding nobody has": (in_model("utf-8", "klingon"), "XML"),
    "UTF-7": (in_model("utf-8", "utf-7"), "XML"),
    "a comment without end": (in_model("clock x;", "clock x; /*"), "does not end"),
}  # fmt: skip


def written(folder: Path, content: bytes, name: str) -> str:
    """Write a file of this name in a folder of its own; where it is."""
    place = folder / str(len(list(folder.iterdir())))
    place.mkdir()
    (place / name).write_bytes(content)
    return str((place / name).relative_to(folder))


def test_missions(tmp_path: Path) -> None:
    cases = {
        case: (("plan", written(tmp_path, content(), name)), told)
        for case, (name, content, told) in MISSIONS.items()
    }
    assert objections(tmp_path, cases) == {}


def test_formulas(tmp_path: Path) -> None:
    cases = {case: (("satisfiable", formula), told) for case, (formula, told) in FORMULAS.items()}
    assert objections(tmp_path, cases) == {}


def test_maps(tmp_path: Path) -> None:
    cases = {}
    for case, (content, told) in MAPS.items():
        file = written(tmp_path, content(), "hostile.map")
        mission = changed("grid: {rows: 2, columns: 2", f"movingai: {{file: {tmp_path / file}")()
        cases[case] = ("plan", written(tmp_path, mission, "m.yaml")), told
    assert objections(tmp_path, cases) == {}


def test_plans(tmp_path: Path) -> None:
    mission = written(tmp_path, MISSION.encode(), "m.yaml")
    cases = {
        case: (("check", mission, written(tmp_path, content(), "plan.json")), told)
        for case, (content, told) in PLANS.items()
    }
    assert objections(tmp_path, cases) == {}


def test_models(tmp_path: Path) -> None:
    cases = {
        case: (("reach", written(tmp_path, content(), "model.xml")), told)
        for case, (content, told) in MODELS.items()
    }
    assert objections(tmp_path, cases) == {}


def test_files_larger_than_memory(tmp_path: Path) -> None:
    commands = {"m.yaml": "plan", "m.json": "plan", "model.xml": "reach"}
    for name in commands:
        with (tmp_path / name).open("wb") as file:
            file.truncate(100 * GIBIBYTE)
    cases = {name: ((command, name), "MB") for name, command in commands.items()}
    assert objections(tmp_path, cases) == {}


def test_what_the_files_were_made_from_is_sound(tmp_path: Path) -> None:
    """Otherwise all would be refused for one and the same reason."""
    (tmp_path / "m.yaml").write_text(MISSION, encoding="utf-8")
    (tmp_path / "on_map.yaml").write_bytes(
        changed("grid: {rows: 2, columns: 2", "movingai: {file: sound.map")()
    )
    (tmp_path / "sound.map").write_text(MAP, encoding="utf-8")
    (tmp_path / "plan.json").write_text(PLAN, encoding="utf-8")
    (tmp_path / "model.xml").write_text(MODEL, encoding="utf-8")
    parentheses = "(" * 50_000 + "F[0,1] A" + ")" * 50_000
    commands = [["plan", "m.yaml"], ["plan", "on_map.yaml"], ["check", "m.yaml", "plan.json"],
                ["reach", "model.xml"], ["satisfiable", parentheses]]  # fmt: skip
    assert [code for code, _, _ in answers(tmp_path, commands)] == [0] * 5
