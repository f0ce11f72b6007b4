"""Where an exact instant may be asked for: the one-shot positions.

A punctual interval ``[a,a]`` is outside MITL, because an operator that asks for an exact instant again and
again makes the logic undecidable. Asked once it is harmless (the flat part of MTL). A position is one-shot
if on the way down from the root nothing repeats it: no G, no left side of U, no right side of R, no W, where
a negation turns F into G, U into R and back. A punctual F, G or X only shifts time and repeats nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import NamedTuple

from mitlplan.errors import FormulaError
from mitlplan.logic.formula import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)
from mitlplan.logic.show import show

_MOST_SHOWN = 40


class _Place(NamedTuple):
    """Whether a place is one-shot, for each polarity it occurs in (both, below ``<->``)."""

    positive: bool | None
    negative: bool | None

    @property
    def one_shot(self) -> bool:
        return False not in self

    def negated(self) -> _Place:
        return _Place(self.negative, self.positive)

    def either(self) -> _Place:
        return _Place(self.one_shot, self.one_shot)

    def once(self) -> _Place:
        """Below F: at some time, hence once; negated it is below G."""
        return _Place(self.positive, None if self.negative is None else False)

    def repeated(self) -> _Place:
        """Below G: at every time; negated it is below F."""
        return _Place(None if self.positive is None else False, self.negative)


def repeated_instants(formula: Formula) -> Iterator[Formula]:
    """The punctual operators of a formula outside one-shot positions, from left to right.

    Parameters
    ----------
    formula
        Any formula, nested a few hundred levels at most.

    Yields
    ------
    Formula
        The offending nodes themselves: ``X f``, or an operator with the interval ``[a,a]``, a > 0.

    Examples
    --------
    >>> from mitlplan.logic.formula import Always, Atom, Next
    >>> list(repeated_instants(Always(Next(Atom("A")))))
    [Next(operand=Atom(name='A'))]
    >>> list(repeated_instants(Next(Atom("A"))))
    []
    """
    return _search(formula, _Place(positive=True, negative=None))


def refuse_repeated_instants(
    formula: Formula, text: str, place: Callable[[Formula], tuple[int, int]]
) -> None:
    """Refuse a formula with a punctual operator outside a one-shot position.

    Parameters
    ----------
    formula
        Any formula.
    text
        How the formula reads.
    place
        Where in `text` a node of the formula stands: first and last character, the last one excluded.

    Raises
    ------
    FormulaError
        At the first such operator, with an interval to write instead.
    """
    for node in repeated_instants(formula):
        start, end = place(node)
        letter, instant = _letter_and_instant(node)
        operator = "X" if isinstance(node, Next) else f"{letter}[{instant},{instant}]"
        raise FormulaError(
            f"`{operator}` asks for one exact instant, and here again and again (below G or W, left of U or "
            "right of R): that is outside MITL, and undecidable.",
            text,
            start,
            length=end - start,
            hint=f"allow a little time: {letter}{_widened(instant)}{_shown_operand(node)}",
        )


def _letter_and_instant(node: Formula) -> tuple[str, Fraction]:
    match node:
        case Eventually(_, interval):
            return "F", interval.lower
        case Always(_, interval):
            return "G", interval.lower
        case Until(_, _, interval):
            return "U", interval.lower
        case Release(_, _, interval):
            return "R", interval.lower
        case _:
            return "F", Fraction(1)


def _widened(instant: Fraction) -> str:
    end = f"{instant}.1" if instant.denominator == 1 else f"{instant + Fraction(1, 10)}"
    return f"[{instant},{end}]"


def _shown_operand(node: Formula) -> str:
    match node:
        case Eventually(operand) | Always(operand) | Next(operand):
            shown = show(Eventually(operand)).removeprefix("F")
            return shown if len(shown) <= _MOST_SHOWN else " ..."
        case _:
            return ""


def _search(formula: Formula, place: _Place) -> Iterator[Formula]:
    if not place.one_shot and _asks_for_an_instant(formula):
        yield formula
    for operand, below in _descend(formula, place):
        yield from _search(operand, below)


def _descend(formula: Formula, place: _Place) -> list[tuple[Formula, _Place]]:
    match formula:
        case Constant() | Atom():
            return []
        case Not(operand):
            return [(operand, place.negated())]
        case And(operands) | Or(operands):
            return [(operand, place) for operand in operands]
        case Implies(left, right):
            return [(left, place.negated()), (right, place)]
        case Iff(left, right):
            return [(left, place.either()), (right, place.either())]
        case Next(operand):
            return [(operand, place)]
        case Eventually(operand, interval) | Always(operand, interval) if interval.punctual:
            return [(operand, place)]
        case Eventually(operand):
            return [(operand, place.once())]
        case Always(operand):
            return [(operand, place.repeated())]
        case Until(left, right):
            return [(left, place.repeated()), (right, place.once())]
        case Release(left, right):
            return [(left, place.once()), (right, place.repeated())]
        case WeakUntil(left, right):
            nowhere = _Place(positive=False, negative=False)
            return [(left, nowhere), (right, nowhere)]


def _asks_for_an_instant(formula: Formula) -> bool:
    match formula:
        case Next():
            return True
        case (
            Eventually(interval=interval)
            | Always(interval=interval)
            | Until(interval=interval)
            | Release(interval=interval)
        ):
            return interval.punctual and interval.lower > 0
        case _:
            return False
