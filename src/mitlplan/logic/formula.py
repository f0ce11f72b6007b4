"""Formulas as the user wrote them.

This tree keeps the user's own words: an implication stays an implication and parentheses that group
a conjunction stay a node of their own, so that :func:`mitlplan.logic.show.show` prints the formula back.
What the translation works on is the smaller tree of :mod:`mitlplan.logic.core`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, Union

from mitlplan.logic.interval import ALWAYS, Interval


@dataclass(frozen=True, slots=True)
class Constant:
    """``true`` or ``false``."""

    value: bool


@dataclass(frozen=True, slots=True)
class Atom:
    """A proposition: true exactly while the robot is in a cell that carries it."""

    name: str


@dataclass(frozen=True, slots=True)
class Not:
    """``!f``."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class And:
    """``f & g & ...``: two operands or more."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """``f | g | ...``: two operands or more."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Implies:
    """``f -> g``."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Iff:
    """``f <-> g``."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Eventually:
    """``F_I f``: f at some time of the interval."""

    operand: Formula
    interval: Interval = ALWAYS


@dataclass(frozen=True, slots=True)
class Always:
    """``G_I f``: f at every time of the interval."""

    operand: Formula
    interval: Interval = ALWAYS


@dataclass(frozen=True, slots=True)
class Next:
    """``X f``: f one time unit later (the paper's next)."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Until:
    """``f U_I g``: g at some time of the interval, and f at every time before it."""

    left: Formula
    right: Formula
    interval: Interval = ALWAYS


@dataclass(frozen=True, slots=True)
class Release:
    """``f R_I g``, the dual of until: g up to and including the instant at which f holds."""

    left: Formula
    right: Formula
    interval: Interval = ALWAYS


@dataclass(frozen=True, slots=True)
class WeakUntil:
    """``f W g``: ``G f | (f U g)``."""

    left: Formula
    right: Formula


Formula: TypeAlias = Union[
    Constant,
    Atom,
    Not,
    And,
    Or,
    Implies,
    Iff,
    Eventually,
    Always,
    Next,
    Until,
    Release,
    WeakUntil,
]

MOST_LEVELS = 100
"""How deep a formula may be nested, so that a function that calls itself for the operands stays safe."""


def operands_of(formula: Formula) -> tuple[Formula, ...]:
    """The formulas that `formula` is made of, from left to right.

    Examples
    --------
    >>> operands_of(Until(Atom("corridor"), Atom("dock")))
    (Atom(name='corridor'), Atom(name='dock'))
    """
    match formula:
        case Constant() | Atom():
            return ()
        case And(operands) | Or(operands):
            return operands
        case Not(operand) | Eventually(operand) | Always(operand) | Next(operand):
            return (operand,)
        case (
            Implies(left, right)
            | Iff(left, right)
            | Until(left, right)
            | Release(left, right)
            | WeakUntil(left, right)
        ):
            return left, right
