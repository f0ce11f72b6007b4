from __future__ import annotations

import contextlib
import re
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.exact import PATTERN, exact


@pytest.mark.parametrize(
    ("value", "number"),
    [
        ("0.1", Fraction(1, 10)),
        ("7/2", Fraction(7, 2)),
        ("7 / 2", Fraction(7, 2)),
        ("+5", Fraction(5)),
        ("5.", Fraction(5)),
        (".5", Fraction(1, 2)),
        ("2.5e-3", Fraction(1, 400)),
        ("1E3", Fraction(1000)),
        ("-0", Fraction(0)),
        ("007", Fraction(7)),
        (3, Fraction(3)),
        (Fraction(1, 3), Fraction(1, 3)),
        (Decimal("0.1"), Fraction(1, 10)),
        ("1000000000000000000", Fraction(10**18)),
    ],
)
def test_read_as_written(value: str | int | Fraction | Decimal, number: Fraction) -> None:
    assert exact(value) == number


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("-1", "-1 is negative; write 0 or a positive number"),
        (-1, "-1 is negative; write 0 or a positive number"),
        ("1e400", "1e400 is out of range; numbers and their denominators go up to 1e18"),
        ("1e-30", "1e-30 is out of range; numbers and their denominators go up to 1e18"),
        ("1e9999", "1e9999 is out of range; numbers and their denominators go up to 1e18"),
        (10**19, "10000000000000000000 is out of range; numbers and their denominators go up to 1e18"),
        ("1/0", "1/0 divides by zero"),
        ("nan", "'nan' is not a number; write one such as 5, 2.5 or 7/2"),
        ("inf", "'inf' is not a number; write one such as 5, 2.5 or 7/2"),
        ("1_000", "'1_000' is not a number; write one such as 5, 2.5 or 7/2"),
        ("0x10", "'0x10' is not a number; write one such as 5, 2.5 or 7/2"),
        ("٣", "'٣' is not a number; write one such as 5, 2.5 or 7/2"),
        ("1e99999", "'1e99999' is not a number; write one such as 5, 2.5 or 7/2"),
        ("", "'' is not a number; write one such as 5, 2.5 or 7/2"),
        ("9" * 41, f"'{'9' * 36}... is too long for a number; at most 40 characters are read"),
        (Decimal("NaN"), "Decimal('NaN') is not a number; write one such as 5, 2.5 or 7/2"),
        (Decimal("1e999999"), "Decimal('1E+999999') is not a number; write one such as 5, 2.5 or 7/2"),
        (0.1, "0.1 is not an exact number; write it as a text or a Fraction, such as '0.1'"),
        (float("inf"), "inf is not an exact number; write it as a text or a Fraction, such as '0.1'"),
        (True, "True is not an exact number; write it as a text or a Fraction, such as '0.1'"),
        (None, "None is not a number; write one such as 5, 2.5 or 7/2"),
        ([1], "[1] is not a number; write one such as 5, 2.5 or 7/2"),
    ],
)
def test_refused(value: object, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        exact(value)  # type: ignore[arg-type]


@given(st.decimals(0, 10**6, places=6))
def test_decimals_are_exact(number: Decimal) -> None:
    assert exact(str(number)) == Fraction(number)


@given(st.fractions(0, 10**6, max_denominator=10**6))
def test_fractions_come_back(number: Fraction) -> None:
    assert exact(str(number)) == number


@given(st.from_regex(PATTERN, fullmatch=True))
def test_the_published_pattern_is_what_is_read(text: str) -> None:
    # Only what a pattern cannot say is refused beyond it.
    with contextlib.suppress(ValueError):
        assert exact(text) >= 0
        return
    with pytest.raises(ValueError, match=r"divides by zero|out of range|too long"):
        exact(text)
