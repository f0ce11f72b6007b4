"""The repaired construction against the judge, on robots that have no choice.

Its transducers say yes and no, and one that is asked for both at times near each other has several changes of
its guess to keep in mind. Formulas here ask for that, with the closed bounds that the construction knows.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import partial

import pytest

from mitlplan.logic.parse import parse
from tests.translation.forced import (
    TooManyStatesError,
    random_forced,
    wrong_end,
    wrong_for_ever,
    wrong_parked,
)

LITERALS = ("p", "q", "!p", "!q", "r")
CASES = 20


def timed(stream: random.Random) -> str:
    """An eventually or an always, with a delay or without."""
    interval = stream.choice(("[0,1]", "[0,2]", "[1,2]", "[1,3]", "[2,3]", "[2,7/2]", "[3,4]"))
    return f"{stream.choice('FG')}{interval} {stream.choice(LITERALS)}"


def both_ways(stream: random.Random) -> str:
    """Here it must hold, and there it must not."""
    asked, here, there = timed(stream), stream.choice(LITERALS), stream.choice(LITERALS)
    return f"G (({here}) & !({there}) -> {asked}) & G (({there}) & !({here}) -> !({asked}))"


SHAPES: dict[str, Callable[[random.Random], str]] = {
    "alone": timed,
    "both ways": both_ways,
    "again and again": lambda stream: f"G ({stream.choice(LITERALS)} | {timed(stream)})",
    "until": lambda stream: f"({timed(stream)}) U[0,2] ({stream.choice(LITERALS)})",
    "release": lambda stream: f"({stream.choice(LITERALS)}) R ({timed(stream)} | {stream.choice(LITERALS)})",
    "nested": lambda stream: f"F[1,3] ({stream.choice(LITERALS)} & ({timed(stream)}))",
}


@pytest.mark.parametrize("shape", SHAPES)
def test_a_run_exactly_if_the_formula_holds(shape: str) -> None:
    stream = random.Random(shape)
    faults = []
    skipped = 0
    for _ in range(CASES):
        text, walk = SHAPES[shape](stream), random_forced(stream)
        for question in (wrong_end, partial(wrong_end, horizon="finite"), wrong_for_ever, wrong_parked):
            try:
                fault = question(parse(text), walk, construction="seed")
            except TooManyStatesError:
                skipped += 1
                continue
            if fault is not None:
                faults.append(f"{text} on {walk}: {fault}")
    assert not faults, "\n".join(faults[:5])
    assert skipped <= CASES // 2
