"""Every exact transducer writes the truth of its operator on every signal, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.automata.iota import Iota, Letter, compose
from mitlplan.translation.seed import exact_transducers as exact
from tests.oracles.transduction import transduce

RESOLUTION = 2


@st.composite
def lassos(draw: st.DrawFn, *, inputs: int, longest: int = 8) -> tuple[list[Letter], int]:
    """Letters for the cells of a grid of half seconds, and where the last goes back to."""
    letter = st.tuples(*[st.booleans()] * inputs)
    letters = draw(st.lists(letter, min_size=1, max_size=longest))
    return letters, draw(st.integers(0, len(letters) - 1))


def unrolled(letters: list[Letter], repeat: int, length: int) -> list[Letter]:
    period = len(letters) - repeat
    once = letters[:repeat]
    return [*once, *(letters[repeat + at % period] for at in range(length - repeat))]


Truth = Callable[[list[Letter], int], bool]


def assert_exact(iota: Iota, letters: list[Letter], repeat: int, truth: Truth) -> None:
    long = unrolled(letters, repeat, 6 * len(letters) + 40)
    found = transduce(iota, letters, repeat, RESOLUTION)
    assert [set(values) for values in found.outputs] == [{truth(long, cell)} for cell in range(len(letters))]


def until_holds(long: list[Letter], cell: int) -> bool:
    for left, right in long[cell:]:
        if right:
            return True
        if not left:
            return False
    return False


def within(least: Fraction, most: Fraction) -> Truth:
    first, last = int(least * RESOLUTION), int(most * RESOLUTION)
    return lambda long, cell: any(letter[0] for letter in long[cell + first : cell + last + 1])


def timed(least: Fraction, most: Fraction) -> Iota:
    inner = exact.eventually_within(most - least, "x")
    if least == 0:
        return inner
    count = exact.outstanding_pairs(least, most - least)
    clocks = tuple(f"c{index}" for index in range(2 * count))
    return compose(exact.delay(least, most - least, "s", clocks), inner)


@given(lassos(inputs=1))
def test_negation(lasso: tuple[list[Letter], int]) -> None:
    assert_exact(exact.negation(), *lasso, lambda long, cell: not long[cell][0])


@given(lassos(inputs=2))
def test_conjunction(lasso: tuple[list[Letter], int]) -> None:
    assert_exact(exact.conjunction(), *lasso, lambda long, cell: all(long[cell]))


@given(lassos(inputs=2))
def test_until(lasso: tuple[list[Letter], int]) -> None:
    assert_exact(exact.until(), *lasso, until_holds)


@pytest.mark.parametrize(("least", "most"), [("0", "1/2"), ("0", "1"), ("0", "3/2"), ("0", "5")])
@given(lasso=lassos(inputs=1))
def test_eventually_within(least: str, most: str, lasso: tuple[list[Letter], int]) -> None:
    interval = Fraction(least), Fraction(most)
    assert_exact(timed(*interval), *lasso, within(*interval))


@pytest.mark.parametrize(
    ("least", "most"), [("1", "2"), ("1", "3"), ("2", "3"), ("1/2", "1"), ("1", "3/2"), ("3/2", "5/2")]
)
@given(lasso=lassos(inputs=1, longest=10))
def test_eventually_between(least: str, most: str, lasso: tuple[list[Letter], int]) -> None:
    interval = Fraction(least), Fraction(most)
    assert_exact(timed(*interval), *lasso, within(*interval))


@pytest.mark.parametrize(
    ("least", "most", "size"), [("0", "2", (4, 1)), ("2", "4", (36, 4)), ("3", "4", (140, 8))]
)
def test_sizes(least: str, most: str, size: tuple[int, int]) -> None:
    automaton = timed(Fraction(least), Fraction(most))
    assert (len(automaton.locations), len(automaton.clocks)) == size


def test_a_delay_needs_a_clock_for_every_outstanding_edge() -> None:
    with pytest.raises(ValueError, match="a delay of 2 needs 4 clocks"):
        exact.delay(Fraction(2), Fraction(1), "s", ("c0", "c1"))
