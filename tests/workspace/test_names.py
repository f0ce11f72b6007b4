from __future__ import annotations

import numpy as np
import pytest

from mitlplan.workspace import grid
from mitlplan.workspace.names import GridNames, ListedNames, advise


@pytest.fixture
def names() -> GridNames:
    """A grid of 3 rows and 4 columns without its diagonal."""
    place = np.array([place for place in range(12) if place // 4 != place % 4])
    return GridNames((3, 4), place)


def test_every_name_finds_its_index(names: GridNames) -> None:
    assert len(names) == 9
    assert [names.find(name) for name in names] == list(range(9))
    assert names[-1] == "r2c3"
    assert list(names[1:3]) == ["r0c2", "r0c3"]
    assert "r0c2" in names
    assert names.index("r1c0") == 3


@pytest.mark.parametrize(
    "name",
    ["r0c0", "r3c0", "r0c4", "r00c1", "r0c01", "r-1c0", "r0c1 ", "R0C1", "r1c", "", "r1c99999999999", "r٠c١"],
)
def test_what_is_no_name_of_a_free_cell(names: GridNames, name: str) -> None:
    assert names.find(name) is None


def test_advice_on_a_grid(names: GridNames) -> None:
    assert names.advise("r1c1") == "that cell is blocked"
    assert names.advise("dock") == "cells are r0c0 to r2c3, row first, counted from the top left"
    assert names.advise("r3c0") == "cells are r0c0 to r2c3, row first, counted from the top left"


def test_advice_on_a_list() -> None:
    names = ListedNames(["dock", "deck", "hall"])
    assert names.advise("dck") == "did you mean dock or deck?"
    assert names.advise("kitchen") == "the cells are dock, deck, hall"
    assert names[1:] == ("deck", "hall")
    assert advise("x", [], "propositions") == "there are no propositions"
    many = [f"cell{number}" for number in range(13)]
    assert advise("x", many, "cells") == f"the cells are {', '.join(many[:10])} and 3 more"


def test_names_cost_nothing_until_they_are_asked_for() -> None:
    names = grid(1000, 1000).names
    assert names[123_456] == "r123c456"
    assert not any(isinstance(value, (list, tuple)) and len(value) > 2 for value in vars(names).values())
