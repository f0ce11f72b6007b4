"""Writing a formula back as text.

Parentheses appear only where precedence needs them, so ``parse(show(formula)) == formula``: a conjunction
that the user grouped is a node of its own and gets its parentheses back. The spellings are one a concept:
``! & | -> <-> F G X U R W``.
"""

from __future__ import annotations

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
from mitlplan.logic.interval import Interval

# How tightly each kind of node binds: the grammar's levels, loosest first.
_IFF, _IMPLIES, _OR, _AND, _BINARY, _UNARY, _PRIMARY = range(7)


def show(formula: Formula) -> str:
    """The text of a formula, with as few parentheses as precedence allows.

    Parameters
    ----------
    formula
        Any formula; bounds are written as exact fractions of seconds.

    Returns
    -------
    str
        A text that `mitlplan.logic.parse.parse` reads back as the same formula.

    Examples
    --------
    >>> from mitlplan.logic.formula import And, Atom, Eventually, Not, Until
    >>> show(And((Until(Not(Atom("A")), Atom("B")), Eventually(Atom("A")))))
    '!A U B & F A'
    """
    return _write(formula)[0]


def _write(formula: Formula) -> tuple[str, int]:
    match formula:
        case Constant(value):
            return ("true" if value else "false"), _PRIMARY
        case Atom(name):
            return name, _PRIMARY
        case Not(operand):
            return "!" + _within(operand, _UNARY), _UNARY
        case And(operands):
            return " & ".join(_within(operand, _AND + 1) for operand in operands), _AND
        case Or(operands):
            return " | ".join(_within(operand, _OR + 1) for operand in operands), _OR
        case Implies(left, right):
            return f"{_within(left, _IMPLIES + 1)} -> {_within(right, _IMPLIES)}", _IMPLIES
        case Iff(left, right):
            return f"{_within(left, _IFF)} <-> {_within(right, _IFF + 1)}", _IFF
        case Eventually(operand, interval):
            return _prefix("F" + _subscript(interval), operand), _UNARY
        case Always(operand, interval):
            return _prefix("G" + _subscript(interval), operand), _UNARY
        case Next(operand):
            return _prefix("X", operand), _UNARY
        case Until(left, right, interval):
            return _infix(left, "U" + _subscript(interval), right), _BINARY
        case Release(left, right, interval):
            return _infix(left, "R" + _subscript(interval), right), _BINARY
        case WeakUntil(left, right):
            return _infix(left, "W", right), _BINARY


def _within(operand: Formula, level: int) -> str:
    text, own_level = _write(operand)
    return text if own_level >= level else f"({text})"


def _prefix(operator: str, operand: Formula) -> str:
    text = _within(operand, _UNARY)
    return operator + text if text.startswith("(") else f"{operator} {text}"


def _infix(left: Formula, operator: str, right: Formula) -> str:
    # Right associative: only the left side needs parentheses around another until.
    return f"{_within(left, _UNARY)} {operator} {_within(right, _BINARY)}"


def _subscript(interval: Interval) -> str:
    return "" if interval.unrestricted else str(interval)
