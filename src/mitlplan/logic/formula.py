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
