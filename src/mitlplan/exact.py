"""Exact numbers, as people write them.

Times, lengths and speeds are rational numbers from the file to the answer. Text such as ``0.1``, ``7/2`` or
``2e-3`` means the decimal or fraction that is written; no float is made on the way, since 0.1 as a float is
not a tenth. Very long numbers are refused: they would only serve to stall the exact arithmetic.
"""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction
from typing import TypeAlias

Number: TypeAlias = str | int | Fraction | Decimal
"""What :func:`exact` reads."""

_LONGEST = 40
_GREATEST = 10**18
_DECIMAL = re.compile(r"([+-]?)(\d+(?:\.\d*)?|\.\d+)(?:[eE]([+-]?\d{1,4}))?", re.ASCII)
_QUOTIENT = re.compile(r"([+-]?)(\d+) ?/ ?(\d+)", re.ASCII)
PATTERN = r"^\+?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]{1,2})?$|^\+?[0-9]+ ?/ ?[0-9]+$"
"""The texts that may be non-negative numbers, for JSON schemas."""


def exact(value: Number) -> Fraction:
    """Read a non-negative number exactly.

    Parameters
    ----------
    value
        A whole number, a fraction, a decimal or the text of one. Floats are refused.

    Raises
    ------
    ValueError
        If it is no number, is negative, infinite or too long; the message is a sentence for the user.

    Examples
    --------
    >>> exact("0.1"), exact("7/2"), exact(3)
    (Fraction(1, 10), Fraction(7, 2), Fraction(3, 1))
    """
    number = _fraction(value)
    if number < 0:
        raise ValueError(f"{value} is negative; write 0 or a positive number")
    if number > _GREATEST or number.denominator > _GREATEST:
        raise ValueError(f"{value} is out of range; numbers and their denominators go up to 1e18")
    return number


def _fraction(value: object) -> Fraction:
    match value:
        case bool() | float():
            raise ValueError(
                f"{value} is not an exact number; write it as a text or a Fraction, such as '0.1'"
            )
        case int() | Fraction():
            return Fraction(value)
        case Decimal() if value.is_finite() and abs(value.adjusted()) <= _LONGEST:
            return Fraction(value)
        case str():
            return _from_text(value)
    raise ValueError(f"{_shorten(value)} is not a number; write one such as 5, 2.5 or 7/2")


def _from_text(text: str) -> Fraction:
    if len(text) > _LONGEST:
        raise ValueError(f"{_shorten(text)} is too long for a number; at most {_LONGEST} characters are read")
    if quotient := _QUOTIENT.fullmatch(text):
        sign, numerator, denominator = quotient.groups()
        if int(denominator) == 0:
            raise ValueError(f"{text} divides by zero")
        return Fraction(int(sign + numerator), int(denominator))
    decimal = _DECIMAL.fullmatch(text)
    if decimal is None:
        raise ValueError(f"{_shorten(text)} is not a number; write one such as 5, 2.5 or 7/2")
    if abs(int(decimal[3] or 0)) > _LONGEST:
        raise ValueError(f"{text} is out of range; numbers and their denominators go up to 1e18")
    return Fraction(text)


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
