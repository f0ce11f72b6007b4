"""Every kind of transducer against the judge, on robots that have no choice.

Where the robot's signal is given, the network of a formula has a run exactly if the formula holds: a wrong
answer in either direction is a fault of the translation (or of the search), never a matter of a faster plan.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial

import pytest

from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from tests.translation.forced import (
    Forced,
    Horizon,
    TooManyStatesError,
    UntilKind,
    random_forced,
    wrong_end,
    wrong_for_ever,
    wrong_parked,
)

BOUNDS = ((0, 1), (0, 2), (0, None), (1, 2), (1, 3), (1, None), (2, 3))
INTERVALS = [
    f"_{opening}{lower},{upper}{closing}"
    for lower, upper in ((lower, "inf" if upper is None else upper) for lower, upper in BOUNDS)
    for opening in "[("
    for closing in (")" if upper == "inf" else "])")
]
LITERALS = ("p", "q", "!p", "!q", "r")
CASES = 40
"""Formulas in each part of each nesting."""

Source = Callable[[random.Random], str]


def literal(stream: random.Random) -> str:
    """An atom or its negation."""
    return stream.choice(LITERALS)


def operator(kind: str, interval: str, left: str, right: str) -> str:
    """One temporal operator in front of, or between, its operands."""
    return f"{kind}{interval} ({right})" if kind in "FG" else f"({left}) {kind}{interval} ({right})"


def timed(stream: random.Random, left: Source = literal, right: Source = literal) -> str:
    """One temporal operator of any kind, with any interval."""
    return operator(stream.choice("FGUR"), stream.choice(INTERVALS), left(stream), right(stream))


def joined(stream: random.Random) -> str:
    """A temporal operator joined with a literal or another one."""
    other = stream.choice((literal, timed))(stream)
    negation = stream.choice(("", "!"))
    return f"{negation}({timed(stream)}) {stream.choice('&|')} ({other})"


NESTINGS: dict[str, Source] = {
    "negated": lambda stream: f"!({timed(stream)})",
    "joined": joined,
    "left": lambda stream: timed(stream, timed, literal),
    "right": lambda stream: timed(stream, literal, timed),
    "both": lambda stream: timed(stream, timed, timed),
    "junction left": lambda stream: timed(stream, joined, literal),
    "junction right": lambda stream: timed(stream, literal, joined),
    "again and again": lambda stream: f"G ({stream.choice(('', '!'))}({timed(stream)}) | {literal(stream)})",
    "weak": lambda stream: f"({literal(stream)}) W ({timed(stream)})",
    "punctual": lambda stream: f"F{stream.choice(INTERVALS)} ({literal(stream)} & F[1,1] ({timed(stream)}))",
    "three deep": lambda stream: timed(stream, literal, lambda inner: timed(inner, literal, timed)),
}


@dataclass
class Comparison:
    """What engine and judge disagree on, and how many questions took the engine too many states."""

    faults: list[str] = field(default_factory=list)
    asked: int = 0
    skipped: int = 0

    def ask(self, text: str, robot: Forced, until: UntilKind, horizon: Horizon) -> None:
        """Compare all the answers that there are for a formula and a robot."""
        formula = parse(text)
        questions = [partial(wrong_end, horizon=horizon)]
        if horizon == "infinite":
            questions += [partial(wrong_for_ever), partial(wrong_parked)]
        for question in questions:
            self.asked += 1
            try:
                found = question(formula, robot, until=until)
            except TooManyStatesError:
                self.skipped += 1
                continue
            if found is not None:
                self.faults.append(f"{text} ({until}, {horizon}) on {robot}: {found}")

    def __str__(self) -> str:
        return "\n".join([f"{len(self.faults)} faults in {self.asked} questions", *self.faults[:5]])


def options(stream: random.Random) -> tuple[UntilKind, Horizon]:
    """How the formula is read."""
    until: UntilKind = "closed" if stream.random() < 0.2 else "standard"
    horizon: Horizon = "finite" if stream.random() < 0.3 else "infinite"
    return until, horizon


@pytest.mark.parametrize("kind", ["F", "G", "U", "R"])
def test_single_operators(kind: str) -> None:
    """Each operator with each interval, on ten signals."""
    stream = random.Random(f"single {kind}")
    comparison = Comparison()
    for interval in INTERVALS:
        for _ in range(10):
            text = operator(kind, interval, literal(stream), literal(stream))
            comparison.ask(text, random_forced(stream), *options(stream))
    assert not comparison.faults, str(comparison)
    assert not comparison.skipped


@pytest.mark.parametrize("kind", ["U", "R"])
def test_late_operators_again_and_again(kind: str) -> None:
    """Asked at every time, what begins half a second later is said by operators that begin at once."""
    stream = random.Random(f"late {kind}")
    comparison = Comparison()
    for interval in ("_[1/2,1]", "_(1/2,3/2]", "_(1,3/2)", "_[1/2,inf)", "_(1/2,inf)", "_(3/2,inf)"):
        for _ in range(15):
            text = f"G ({literal(stream)} | ({operator(kind, interval, literal(stream), literal(stream))}))"
            comparison.ask(text, random_forced(stream), *options(stream))
    assert not comparison.faults, str(comparison)
    assert comparison.skipped <= comparison.asked // 5


@pytest.mark.parametrize("part", range(4))
@pytest.mark.parametrize("nesting", NESTINGS)
def test_nested_operators(nesting: str, part: int) -> None:
    """Operators as operands of others: claimed again and again, at instants and in between."""
    stream = random.Random(f"{nesting} {part}")
    comparison = Comparison()
    for _ in range(CASES):
        comparison.ask(NESTINGS[nesting](stream), random_forced(stream), *options(stream))
    assert not comparison.faults, str(comparison)
    assert comparison.skipped <= comparison.asked // 8


@pytest.mark.parametrize(
    ("text", "least"),
    [
        # Seen from 1 on, [1,inf) begins after the end. That q is never false anywhere is no obstacle.
        ("G_(0,1] G_[1,inf) !q", "1"),
        ("G_(0,1/2] G_[2,inf) !q", "1/2"),
        ("r R_(0,1] (p R_[1,inf) !q)", "1"),
    ],
)
def test_what_the_end_excuses_need_not_be_reachable(text: str, least: str) -> None:
    robot = Forced(((frozenset("q"), Fraction(1)), (frozenset("q"), Fraction(1))), 0)
    assert wrong_end(parse(text), robot, horizon="finite") is None
    assert satisfies(parse(text), robot.up_to(Fraction(least)), horizon="finite")


def robot(*stays: str, back: int = 0) -> Forced:
    """A robot whose stays are written like "pq 3/2"; a dash is no proposition."""
    split = [stay.split() for stay in stays]
    return Forced(tuple((frozenset(label.strip("-")), Fraction(time)) for label, time in split), back)


def test_nothing_is_owed_at_the_instant_at_which_a_delayed_claim_ends() -> None:
    """q has been seen when the robot parks: the claims of F[1,2) ended 1 before, just before that instant."""
    assert wrong_parked(parse("G_(0,2) (q -> F_[1,2) q)"), robot("p 1", "pqr 2", "pr 1")) is None
    assert wrong_parked(parse("G[0,1] (r -> F_(1,2] !p)"), robot("qr 1", "q 1", "pq 1"), "closed") is None


@pytest.mark.parametrize("horizon", ["infinite", "finite"])
def test_a_release_by_what_holds_just_after_an_instant(horizon: Horizon) -> None:
    """At 0 the left side fails, behind 0 it holds: at each time there was one before that released."""
    formula = parse("(!p R_[1,2] !q) R_(0,2] !p")
    walk = robot("pr 1", "qr 1", "- 1/2", "pr 1/2", "pr 1/2")
    assert satisfies(formula, walk.up_to(Fraction(1)), horizon=horizon)
    assert wrong_end(formula, walk, horizon=horizon) is None
    assert wrong_for_ever(formula, walk) is None
