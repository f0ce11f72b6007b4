"""The network of a mission, by any construction."""

from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan import paper
from mitlplan.mission import mission_for
from mitlplan.models import Construction, model_of_mission
from tests.oracles.published_reach import reach


@pytest.mark.parametrize("construction", ["compact", "seed"])
@pytest.mark.parametrize(
    ("spec", "least"),
    [
        (paper.MISSIONS["phi1"], 3),
        (paper.MISSIONS["phi3"], 3),
        ({"first": "F[0,4] A", "then": "F[0,4] B"}, 3),
        ("F[0,1] A & F[0,1] B", None),
    ],
)
def test_the_least_makespan_is_that_of_the_plan(
    construction: Construction, spec: str | dict[str, str], least: int | None
) -> None:
    model = model_of_mission(mission_for(paper.workspace(), spec, start="pos0"), construction)
    found = reach(model.network, model.query, latest=Fraction(5))
    assert (found and found.time) == least
    assert len(model.cells) == len(model.layers) == len(model.network.automata[0].locations)
    assert construction in model.notes[0]


def test_the_horizon_is_kept() -> None:
    ends = mission_for(paper.workspace(), "G !B & F A", start="pos0", horizon="finite")
    for construction in ("compact", "seed"):
        model = model_of_mission(ends, construction)
        found = reach(model.network, model.query, latest=Fraction(5))
        assert found is not None
        assert found.time == 1


def test_the_published_model_is_marked() -> None:
    model = model_of_mission(mission_for(paper.workspace(), "F[0,2] A", start="pos1"), "published")
    assert any(note.startswith("UNSOUND") for note in model.notes)
    robot = model.network.automata[0]
    assert model.cells[robot.initial] == 1
