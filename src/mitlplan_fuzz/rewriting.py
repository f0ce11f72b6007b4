"""Random rewriting of formulas by identities that hold of every right-continuous signal.

A formula and what it is rewritten as must be equivalent, whoever is asked. The identities are those of the
page on the translation, about the operators as they are written, with both readings of until.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from mitlplan.logic import formula as f
from mitlplan.logic.interval import ALWAYS, Interval
from mitlplan_fuzz.formulas import Choices, chance, one_of, with_operands


def draw_rewritten(choices: Choices, formula: f.Formula) -> f.Formula:
    """The formula with about half of its parts said otherwise."""
    operands = [draw_rewritten(choices, operand) for operand in f.operands_of(formula)]
    part = with_operands(formula, operands)
    ways = list(_ways(part))
    return one_of(choices, ways) if ways and chance(choices, 60) else part


def _ways(part: f.Formula) -> Iterator[f.Formula]:
    """Other formulas that mean the same."""
    match part:
        case f.Not(f.And(operands)):
            yield f.Or(tuple(map(f.Not, operands)))
        case f.Not(f.Or(operands)):
            yield f.And(tuple(map(f.Not, operands)))
        case f.And(operands) | f.Or(operands):
            yield type(part)(tuple(reversed(operands)))
        case f.Implies(left, right):
            yield f.Or((f.Not(left), right))
        case f.Iff(left, right):
            yield f.And((f.Implies(left, right), f.Implies(right, left)))
        case f.Next(operand):
            yield f.Eventually(operand, Interval(Fraction(1), Fraction(1)))
        case f.Eventually(operand, interval):
            yield f.Not(f.Always(f.Not(operand), interval))
            yield f.Until(f.Constant(value=True), operand, interval)
            if isinstance(operand, f.Or):
                yield f.Or(tuple(f.Eventually(each, interval) for each in operand.operands))
            for first, second in _split(interval):
                yield f.Or((f.Eventually(operand, first), f.Eventually(operand, second)))
        case f.Always(operand, interval):
            yield f.Not(f.Eventually(f.Not(operand), interval))
            yield f.Release(f.Constant(value=False), operand, interval)
            if isinstance(operand, f.And):
                yield f.And(tuple(f.Always(each, interval) for each in operand.operands))
            for first, second in _split(interval):
                yield f.And((f.Always(operand, first), f.Always(operand, second)))
        case f.Until(left, right, interval):
            yield f.Not(f.Release(f.Not(left), f.Not(right), interval))
            if interval.lower == 0 and not interval.lower_open and interval.upper is not None:
                # Where until asks for both sides at once, so must the deadline.
                yield f.And((f.Until(left, right), f.Until(left, right, interval)))
        case f.Release(left, right, interval):
            yield f.Not(f.Until(f.Not(left), f.Not(right), interval))
        case f.WeakUntil(left, right):
            yield f.Or((f.Always(left), f.Until(left, right)))


def _split(interval: Interval) -> Iterator[tuple[Interval, Interval]]:
    """Two intervals that together are this one."""
    if interval == ALWAYS or interval.upper is None or interval.upper - interval.lower < 2:
        return
    middle = interval.lower + 1
    yield (
        Interval(interval.lower, middle, interval.lower_open, upper_open=True),
        Interval(middle, interval.upper, lower_open=False, upper_open=interval.upper_open),
    )
