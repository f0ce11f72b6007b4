"""The faults of the published construction are shown by runs, and docs/paper.md says what they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.translation.seed.faults import Fault, every_fault, table

PAGE = Path(__file__).parents[3] / "docs" / "paper.md"
FAULTS = every_fault()


def fault(number: int, rank: int = 0) -> Fault:
    return [row for row in FAULTS if row.number == number][rank]


@pytest.mark.parametrize(
    ("number", "rank", "accepted"),
    [
        (1, 0, "accepts at 4: 0 c0 1 c1 2 c2 3 c3 4 c2"),
        (6, 1, "accepts at 4: 0 pos0 1 pos1 2 pos0 3 pos3 4 pos0"),
        (14, 0, "accepts at 7: 0 c0 1 c1 2 c2 3 c3 4 c4 5 c5 6 c6 7 c5"),
    ],
)
def test_it_accepts_what_violates_the_formula(number: int, rank: int, accepted: str) -> None:
    row = fault(number, rank)
    assert row.published == accepted
    assert row.truth == "the judge: violated, whatever follows; infeasible"


@pytest.mark.parametrize(("rank", "accepted"), [(0, "accepts at 1: 0 c0 1 c1"), (2, "accepts at 0: 0 c0")])
def test_it_drops_promises(rank: int, accepted: str) -> None:
    assert fault(7, rank).published == accepted
    assert fault(7, rank).truth == "infeasible"


@pytest.mark.parametrize(
    ("number", "rank", "published", "least"),
    [
        (2, 0, "accepts nothing up to 14", 2),
        (6, 0, "accepts at 4: 0 pos0 1 pos1 2 pos0 3 pos3 4 pos0", 3),
        (7, 1, "accepts nothing up to 14", 1),
    ],
)
def test_it_misses_what_satisfies_the_formula(number: int, rank: int, published: str, least: int) -> None:
    row = fault(number, rank)
    assert row.published == published
    assert row.truth.startswith(f"least makespan {least}: ")


def test_the_paper_and_its_program_differ() -> None:
    assert fault(3).published.startswith(
        "the program accepts nothing up to 14; the paper's version accepts at 4"
    )
    strict = "the paper's version: at 4: the invariant z[5]<2 of CHK_3 does not hold; the program: executed"
    assert fault(4).published == strict
    assert fault(5).published.startswith("the program: at 1: a guard of generator does not hold; the paper's")
    assert fault(5).published.endswith("executed")


def test_what_the_program_cannot_read() -> None:
    assert fault(9).published == "ours has 2 time units a second, and bounds 1 and 3"
    assert fault(10).published == "ours, to the same letter, has 35 locations and 48 edges"
    assert "cannot handle a timed operator inside another one or mixed" in fault(11).published
    assert fault(12).published == "0 of its 62 edges leave the robot in its cell"


def test_the_page_has_the_table() -> None:
    assert table() in PAGE.read_text(encoding="utf-8")
