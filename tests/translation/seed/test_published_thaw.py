"""Without stopped clocks the published models have the same fastest runs."""

from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan import paper
from mitlplan.formats.tchecker import write_tchecker
from mitlplan.translation.seed.published_network import published_model
from mitlplan.translation.seed.published_thaw import without_stopped_clocks
from mitlplan.translation.seed.published_transducers import Flavour
from tests.formats.tck import read_tck
from tests.oracles.published_reach import reach
from tests.translation.seed.faults import line, model
from tests.translation.seed.paper import ring

LATEST = Fraction(9)


@pytest.mark.parametrize("flavour", Flavour)
@pytest.mark.parametrize(
    "text", [*list(paper.MISSIONS.values())[:3], "F[2,4] A", "F[1,3] B", "F[0,2] A | F[0,2] B"]
)
def test_the_fastest_run_is_the_same(text: str, flavour: Flavour) -> None:
    stopping = published_model(paper.parse(text), ring(), flavour=flavour)
    thawed = without_stopped_clocks(stopping)
    expected = reach(stopping.network, stopping.query, latest=LATEST)
    found = reach(thawed.network, thawed.query, latest=LATEST)
    assert (found and found.time) == (expected and expected.time)
    assert len(thawed.cells) == len(thawed.layers) == len(thawed.network.automata[0].locations)
    assert not any(at.stopped for each in thawed.network.automata for at in each.locations)


def test_a_deadline_is_void_as_before() -> None:
    thawed = without_stopped_clocks(model("G F[0,2] A", line("", "B", "", "A")))
    found = reach(thawed.network, thawed.query, latest=LATEST)
    assert found is not None
    assert found.time == 4


def test_an_untimed_model_stays_as_it_is() -> None:
    untimed = paper.model("phi1")
    assert without_stopped_clocks(untimed) is untimed


def test_tchecker_can_have_it() -> None:
    thawed = without_stopped_clocks(paper.model("phi2"))
    network, query = read_tck(write_tchecker(thawed.network, thawed.query))
    found = reach(network, query, latest=LATEST)
    assert found is not None
    assert found.time == 2
