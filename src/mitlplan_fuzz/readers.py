"""Every reader of files and texts, fed with what nobody wrote: ``mitlplan-fuzz --readers``.

Atheris (libFuzzer for Python) changes inputs so as to reach ever more of the code, from a few sound ones and
the words of each language. Whatever a reader is given, it may answer, or refuse with one of the errors of
:mod:`mitlplan.errors`; any other exception, too much memory, or ten seconds without an answer is a finding.
What can be written again must then read as the same thing.

Each reader runs in a process of its own, because libFuzzer ends the process that it runs in. Of inputs that
fail in the same line one is kept, in ``fuzz-findings/READER/``, and the fuzzing goes on; to see one again:
``python -m mitlplan_fuzz.readers READER FILE``.
"""

from __future__ import annotations

import gc
import importlib.util
import re
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from mitlplan.errors import MitlplanError

if TYPE_CHECKING:
    from mitlplan.formats.uppaal_read import UppaalModel

LONGEST_INPUT = 4096
MEGABYTES = 2048
SECONDS_FOR_ONE = 10
WATCHED = ("mitlplan.", "ruamel.yaml.", "lark.")
FINDINGS = Path("fuzz-findings")

NO_ATHERIS = (
    "the readers are fuzzed with atheris, which is not installed here: "
    "pip install atheris (it exists for Linux and CPython 3.11 to 3.13)"
)


@dataclass(frozen=True)
class Target:
    """A reader.

    Parameters
    ----------
    feed
        Reads once; raises one of the documented errors, or something is wrong.
    samples
        Sound inputs to begin with.
    words
        What the language is made of, apart by spaces.
    """

    feed: Callable[[bytes], object]
    samples: Callable[[], Iterable[str]]
    words: str


@dataclass(frozen=True)
class ReaderReport:
    """What came of feeding one reader."""

    name: str
    executions: int
    findings: tuple[Path, ...]
    message: str


# -------------------------------------------------------------------------------------------- each reader


def _formula(data: bytes) -> None:
    from mitlplan.logic.parse import parse
    from mitlplan.logic.show import show

    formula = parse(_text(data))
    if parse(show(formula)) != formula:
        raise AssertionError(f"shown as {show(formula)}, which reads as another formula")


def _mission(data: bytes) -> None:
    from mitlplan.mission import read

    read(_file("mission.yaml", data))


def _mission_json(data: bytes) -> None:
    from mitlplan.mission import read

    read(_file("mission.json", data))


def _map(data: bytes) -> None:
    from mitlplan.workspace import movingai

    movingai(_file("fuzzed.map", data))


def _plan(data: bytes) -> None:
    from mitlplan.formats.plan_json import plan_from_mapping, plan_to_mapping, read_plan

    outcome = read_plan(_file("plan.json", data))
    if plan_from_mapping(plan_to_mapping(outcome)) != outcome:
        raise AssertionError("the plan is another one when it is written and read again")


def _uppaal(data: bytes) -> None:
    from mitlplan.formats.uppaal_query import read_query
    from mitlplan.formats.uppaal_read import read_uppaal

    model = read_uppaal(data, file="fuzzed.xml")
    for query in model.queries:
        with suppress(MitlplanError):
            read_query(query, model)


def _uppaal_texts(data: bytes) -> None:
    """The texts inside a model whose XML is sound, an empty line between them."""
    texts = re.sub(r"[^\x20-\x7e\n]", "", _text(data)).split("\n\n")
    _uppaal(_model(dict(zip(_TEXTS, texts, strict=False))))


def _query(data: bytes) -> None:
    from mitlplan.formats.uppaal_query import read_query

    read_query(_text(data), _small_model())


def _verifyta(data: bytes) -> None:
    from mitlplan.formats.verifyta import read_moves, read_verdict

    text = _text(data)
    with suppress(MitlplanError):
        read_verdict(text)
    read_moves(text, _small_model().network)


def _text(data: bytes) -> str:
    return data.decode("utf-8", "replace")


@cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="mitlplan-fuzz"))


def _file(name: str, data: bytes) -> Path:
    file = _folder() / name
    file.write_bytes(data)
    return file


# ------------------------------------------------------------------------------------------- sound inputs

_TEXTS = {
    "declaration": "const int N = 3; clock x, y[2]; chan a, c[N]; broadcast chan b; int[0,5] i = 1; "
    "typedef int[0,1] bit;",
    "local": "clock z; bool done;",
    "parameter": "const int[0,1] k",
    "invariant": "x <= 7 && y[1]' == 0",
    "guard": "x >= 2 && i < N",
    "synchronisation": "a!",
    "assignment": "x = 0, i++, done := 1",
    "system": "Q = P(1); system Q;",
    "query": "E<> Q.B and x > 3",
}

_MODEL = """<?xml version="1.0" encoding="utf-8"?>
<nta><declaration>$declaration</declaration>
<template><name>P</name><parameter>$parameter</parameter><declaration>$local</declaration>
<location id="id0"><name>A</name><label kind="invariant">$invariant</label></location>
<location id="id1"><name>B</name><urgent/></location><location id="id2"><committed/></location>
<init ref="id0"/>
<transition><source ref="id0"/><target ref="id1"/><label kind="guard">$guard</label>
<label kind="synchronisation">$synchronisation</label>
<label kind="assignment">$assignment</label></transition>
<transition><source ref="id1"/><target ref="id2"/></transition></template>
<system>$system</system><queries><query><formula>$query</formula></query></queries></nta>
"""

_TRACE = """Verifying property 1 at line 1
 -- Property is satisfied.
State:
( Q.A )
Delay: 2
Transitions:
  Q.A->Q.B { x >= 2 && i < 3, a!, x := 0, i := i + 1 }

Transition: Q.B -> Q.id2 {1, tau, 1}
"""


def _model(texts: dict[str, str]) -> bytes:
    model = _MODEL
    for place, sound in _TEXTS.items():
        model = model.replace(f"${place}", escape(texts.get(place, sound)))
    return model.encode()


@cache
def _small_model() -> UppaalModel:
    from mitlplan.formats.uppaal_read import read_uppaal

    return read_uppaal(_model({}), file="small.xml")


def _formulas() -> Iterable[str]:
    from mitlplan.logic.show import show
    from mitlplan_fuzz.missions import random_mission

    return [show(random_mission(seed).formula) for seed in range(30)]


def _missions() -> Iterable[str]:
    from mitlplan_fuzz.missions import random_mission

    grid = """mitlplan: 1
workspace:
  grid: {rows: 4, columns: 3, neighbours: 8, move_time: [1/2, 2], diagonal_time: 1.5, waiting: true,
    blocked: [[3, 1], {rows: [0, 1], columns: [1, 1]}], propositions: [C],
    regions: {A: [[0, 0]], west: {rows: [0, 3], columns: [0, 0]}}}
robot: {start: r0c0}
spec: {order: "!A U west", visit: "F A"}
epsilon: 1/100
"""
    driven = """mitlplan: 1
workspace: {grid: {rows: 2, columns: 2, regions: {A: [[1, 1]]}}}
robot: {start: [0, 0], speed: 0.5, turn_rate: 1, radius: 0.2, headings: true, heading: east,
  rest_to_rest: cubic}
spec: F A
"""
    _file("sound.map", next(iter(_maps())).encode())
    on_map = """mitlplan: 1
workspace: {movingai: {file: sound.map, move_time: 1, regions: {A: [[0, 1]]}}}
robot: {start: r0c0}
spec: G F[0,2] A
"""
    return [grid, driven, on_map, *(random_mission(seed).yaml() for seed in range(10))]


def _missions_json() -> Iterable[str]:
    import json

    from ruamel.yaml import YAML

    reader = YAML(typ="safe", pure=True)
    return [json.dumps(reader.load(text), indent=1) for text in _missions()]


