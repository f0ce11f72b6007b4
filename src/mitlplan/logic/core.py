"""The formula as the translation sees it: negation only on atoms, two temporal operators.

``F_I f`` is ``true U_I f`` and ``G_I f`` is ``false R_I f``; the until is the standard one. The functions
:func:`conjunction`, :func:`disjunction`, :func:`until` and :func:`release` are the only way to build a tree:
they flatten, sort, drop what is absorbed and fold constants, so equal requirements become equal trees.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias, Union

from mitlplan.logic.interval import ALWAYS, Interval


@dataclass(frozen=True, slots=True)
class Truth:
    """A constant."""

    value: bool


@dataclass(frozen=True, slots=True)
class Literal:
    """An atom or its negation."""

    name: str
    positive: bool = True


@dataclass(frozen=True, slots=True)
class Conjunction:
    """Two operands or more, sorted, none a conjunction or a constant."""

    operands: tuple[Core, ...]


@dataclass(frozen=True, slots=True)
class Disjunction:
    """Two operands or more, sorted, none a disjunction or a constant."""

    operands: tuple[Core, ...]


@dataclass(frozen=True, slots=True)
class CoreUntil:
    """``left U_I right`` (standard)."""

    left: Core
    right: Core
    interval: Interval = ALWAYS


@dataclass(frozen=True, slots=True)
class CoreRelease:
    """``left R_I right`` (standard)."""

    left: Core
    right: Core
    interval: Interval = ALWAYS


Core: TypeAlias = Union[Truth, Literal, Conjunction, Disjunction, CoreUntil, CoreRelease]

TRUE = Truth(True)
FALSE = Truth(False)


def propositional(core: Core) -> bool:
    """Whether the truth of `core` depends on the present label alone."""
    match core:
        case Truth() | Literal():
            return True
        case Conjunction(operands) | Disjunction(operands):
            return all(propositional(operand) for operand in operands)
        case CoreUntil() | CoreRelease():
            return False


def holds(core: Core, label: frozenset[str]) -> bool:
    """Whether a propositional formula is true where `label` is the set of true propositions.

    Raises
    ------
    ValueError
        If `core` is not propositional.
    """
    match core:
        case Truth(value):
            return value
        case Literal(name, positive):
            return (name in label) == positive
        case Conjunction(operands):
            return all(holds(operand, label) for operand in operands)
        case Disjunction(operands):
            return any(holds(operand, label) for operand in operands)
        case _:
            raise ValueError("the truth of a temporal formula does not depend on the label alone")


def negate(core: Core) -> Core:
    """The negation of `core`, pushed to the atoms."""
    match core:
        case Truth(value):
            return FALSE if value else TRUE
        case Literal(name, positive):
            return Literal(name, not positive)
        case Conjunction(operands):
            return disjunction(*(negate(operand) for operand in operands))
        case Disjunction(operands):
            return conjunction(*(negate(operand) for operand in operands))
        case CoreUntil(left, right, interval):
            return release(negate(left), negate(right), interval)
        case CoreRelease(left, right, interval):
            return until(negate(left), negate(right), interval)


def conjunction(*operands: Core) -> Core:
    """The conjunction in normal form."""
    return _junction(Conjunction, operands, unit=TRUE, absorbing=FALSE)


def disjunction(*operands: Core) -> Core:
    """The disjunction in normal form."""
    return _junction(Disjunction, operands, unit=FALSE, absorbing=TRUE)


def _junction(
    kind: type[Conjunction | Disjunction],
    operands: tuple[Core, ...],
    *,
    unit: Truth,
    absorbing: Truth,
) -> Core:
    flat: dict[Core, None] = {}
    for operand in operands:
        match operand:
            case Conjunction(inner) | Disjunction(inner) if isinstance(operand, kind):
                flat.update(dict.fromkeys(inner))
            case _ if operand == unit:
                continue
            case _:
                flat[operand] = None
    if absorbing in flat or any(isinstance(operand, Literal) and negate(operand) in flat for operand in flat):
        return absorbing
    if not flat:
        return unit
    if len(flat) == 1:
        return next(iter(flat))
    return kind(tuple(sorted(flat, key=repr)))


def until(left: Core, right: Core, interval: Interval = ALWAYS) -> Core:
    """``left U_I right`` in normal form."""
    if right == FALSE or (interval.punctual and interval.lower == 0):
        return right
    starts_now = Fraction(0) in interval
    if starts_now and right == TRUE:
        return TRUE
    if left == FALSE:
        return right if starts_now else FALSE
    if left == TRUE and right == TRUE:
        return TRUE
    return CoreUntil(left, right, interval)


def release(left: Core, right: Core, interval: Interval = ALWAYS) -> Core:
    """``left R_I right`` in normal form."""
    if right == TRUE or (interval.punctual and interval.lower == 0):
        return right
    starts_now = Fraction(0) in interval
    if starts_now and right == FALSE:
        return FALSE
    if left == TRUE:
        return right if starts_now else TRUE
    # Without an upper bound it may ask nothing of a mission that ends early enough (horizon: finite).
    if left == FALSE and right == FALSE and interval.upper is not None:
        return FALSE
    return CoreRelease(left, right, interval)


def eventually(operand: Core, interval: Interval = ALWAYS) -> Core:
    """``F_I operand``."""
    return until(TRUE, operand, interval)


def always(operand: Core, interval: Interval = ALWAYS) -> Core:
    """``G_I operand``."""
    return release(FALSE, operand, interval)
