from __future__ import annotations

from fractions import Fraction

import pytest

from mitlplan.errors import WorkspaceError
from mitlplan.workspace import UNLIMITED, Move, Workspace, graph

CELLS = {"a": [], "b": ["B"], "c": ["B", "C"]}


def moves_of(workspace: Workspace) -> list[tuple[str, str, Fraction, Fraction | None]]:
    return [
        (
            workspace.names[int(workspace.source[move])],
            workspace.names[int(workspace.target[move])],
            workspace.least_time(move),
            workspace.most_time(move),
        )
        for move in range(workspace.move_count)
    ]


def test_moves_are_sorted_and_directed() -> None:
    workspace = graph(CELLS, [Move("c", "a", 2), Move("a", "c", "1/2"), Move("a", "b", "0.1", both=True)])
    tenth, half, two = Fraction(1, 10), Fraction(1, 2), Fraction(2)
    assert moves_of(workspace) == [
        ("a", "b", tenth, tenth),
        ("a", "c", half, half),
        ("b", "a", tenth, tenth),
        ("c", "a", two, two),
    ]
    assert workspace.durations == (tenth, half, two)
    assert [list(workspace.moves_from(cell)) for cell in range(3)] == [[0, 1], [2], [3]]


def test_labels_are_shared_between_cells() -> None:
    workspace = graph({**CELLS, "d": ["C", "B"]}, [])
    assert workspace.label_sets == (frozenset(), frozenset({"B"}), frozenset({"B", "C"}))
    assert workspace.label_of.tolist() == [0, 1, 2, 2]
    assert workspace.propositions == {"B", "C"}


def test_a_range_and_an_unlimited_time() -> None:
    workspace = graph(CELLS, [Move("a", "b", ["2", Fraction(7, 2)]), Move("b", "c", 0)])
    assert moves_of(workspace) == [
        ("a", "b", Fraction(2), Fraction(7, 2)),
        ("b", "c", Fraction(0), None),
    ]
    assert workspace.most[1] == UNLIMITED


def test_the_same_move_counts_once_and_another_time_is_another_move() -> None:
    workspace = graph(CELLS, [Move("a", "b", 1, both=True), Move("b", "a", "1.0"), Move("b", "a", 3)])
    assert [(source, target, least) for source, target, least, _ in moves_of(workspace)] == [
        ("a", "b", 1),
        ("b", "a", 1),
        ("b", "a", 3),
    ]


def test_names_are_found_without_looking_through_them() -> None:
    workspace = graph(CELLS, [])
    assert [workspace.index_of(name) for name in ("a", "c", "d")] == [0, 2, None]


@pytest.mark.parametrize(
    ("move", "message", "where"),
    [
        (Move("a", "d", 1), "no cell is called d; the cells are a, b, c", ("moves", 1, "to")),
        (Move("d", "a", 1), "no cell is called d; the cells are a, b, c", ("moves", 1, "from")),
        (
            Move("a", "b", -1),
            "the time of a move: -1 is negative; write 0 or a positive number",
            ("moves", 1, "time"),
        ),
        (
            Move("a", "b", 0.5),  # type: ignore[arg-type]
            "the time of a move: 0.5 is not an exact number; write it as a text or a Fraction, such as '0.1'",
            ("moves", 1, "time"),
        ),
        (
            Move("a", "b", [1, 2, 3]),
            "a range of time is [least, most], two numbers, not 3",
            ("moves", 1, "time"),
        ),
        (
            Move("a", "b", [3, 2]),
            "the range of time [3, 2] has its least above its most; swap them",
            ("moves", 1, "time"),
        ),
        (
            Move("a", "b", [0, 0]),
            "the range of time [0, 0] holds no positive time; write 0 for any positive stay",
            ("moves", 1, "time"),
        ),
    ],
)
def test_refused_moves(move: Move, message: str, where: tuple[str | int, ...]) -> None:
    with pytest.raises(WorkspaceError) as caught:
        graph(CELLS, [Move("a", "b", 1), move])
    assert str(caught.value) == message
    assert caught.value.where == where


def test_a_workspace_has_a_cell() -> None:
    with pytest.raises(WorkspaceError, match=r"^the workspace has no cell$"):
        graph({}, [])