def _maps() -> Iterable[str]:
    return [
        "type octile\nheight 3\nwidth 4\nmap\n.G@O\nTSW.\n....\n",
        "type octile\r\nheight 1\r\nwidth 1\r\nmap\r\n.\r\n",
    ]


def _plans() -> Iterable[str]:
    from mitlplan.formats.plan_json import plan_to_json
    from mitlplan.planner import plan
    from mitlplan_fuzz.comparison import mission_of
    from mitlplan_fuzz.missions import random_mission

    return [plan_to_json(plan(mission_of(random_mission(seed)), time_limit=2)) for seed in range(15)]


TARGETS = {
    "formula": Target(
        _formula,
        _formulas,
        "F G U R W X V F[0,2] G_[1,3] U(0,5] R[1/2,inf) <>_[0,2] []_[2,7/2) & | -> <-> ! ~ not and or "
        "true false inf ( ) [ ] , . _ / 1e9 0.5 999999999999999999 ¬ ∧ ∨ → ↔ ◇ □ ○",
    ),
    "mission": Target(
        _mission,
        _missions,
        "mitlplan workspace graph cells moves from to time both waiting robot start spec horizon "
        "until epsilon grid rows columns move_time blocked regions neighbours diagonal_time "
        "propositions movingai file speed turn_rate radius headings heading acceleration "
        "turn_acceleration rest_to_rest infinite finite standard closed true false null &a *a !!int "
        "<<: --- ... %YAML .nan .inf 1e400 0x10 0o7 1_000 [ ] { } : - ? | > ' \" # \\0 \\x00",
    ),
    "mission-json": Target(
        _mission_json,
        _missions_json,
        '"mitlplan" "workspace" "graph" "cells" "moves" "from" "to" "time" "both" "waiting" "robot" '
        '"start" "spec" "grid" "rows" "columns" "move_time" "blocked" "regions" "movingai" "file" NaN '
        'Infinity -Infinity 1e400 1e999999999 null true false \\u0000 \\ud800 [ ] { } : , "',
    ),
    "map": Target(_map, _maps, "type octile height width map . G @ O T S W 1000000000"),
    "plan": Target(
        _plan,
        _plans,
        '"mitlplan" "status" "plan" "infeasible" "limit" "makespan" "bound" "attained" "epsilon" '
        '"steps" "cell" "enter" "leave" "holds" "slack" "loop" "start" "period" "reason" "conflict" '
        '"7/2" NaN 1e400 null true',
    ),
    "uppaal": Target(
        _uppaal,
        lambda: [_model({}).decode()],
        "<nta> <declaration> <template> <name> <parameter> <location <label kind= <init ref= "
        "<transition> <source <target <system> <queries> <!DOCTYPE <!ENTITY SYSTEM PUBLIC <![CDATA[ "
        ']]> &amp; &#0; &#x41; encoding="utf-16" xmlns: <?xml ?> <branchpoint <urgent/> <committed/>',
    ),
    "uppaal-texts": Target(
        _uppaal_texts,
        lambda: ["\n\n".join(_TEXTS.values())],
        "clock chan broadcast urgent int bool const typedef system P Q x y z N i a b c k bit [0,5] [ "
        "] ( ) { } ; , . = == != <= >= < > + - * / % ! ? && || and or not ' := ++ -- += -= *= // /* "
        "*/ true false 999999999 E<> inf",
    ),
    "query": Target(
        _query,
        lambda: [_TEXTS["query"], "E<> (Q.A || Q.id2) && i == 2 && x < 3", "inf{Q.B && y[0] > 1}: x"],
        "E<> inf{ }: Q.A Q.B Q.id2 Q.z Q.done x y[0] y[1] i N and or not && || ! <= >= == != < > ( ) "
        "[ ] - + 3",
    ),
    "verifyta": Target(
        _verifyta,
        lambda: [_TRACE],
        "Property Formula is NOT MAY be satisfied State: Transitions: Transition Delay: Q.A->Q.B "
        "Q.B->Q.id2 { } tau a! , x >= 2 i < 3 := +",
    ),
}


