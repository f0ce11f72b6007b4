"""The command `draw` where it draws automata; maps and trajectories are drawn in tests/trajectory."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.test_cli_models import EXAMPLES, run

MISSION = EXAMPLES / "paper" / "phi1.yaml"


@pytest.mark.parametrize("suffix", ["svg", "dot"])
def test_automata_are_drawn(suffix: str, tmp_path: Path) -> None:
    pytest.importorskip("pygraphviz")
    output = tmp_path / f"automaton.{suffix}"
    assert run("draw", MISSION, "--automaton", "-o", output).exit_code == 0
    assert "loc6_b" in output.read_text()
    assert run("draw", "--figure", "fig4", "-o", output).exit_code == 0
    assert "p!q" in output.read_text()
    part = ("--construction", "seed", "--part", "watch0")
    assert run("draw", MISSION, "--automaton", *part, "-o", output).exit_code == 0
    assert "done" in output.read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "name a mission or a figure, and not both"),
        (("--figure", "fig3"), "there is no figure fig3; there are fig1, fig2, fig4"),
        ((MISSION, "--part", "sys9"), "there is no automaton sys9; there are sys"),
        (("--figure", "fig1", "-o", "fig1.png"), "an automaton is drawn as .svg or .dot"),
    ],
)
def test_what_cannot_be_drawn(arguments: tuple[str | Path, ...], message: str) -> None:
    result = run("draw", *arguments)
    assert result.exit_code == 2
    assert message in result.output
