from __future__ import annotations

import json
from fractions import Fraction

from mitlplan.formats.trajectory_json import trajectory_to_json, trajectory_to_mapping
from mitlplan.trajectory import follow
from mitlplan.workspace import grid
from tests.trajectory.strategies import plan_of

STEP = Fraction(1, 4)
ROUND_THE_SQUARE = follow(plan_of(["r0c0", "r0c1", "r1c1", "r1c0"], [Fraction(1)] * 3), grid(2, 2))


def test_the_text_holds_the_mapping() -> None:
    assert json.loads(trajectory_to_json(ROUND_THE_SQUARE, STEP)) == trajectory_to_mapping(
        ROUND_THE_SQUARE, STEP
    )


def test_what_is_in_it() -> None:
    found = trajectory_to_mapping(ROUND_THE_SQUARE, STEP)
    assert (found["end"], found["repeat_from"], found["step"]) == ("7/2", None, "1/4")
    assert found["cells"][1] == {"cell": "r0c1", "enter": "1", "leave": "2"}
    assert found["cells"][-1] == {"cell": "r1c0", "enter": "3", "leave": None}
    assert [motion["name"] for motion in found["motions"]] == [
        "straight way",
        "free turn",
        "free turn",
        "straight way",
    ]
    assert sum(motion["cost"] for motion in found["motions"]) == found["cost"]
    assert {len(column) for column in found["samples"].values()} == {15}


def test_a_loop() -> None:
    forever = follow(plan_of(["r0c0", "r0c1"], [Fraction(1)] * 2, loop=0), grid(1, 2))
    found = trajectory_to_mapping(forever, STEP)
    assert (found["repeat_from"], found["end"]) == ("1", "3")
    assert [cell["cell"] for cell in found["cells"]] == ["r0c0", "r0c1", "r0c0"]
