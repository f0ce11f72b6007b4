"""The command that writes models."""

from __future__ import annotations

import json
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from mitlplan.cli import app
from mitlplan.formats.uppaal_query import read_query
from mitlplan.formats.uppaal_read import read_uppaal
from tests.formats.tck import read_tck
from tests.formats.uppaal_structure import faults
from tests.oracles.published_reach import reach

EXAMPLES = Path(__file__).parents[1] / "examples"

PHI1 = """\
mitlplan: 1
workspace: {grid: {rows: 2, columns: 2, regions: {A: [[1, 0]], B: [[0, 1]]}}}
robot: {start: r0c0}
spec: "(!A U B) & F A"
"""


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    file = tmp_path / "phi1.yaml"
    file.write_text(PHI1)
    return file


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.parametrize("construction", ["compact", "seed", "published"])
def test_a_uppaal_model_of_each_construction(construction: str, mission: Path) -> None:
    result = run("translate", mission, "--construction", construction)
    assert (result.exit_code, result.stderr) == (0, "")
    assert faults(result.stdout) == []
    read = read_uppaal(result.stdout.encode())
    found = reach(read.network, read_query(read.queries[0], read), latest=Fraction(5))
    assert found is not None
    assert found.time == 3
    assert ("UNSOUND" in result.stdout) == (construction == "published")


@pytest.mark.parametrize(("bound", "reached"), [("3", True), ("5/2", False)])
def test_a_tchecker_model_with_a_bound(bound: str, reached: bool, mission: Path, tmp_path: Path) -> None:
    output = tmp_path / "phi1.tck"
    result = run("translate", mission, "--to", "tchecker", "--bound", bound, "-o", output)
    assert (result.exit_code, result.stdout) == (0, "")
    network, query = read_tck(output.read_text())
    assert [variable.name for variable in network.variables][-1] == "column"
    assert (reach(network, query, latest=Fraction(8)) is not None) == reached


@pytest.mark.timeout(300)
@pytest.mark.skipif(shutil.which("tck-reach") is None, reason="TChecker's tck-reach is not on the PATH")
@pytest.mark.parametrize("construction", ["compact", "seed"])
@pytest.mark.parametrize(
    ("example", "makespan"), [("paper/phi1", 3), ("paper/phi4", 3), ("warehouse", 154), ("rescue", 110)]
)
def test_tchecker_finds_a_plan_of_our_makespan_and_none_that_is_faster(
    example: str, makespan: int, construction: str, tmp_path: Path
) -> None:
    model = tmp_path / "model.tck"
    for bound, reached in ((makespan, "true"), (makespan - 1, "false")):
        options = ("--construction", construction, "--to", "tchecker", "--bound", bound, "-o", model)
        assert run("translate", EXAMPLES / f"{example}.yaml", *options).exit_code == 0
        said = subprocess.run(  # noqa: S603
            ["tck-reach", "-a", "covreach", "-l", "goal0", "-s", "bfs", str(model)],  # noqa: S607
            check=True,
            capture_output=True,
            text=True,
        )
        assert f"REACHABLE {reached}\n" in said.stdout


def test_json_and_dot(mission: Path) -> None:
    document = json.loads(run("translate", mission, "--to", "json", "--construction", "published").stdout)
    assert [automaton["name"] for automaton in document["automata"]] == ["sys"]
    assert len(document["automata"][0]["edges"]) == 26
    dot = run("translate", mission, "--to", "dot", "--construction", "published").stdout
    assert dot.startswith('digraph "sys" {')
    assert dot.count(" -> ") == 26


def test_the_published_model_is_written_for_tchecker_without_stopped_clocks(tmp_path: Path) -> None:
    file = tmp_path / "phi2.yaml"
    file.write_text(PHI1.replace("(!A U B) & F A", "G F[0,2] A"))
    result = run("translate", file, "--to", "tchecker", "--construction", "published")
    assert (result.exit_code, result.stderr) == (0, "")
    network, query = read_tck(result.stdout)
    found = reach(network, query, latest=Fraction(5))
    assert found is not None
    assert found.time == 2


def test_a_graph_without_positions_is_written_for_tchecker_too(tmp_path: Path) -> None:
    file = tmp_path / "ring.yaml"
    file.write_text(
        "mitlplan: 1\nworkspace:\n  graph:\n    cells: {a: [], b: [A]}\n"
        "    moves: [{from: a, to: b, time: '3/2'}]\nrobot: {start: a}\nspec: F A\n"
    )
    network, query = read_tck(run("translate", file, "--to", "tchecker").stdout)
    found = reach(network, query, latest=Fraction(8))
    assert found is not None
    assert found.time == 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--construction", "published", "--to", "tchecker"), ""),
        (("--bound", "soon"), "'soon' is not a number"),
        (("--to", "xml"), "'xml' is not one of"),
    ],
)
def test_options_are_checked(arguments: tuple[str, ...], message: str, mission: Path) -> None:
    result = run("translate", mission, *arguments)
    assert (result.exit_code == 0) == (message == "")
    assert message in result.output


def test_what_cannot_be_expressed_is_a_sentence(tmp_path: Path) -> None:
    file = tmp_path / "open.yaml"
    file.write_text(PHI1.replace("(!A U B) & F A", "F[0,2) A"))
    result = run("translate", file, "--construction", "seed")
    assert result.exit_code == 2
    assert result.stderr.startswith("mitlplan: the seed construction has no transducer for F[0,2) A")


def test_a_warning_goes_to_stderr(tmp_path: Path) -> None:
    file = tmp_path / "closed.yaml"
    file.write_text(PHI1.replace("(!A U B) & F A", "!A U A"))
    result = run("translate", file, "--until", "closed")
    assert "warning" in result.stderr
    assert "warning" not in result.stdout
