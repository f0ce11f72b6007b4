from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from mitlplan.plan import Loop, Step
from mitlplan.workspace import Move, Workspace, graph, grid
from mitlplan.workspace.path import ending, follows


def stay(cell: str, enter: str | int, leave: str | int | None, *holds: str) -> Step:
    return Step(cell, Fraction(enter), None if leave is None else Fraction(leave), holds)


@pytest.fixture
def square() -> Workspace:
    """Four cells in a ring, one a time unit from the next; the way from d is slow or very slow."""
    moves = [
        Move("a", "b", 1),
        Move("b", "c", 1),
        Move("c", "d", [1, 2]),
        Move("d", "a", 3),
        Move("d", "a", [5, 6]),
        Move("c", "b", 0),
    ]
    return graph({"a": [], "b": ["B"], "c": [], "d": ["D", "E"], "end": []}, [*moves, Move("a", "end", 1)])


@pytest.fixture
def round_trip() -> list[Step]:
    return [
        stay("a", 0, 1),
        stay("b", 1, 2, "B"),
        stay("c", 2, "7/2"),
        stay("d", "7/2", "13/2", "E", "D"),
    ]


def test_a_good_path_and_each_way_to_go_on(square: Workspace, round_trip: list[Step]) -> None:
    assert follows(square, 0, round_trip) is None
    assert follows(square, 0, round_trip, Loop(0, Fraction(13, 2))) is None
    assert follows(square, 0, [*round_trip[:3], stay("d", "7/2", "7/2", "D", "E")]) is None
    assert follows(replace(square, waiting=True), 0, [stay("a", 0, None)], Loop(0, None)) is None


def test_a_loop_that_begins_later(square: Workspace) -> None:
    steps = [stay("a", 0, 1), stay("b", 1, 2, "B"), stay("c", 2, "9/4")]
    assert follows(square, 0, steps, Loop(1, Fraction(5, 4))) is None


def test_any_of_several_moves_will_do(square: Workspace) -> None:
    ring = [stay("d", 0, 3, "D", "E"), stay("a", 3, 4)]
    assert follows(square, 3, ring) is None
    assert follows(square, 3, [replace(ring[0], leave=Fraction(11, 2)), stay("a", "11/2", 6)]) is None


def test_waiting_lifts_the_upper_bound_and_not_the_lower() -> None:
    workspace = grid(1, 2, move_time=[1, 2], waiting=True)
    assert follows(workspace, 0, [stay("r0c0", 0, 50), stay("r0c1", 50, 50)]) is None
    assert (
        follows(workspace, 0, [stay("r0c0", 0, "1/2"), stay("r0c1", "1/2", "1/2")])
        == "steps[0] (r0c0): the move to r0c1 after a stay of 1/2 is not allowed; it takes at least 1"
    )


def test_a_stop_may_be_short_and_not_long(square: Workspace) -> None:
    assert follows(square, 2, [stay("c", 0, 100)]) is None  # any stay, before the way back to b
    assert follows(square, 0, [stay("a", 0, "1/2")]) is None
    assert (
        follows(square, 0, [stay("a", 0, 2)])
        == "steps[0] (a): the robot stays for 2, where the map allows no waiting beyond 1"
    )
    assert follows(square, 0, [stay("a", 0, 1), stay("end", 1, 1)]) is None
    assert (
        follows(square, 0, [stay("a", 0, 1), stay("end", 1, 2)])
        == "steps[1] (end): the robot stays for 1, where the map allows no waiting beyond 0"
    )