# ------------------------------------------------------------------------------------------------- running


def atheris_is_there() -> bool:
    """Whether readers can be fuzzed here."""
    return importlib.util.find_spec("atheris") is not None


def fuzz_reader(name: str, seconds: int, seed: int, say: Callable[[str], None]) -> ReaderReport:
    """Feed one reader for so long, in another process.

    Parameters
    ----------
    name
        A key of :data:`TARGETS`.
    seconds
        When to stop.
    seed
        Of libFuzzer; other seeds, other inputs.
    say
        Told how far it has got.
    """
    target = TARGETS[name]
    place = FINDINGS / name
    place.mkdir(parents=True, exist_ok=True)
    before = set(place.iterdir())
    executions = 0
    end: list[str] = []
    with tempfile.TemporaryDirectory(prefix="mitlplan-fuzz") as folder:
        corpus, words = Path(folder, "corpus"), Path(folder, "words")
        corpus.mkdir()
        for number, sample in enumerate(target.samples()):
            (corpus / str(number)).write_text(sample, encoding="utf-8")
        words.write_text("".join(f'"{_quoted(word)}"\n' for word in target.words.split()), encoding="utf-8")
        arguments = [
            f"-max_total_time={seconds}",
            f"-seed={seed}",
            f"-max_len={LONGEST_INPUT}",
            "-len_control=0",
            f"-timeout={SECONDS_FOR_ONE}",
            f"-rss_limit_mb={MEGABYTES}",
            f"-dict={words}",
            f"-artifact_prefix={place}/",
            "-print_final_stats=1",
            str(corpus),
        ]
        with subprocess.Popen(  # noqa: S603  (our own module)
            [sys.executable, "-m", "mitlplan_fuzz.readers", name, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        ) as process:
            assert process.stdout is not None
            for line in process.stdout:
                if found := re.match(r"(?:#|stat::number_of_executed_units: *)(\d+)", line):
                    executions = max(executions, int(found[1]))
                    say(f"{name}: {executions} inputs, {len(set(place.iterdir()) - before)} findings")
                end = [*end[-5:], line.rstrip()]
    message = "" if process.returncode == 0 else "\n".join(end)
    return ReaderReport(name, executions, tuple(sorted(set(place.iterdir()) - before)), message)


def _quoted(word: str) -> str:
    """A word in the spelling of libFuzzer's dictionaries."""
    plain = set(range(33, 127)) - set(b'"\\')
    return "".join(chr(byte) if byte in plain else f"\\x{byte:02x}" for byte in word.encode())


def feed_once(name: str, data: bytes) -> None:
    """Feed a reader once; of what should not have come out, one input a place is kept."""
    try:
        TARGETS[name].feed(data)
    except MitlplanError:
        pass
    except Exception as error:  # noqa: BLE001  (whatever it is, it is a finding)
        frame = traceback.extract_tb(error.__traceback__)[-1]
        file = FINDINGS / name / f"{type(error).__name__}-{Path(frame.filename).stem}-{frame.lineno}"
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)


def main() -> None:
    """Feed the reader named first, with libFuzzer's arguments after it; or show what a file does to it."""
    name, *rest = sys.argv[1:]
    if len(rest) == 1 and Path(rest[0]).is_file():
        TARGETS[name].feed(Path(rest[0]).read_bytes())
        return
    import atheris

    warnings.simplefilter("error")
    # Every module is there once the sound inputs have been read, and its functions can be watched.
    for sample in TARGETS[name].samples():
        TARGETS[name].feed(sample.encode())
    for function in [each for each in gc.get_objects() if isinstance(each, FunctionType)]:
        if (function.__module__ or "").startswith(WATCHED):
            atheris.instrument_func(function)
    atheris.Setup([sys.argv[0], *rest], lambda data: feed_once(name, data))
    atheris.Fuzz()


if __name__ == "__main__":
    main()
