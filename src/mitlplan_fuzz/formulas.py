"""Random formulas, and the few things one does to a formula when fuzzing: print, scale, rewrite.

A generator asks a `Choices` for numbers: a seeded stream here, and in the tests what Hypothesis draws and
shrinks. The printer knows no precedence, so that it cannot share an error with the product's own.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Literal, Protocol, TypeVar

from mitlplan.logic import formula as f
from mitlplan.logic.formula import operands_of
from mitlplan.logic.interval import ALWAYS, Interval

Item = TypeVar("Item")
UntilKind = Literal["standard", "closed"]


class Choices(Protocol):
    """Where a generator gets its numbers from."""

    def number(self, least: int, most: int) -> int:
        """A whole number; the smaller the simpler."""


@dataclass(frozen=True)
class SeededChoices:
    """Numbers from a seeded stream: the same seed gives the same mission on every machine."""

    stream: random.Random

    def number(self, least: int, most: int) -> int:
        """A whole number."""
        # randrange may change between versions of Python, random() is promised not to.
        return least + int(self.stream.random() * (most - least + 1))


def one_of(choices: Choices, items: Sequence[Item]) -> Item:
    """One of the items; the first is the simplest."""
    return items[choices.number(0, len(items) - 1)]


def chance(choices: Choices, percent: int) -> bool:
    """True in that many of a hundred cases; false is the simpler."""
    return choices.number(0, 99) >= 100 - percent


# --- What one does to a formula ----------------------------------------------------------------------------


def text_of(formula: f.Formula) -> str:
    """The formula with parentheses round every part: a second printer, that knows no precedence."""
    match formula:
        case f.Constant(value):
            return str(value).lower()
        case f.Atom(name):
            return name
        case f.Not(operand):
            return f"!({text_of(operand)})"
        case f.Next(operand):
            return f"X ({text_of(operand)})"
        case f.And(operands):
            return " & ".join(f"({text_of(operand)})" for operand in operands)
        case f.Or(operands):
            return " | ".join(f"({text_of(operand)})" for operand in operands)
        case f.Implies(left, right):
            return f"({text_of(left)}) -> ({text_of(right)})"
        case f.Iff(left, right):
            return f"({text_of(left)}) <-> ({text_of(right)})"
        case f.Eventually(operand, interval):
            return f"F{_subscript(interval)} ({text_of(operand)})"
        case f.Always(operand, interval):
            return f"G{_subscript(interval)} ({text_of(operand)})"
        case f.Until(left, right, interval):
            return f"({text_of(left)}) U{_subscript(interval)} ({text_of(right)})"
        case f.Release(left, right, interval):
            return f"({text_of(left)}) R{_subscript(interval)} ({text_of(right)})"
        case f.WeakUntil(left, right):
            return f"({text_of(left)}) W ({text_of(right)})"


def _subscript(interval: Interval) -> str:
    return "" if interval == ALWAYS else str(interval)


def scaled(formula: f.Formula, factor: Fraction) -> f.Formula:
    """The formula with every bound multiplied; X is written out, for its step is one second."""
    match formula:
        case f.Next(operand):
            return scaled(f.Eventually(operand, Interval(Fraction(1), Fraction(1))), factor)
        case f.Eventually(operand, interval):
            return f.Eventually(scaled(operand, factor), _scaled_interval(interval, factor))
        case f.Always(operand, interval):
            return f.Always(scaled(operand, factor), _scaled_interval(interval, factor))
        case f.Until(left, right, interval):
            return f.Until(scaled(left, factor), scaled(right, factor), _scaled_interval(interval, factor))
        case f.Release(left, right, interval):
            return f.Release(scaled(left, factor), scaled(right, factor), _scaled_interval(interval, factor))
        case _:
            return with_operands(formula, [scaled(operand, factor) for operand in operands_of(formula)])


def _scaled_interval(interval: Interval, factor: Fraction) -> Interval:
    upper = None if interval.upper is None else interval.upper * factor
    return Interval(interval.lower * factor, upper, interval.lower_open, interval.upper_open)


def with_operands(formula: f.Formula, operands: Sequence[f.Formula]) -> f.Formula:
    """The same operator over other operands."""
    match formula:
        case f.Constant() | f.Atom():
            return formula
        case f.And() | f.Or():
            return type(formula)(tuple(operands))
        case f.Not() | f.Next():
            return type(formula)(operands[0])
        case f.Eventually(_, interval) | f.Always(_, interval):
            return type(formula)(operands[0], interval)
        case f.Implies() | f.Iff() | f.WeakUntil():
            return type(formula)(operands[0], operands[1])
        case f.Until(_, _, interval) | f.Release(_, _, interval):
            return type(formula)(operands[0], operands[1], interval)


def temporal(formula: f.Formula) -> bool:
    """Whether the outermost operator is temporal."""
    return isinstance(formula, (f.Eventually, f.Always, f.Until, f.Release, f.WeakUntil, f.Next))


def parts(formula: f.Formula) -> Iterator[f.Formula]:
    """Every subformula, the formula itself first."""
    yield formula
    for operand in operands_of(formula):
        yield from parts(operand)


# --- Drawing -----------------------------------------------------------------------------------------------


@dataclass
class _FormulaSource:
    """Draws one formula: at most `budget` more temporal operators."""

    choices: Choices
    names: Sequence[str]
    budget: int
    open_ends: bool

    def mission(self, depth: int) -> f.Formula:
        """A formula whose outer parts mostly speak of time: a literal there is decided at once."""
        if chance(self.choices, 20):
            return self.formula(depth, one_shot=True)
        if self.budget < 2 or chance(self.choices, 20):
            self.budget -= 1
            return self._timed(depth - 1, one_shot=True)
        self.budget -= 2
        operands = tuple(self._timed(depth - 1, one_shot=True) for _ in range(2))
        return f.Or(operands) if chance(self.choices, 20) else f.And(operands)

    def formula(self, depth: int, *, one_shot: bool) -> f.Formula:
        """A formula at most so deep; punctual intervals and X only where `one_shot`."""
        kind = self.choices.number(0, 9)
        if depth == 0 or kind < 2:
            return self._literal()
        if kind < 5 or self.budget == 0:
            return self._junction(depth - 1, one_shot)
        self.budget -= 1
        return self._timed(depth - 1, one_shot)

    def _literal(self) -> f.Formula:
        atom = f.Atom(one_of(self.choices, self.names))
        return f.Not(atom) if chance(self.choices, 35) else atom

    def _junction(self, depth: int, one_shot: bool) -> f.Formula:
        kind = self.choices.number(0, 9)
        if kind == 7:
            return f.Not(self.formula(depth, one_shot=False))
        if kind == 9:
            return f.Iff(self.formula(depth, one_shot=False), self.formula(depth, one_shot=False))
        if kind == 8:
            return f.Implies(self.formula(depth, one_shot=False), self.formula(depth, one_shot=one_shot))
        operands = tuple(self.formula(depth, one_shot=one_shot) for _ in range(2 + (kind == 6)))
        return f.Or(operands) if kind in (2, 3) else f.And(operands)

    def _timed(self, depth: int, one_shot: bool) -> f.Formula:
        kind = self.choices.number(0, 19)
        if kind < 8:
            return f.Eventually(self.formula(depth, one_shot=one_shot), self._interval(one_shot))
        if kind < 13:
            return f.Always(self.formula(depth, one_shot=False), self._interval(one_shot))
        if kind == 19 and one_shot:
            return f.Next(self.formula(depth, one_shot=True))
        left = self.formula(depth, one_shot=False)
        if kind == 18:
            return f.WeakUntil(left, self.formula(depth, one_shot=False))
        if kind < 16:
            return f.Until(left, self.formula(depth, one_shot=one_shot), self._interval(one_shot))
        return f.Release(left, self.formula(depth, one_shot=False), self._interval(one_shot))

    def _interval(self, one_shot: bool) -> Interval:
        number, kind = self.choices.number, self.choices.number(0, 9)
        if kind < 2:
            return ALWAYS
        lower = Fraction(number(0, 3) if kind > 5 else 0)
        lower_open = self.open_ends and chance(self.choices, 30)
        if kind == 9:
            return Interval(lower, None, lower_open)
        if kind == 8 and one_shot:
            return Interval(lower, lower)
        upper = Fraction(number(int(lower) + 1, 4))
        return Interval(lower, upper, lower_open, self.open_ends and chance(self.choices, 30))


def trivial(formula: f.Formula, until: UntilKind = "standard") -> bool:
    """Whether some part without regard to time is always true, always false, or a constant.

    Such a part is decided before it is known, by whoever notices: the least makespan of a formula with one
    says more about simplification than about planning.
    """
    return any(
        isinstance(junction, f.Constant)
        or (isinstance(junction, (f.And, f.Or, f.Not, f.Implies, f.Iff)) and _decided(junction))
        for part in parts(formula)
        for junction in (part, *_joined(part, until))
    )


def _joined(formula: f.Formula, until: UntilKind) -> tuple[f.Formula, ...]:
    """The junction that the closed until makes of the two sides."""
    match formula:
        case f.Until(left, right) | f.WeakUntil(left, right) if until == "closed":
            return (f.And((left, right)),)
        case f.Release(left, right) if until == "closed":
            return (f.Or((left, right)),)
        case _:
            return ()


def _decided(formula: f.Formula) -> bool:
    leaves = sorted(set(_leaves(formula)), key=repr)
    rows = product((False, True), repeat=len(leaves))
    values = {_value(formula, dict(zip(leaves, row, strict=True))) for row in rows}
    return len(values) == 1


def _leaves(formula: f.Formula) -> Iterator[f.Formula]:
    if temporal(formula) or isinstance(formula, (f.Atom, f.Constant)):
        yield formula
    else:
        for operand in operands_of(formula):
            yield from _leaves(operand)


def _value(formula: f.Formula, row: dict[f.Formula, bool]) -> bool:
    if formula in row:
        return row[formula]
    values = [_value(operand, row) for operand in operands_of(formula)]
    match formula:
        case f.And():
            return all(values)
        case f.Or():
            return any(values)
        case f.Not():
            return not values[0]
        case f.Implies():
            return not values[0] or values[1]
        case _:
            return values[0] == values[1]


def draw_formula(
    choices: Choices,
    names: Sequence[str],
    *,
    depth: int = 3,
    open_ends: bool = True,
    until: UntilKind = "standard",
) -> f.Formula:
    """A formula with one to four temporal operators, not trivial."""
    while True:
        source = _FormulaSource(choices, names, budget=choices.number(1, 4), open_ends=open_ends)
        formula = source.mission(depth)
        if any(temporal(part) for part in parts(formula)) and not trivial(formula, until):
            return formula