@pytest.mark.parametrize(
    ("steps", "loop", "fault"),
    [
        ([], None, "there is no step; a plan begins with a stay in the start cell"),
        ([stay("b", 0, 1, "B")], None, "steps[0] (b): the plan begins here, the robot in a"),
        ([stay("a", 1, 2)], None, "steps[0] (a): the plan begins at 1, not at 0"),
        ([stay("e", 0, 1)], None, "steps[0] (e): the plan begins here, the robot in a"),
        (
            [stay("a", 0, 1), stay("ende", 1, 1)],
            None,
            "steps[0] (a): no move leads from a to ende",
        ),
        (
            [stay("a", 0, 1), stay("b", 1, 2)],
            None,
            "steps[1] (b): the plan says that nothing holds there, the map B",
        ),
        (
            [stay("a", 0, 1, "B", "C"), stay("b", 1, 2, "B")],
            None,
            "steps[0] (a): the plan says that B, C holds there, the map nothing",
        ),
        ([stay("a", 0, 1), stay("c", 1, 2)], None, "steps[0] (a): no move leads from a to c"),
        (
            [stay("a", 0, 2), stay("b", 2, 2, "B")],
            None,
            "steps[0] (a): the move to b after a stay of 2 is not allowed; it takes exactly 1",
        ),
        (
            [stay("a", 0, 1), stay("b", 1, 2, "B"), stay("c", 2, 5), stay("d", 5, 5, "D", "E")],
            None,
            "steps[2] (c): the move to d after a stay of 3 is not allowed; it takes 1 to 2",
        ),
        (
            [
                stay("a", 0, 1),
                stay("b", 1, 2, "B"),
                stay("c", 2, 3),
                stay("d", 3, 7, "D", "E"),
                stay("a", 7, 8),
            ],
            None,
            "steps[3] (d): the move to a after a stay of 4 is not allowed; it takes exactly 3 or 5 to 6",
        ),
        (
            [stay("a", 0, 1), stay("b", "3/2", 2, "B")],
            None,
            "steps[0] (a): the robot leaves at 1, but enters b at 3/2",
        ),
        (
            [stay("a", 0, 0), stay("b", 0, 1, "B")],
            None,
            "steps[0] (a): the robot enters at 0 and leaves at 0; a stay takes time",
        ),
        (
            [stay("a", 0, None), stay("b", 1, 1, "B")],
            None,
            "steps[0] (a): only the last stay of a plan may be without an end",
        ),
        ([stay("a", 0, None)], None, "steps[0] (a): the plan ends here, so the last stay ends with it"),
        (
            [stay("a", 0, 1), stay("b", 1, "1/2", "B")],
            None,
            "steps[1] (b): the robot enters at 1 and the plan ends before, at 1/2",
        ),
        (
            [stay("a", 0, None)],
            Loop(0, None),
            "steps[0] (a): the robot parks here, where the map allows no waiting",
        ),
        (
            [stay("a", 0, 1)],
            Loop(0, None),
            "steps[0] (a): the robot parks here, so it leaves never, not at 1",
        ),
        (
            [stay("a", 0, 1), stay("b", 1, None, "B")],
            Loop(0, None),
            "steps[1] (b): the robot parks in its last cell, so the loop starts at 1, not 0",
        ),
        (
            [stay("a", 0, 1)],
            Loop(1, Fraction(1)),
            "steps[0] (a): the loop goes on at steps[1], but the last is steps[0]",
        ),
        (
            [stay("a", 0, None)],
            Loop(0, Fraction(1)),
            "steps[0] (a): the plan loops, so the last stay has an end",
        ),
        (
            [stay("a", 0, 1), stay("b", 1, 2, "B"), stay("c", 2, 3)],
            Loop(1, Fraction(3)),
            "steps[2] (c): one round of the loop takes 2, not the period 3",
        ),
        (
            [stay("a", 0, 1), stay("b", 1, 2, "B")],
            Loop(0, Fraction(2)),
            "steps[1] (b): no move leads from b to a",
        ),
        (
            [stay("a", 0, 1), stay("b", 1, 1, "B")],
            Loop(1, Fraction(0)),
            "steps[1] (b): the robot enters at 1 and leaves at 1; a stay takes time",
        ),
    ],
)
def test_the_first_fault(square: Workspace, steps: list[Step], loop: Loop | None, fault: str) -> None:
    assert follows(square, 0, steps, loop) == fault


def test_an_unknown_cell_is_named_with_advice() -> None:
    workspace = grid(2, 2, blocked=[[1, 1]])
    steps = [stay("r0c0", 0, 1), stay("r1c0", 1, 2), stay("r1c1", 2, 2)]
    assert follows(workspace, 0, [*steps[:2], stay("r0c9", 2, 2)]) == (
        "steps[1] (r1c0): no move leads from r1c0 to r0c9"
    )
    assert follows(workspace, 0, [stay("r0c0", 0, 1), *steps[2:]]) == (
        "steps[0] (r0c0): the robot leaves at 1, but enters r1c1 at 2"
    )


def test_the_ending() -> None:
    assert ending([stay("a", 0, 1), stay("b", 1, "5/2", "B")]) == Fraction(5, 2)
    assert ending([stay("a", 0, 1), stay("b", 1, None, "B")]) == 1
