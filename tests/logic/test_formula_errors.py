"""Every message about a formula that cannot be read, whole, as the user sees it.

A case is the text and, indented as it is printed, the message.
"""

from __future__ import annotations

from textwrap import dedent

import pytest

from mitlplan.errors import FormulaError
from mitlplan.logic.parse import parse

AGAIN = (
    "asks for one exact instant, and here again and again (below G or W, left of U or right of R): that is "
    "outside MITL, and undecidable."
)

CASES = [
    # A formula was expected
    (
        "",
        """
        The formula is empty.
        """,
    ),
    (
        "  \n",
        """
        The formula is empty.
        """,
    ),
    (
        "!",
        """
        Expected a formula, but the text ends.
          !
           ^
        """,
    ),
    (
        "A &",
        """
        Expected a formula, but the text ends.
          A &
             ^
        """,
    ),
    (
        "A & & B",
        """
        Expected a formula, but found `&`.
          A & & B
              ^
        """,
    ),
    (
        "A U",
        """
        Expected a formula or an interval, but the text ends.
          A U
             ^
          hint: the single letters F G U R W X V are operators, not names
        """,
    ),
    (
        "F[0,2]",
        """
        Expected a formula, but the text ends.
          F[0,2]
                ^
        """,
    ),
    (
        "F",
        """
        Expected a formula or an interval, but the text ends.
          F
           ^
          hint: the single letters F G U R W X V are operators, not names
        """,
    ),
    (
        "(",
        """
        Expected a formula, but the text ends.
          (
           ^
        """,
    ),
    (
        "()",
        """
        Expected a formula, but found `)`.
          ()
           ^
        """,
    ),
    (
        "A U W",
        """
        Expected a formula or an interval, but found `W`.
          A U W
              ^
          hint: W stands between two formulas; the single letters F G U R W X V are operators, not names
        """,
    ),
    (
        "U A",
        """
        Expected a formula, but found `U`.
          U A
          ^
          hint: U stands between two formulas; the single letters F G U R W X V are operators, not names
        """,
    ),
    (
        "A W [0,2] B",
        """
        Expected a formula, but found `[`.
          A W [0,2] B
              ^
          hint: W takes no interval
        """,
    ),
    (
        "X[0,2] A",
        """
        Expected a formula, but found `[`.
          X[0,2] A
           ^
          hint: X takes no interval
        """,
    ),
    (
        "X",
        """
        Expected a formula, but the text ends.
          X
           ^
          hint: the single letters F G U R W X V are operators, not names
        """,
    ),
    (
        "2 A",
        """
        Expected a formula, but found `2`.
          2 A
          ^
          hint: numbers stand in intervals only; a name begins with a letter
        """,
    ),
    (
        "A & 2x",
        """
        Expected a formula, but found `2x`.
          A & 2x
              ^^
          hint: numbers stand in intervals only; a name begins with a letter
        """,
    ),
    (
        "A ->",
        """
        Expected a formula, but the text ends.
          A ->
              ^
        """,
    ),
    (
        ")",
        """
        Expected a formula, but found `)`.
          )
          ^
        """,
    ),
    # An operator was expected
    (
        "A B",
        """
        Expected an operator or the end of the formula, but found `B`.
          A B
            ^
          hint: join two formulas with an operator such as & or U
        """,
    ),
    (
        "(A B)",
        """
        Expected an operator or `)`, but found `B`.
          (A B)
             ^
          hint: join two formulas with an operator such as & or U
        """,
    ),
    (
        "(A",
        """
        Expected an operator or `)`, but the text ends.
          (A
            ^
          hint: the `(` at character 1 is not closed
        """,
    ),
    (
        "((A & B) | (C",
        """
        Expected an operator or `)`, but the text ends.
          ((A & B) | (C
                       ^
          hint: the `(` at character 12 is not closed
        """,
    ),
    (
        "A)",
        """
        Expected an operator or the end of the formula, but found `)`.
          A)
           ^
          hint: there is no `(` for it
        """,
    ),
    (
        "GF[0,2] A",
        """
        Expected an operator or the end of the formula, but found `[`.
          GF[0,2] A
            ^
          hint: put a space between operators: G F
        """,
    ),
    (
        "GF A",
        """
        Expected an operator or the end of the formula, but found `A`.
          GF A
             ^
          hint: put a space between operators: G F
        """,
    ),
    (
        "F_(A)",
        """
        Expected an operator or the end of the formula, but found `(`.
          F_(A)
            ^
          hint: after an operator an underscore begins an interval, as in F_[0,5]
        """,
    ),
    (
        "A AND B",
        """
        Expected an operator or the end of the formula, but found `AND`.
          A AND B
            ^^^
          hint: write `and`, in small letters
        """,
    ),
    (
        "NOT A",
        """
        Expected an operator or the end of the formula, but found `A`.
          NOT A
              ^
          hint: write `not`, in small letters
        """,
    ),
    (
        "A !B",
        """
        Expected an operator or the end of the formula, but found `!`.
          A !B
            ^
          hint: join two formulas with an operator such as & or U
        """,
    ),
    (
        "A true",
        """
        Expected an operator or the end of the formula, but found `true`.
          A true
            ^^^^
          hint: join two formulas with an operator such as & or U
        """,
    ),
    (
        "A[0,2]",
        """
        Expected an operator or the end of the formula, but found `[`.
          A[0,2]
           ^
          hint: an interval follows F, G, U or R
        """,
    ),
    (
        "A, B",
        """
        Expected an operator or the end of the formula, but found `,`.
          A, B
           ^
          hint: join two formulas with an operator such as & or U
        """,
    ),
    # Inside an interval
    (
        "F[",
        """
        Expected a number, but the text ends.
          F[
            ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[2",
        """
        Expected a comma between the two bounds, but the text ends.
          F[2
             ^
          hint: an interval has two bounds, as in F[0,5]
        """,
    ),
    (
        "F[2]A",
        """
        Expected a comma between the two bounds, but found `]`.
          F[2]A
             ^
          hint: an interval has two bounds, as in F[0,5]
        """,
    ),
    (
        "F[2 3] A",
        """
        Expected a comma between the two bounds, but found `3`.
          F[2 3] A
              ^
          hint: an interval has two bounds, as in F[0,5]
        """,
    ),
    (
        "F[2,",
        """
        Expected a number, but the text ends.
          F[2,
              ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[,2] A",
        """
        Expected a number, but found `,`.
          F[,2] A
            ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[a,b] C",
        """
        Expected a number, but found `a`.
          F[a,b] C
            ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[0,5",
        """
        Expected `]` or `)` to end the interval, but the text ends.
          F[0,5
               ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[0,5 A",
        """
        Expected `]` or `)` to end the interval, but found `A`.
          F[0,5 A
                ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[0,5} A",
        """
        The sign `}` has no meaning in a formula.
          F[0,5} A
               ^
          hint: group with ( and )
        """,
    ),
    (
        "F_[A] B",
        """
        Expected a number, but found `A`.
          F_[A] B
             ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    (
        "F[0;5] A",
        """
        The sign `;` has no meaning in a formula.
          F[0;5] A
             ^
          hint: join requirements with &; between bounds stands a comma
        """,
    ),
    (
        "F(1/2,3 A",
        """
        Expected `]` or `)` to end the interval, but found `A`.
          F(1/2,3 A
                  ^
          hint: an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)
        """,
    ),
    # Bounds
    (
        "F[3,2] A",
        """
        The interval [3,2] contains no time.
          F[3,2] A
           ^^^^^
          hint: write the smaller bound first
        """,
    ),
    (
        "F(2,2) A",
        """
        The interval (2,2) contains no time.
          F(2,2) A
           ^^^^^
          hint: a bracket `[` or `]` keeps the bound itself, a parenthesis leaves it out
        """,
    ),
    (
        "F[2,2) A",
        """
        The interval [2,2) contains no time.
          F[2,2) A
           ^^^^^
          hint: a bracket `[` or `]` keeps the bound itself, a parenthesis leaves it out
        """,
    ),
    (
        "A U(0,0] B",
        """
        The interval (0,0] contains no time.
          A U(0,0] B
             ^^^^^
          hint: a bracket `[` or `]` keeps the bound itself, a parenthesis leaves it out
        """,
    ),
    (
        "F[0,inf] A",
        """
        No time is infinity itself: an interval without an upper end is open there.
          F[0,inf] A
              ^^^
          hint: write [0,inf)
        """,
    ),
    (
        "F[inf,inf) A",
        """
        An interval begins at a finite time.
          F[inf,inf) A
            ^^^
        """,
    ),
    (
        "F[-1,2] A",
        """
        The bound -1 is negative; time begins at 0.
          F[-1,2] A
            ^^
          hint: bounds are counted from the present instant into the future
        """,
    ),
    (
        "F[0,+2] A",
        """
        `+2` is not a number that a bound can be.
          F[0,+2] A
              ^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    (
        "F[1e400,2] A",
        """
        `1e400` is not a number that a bound can be.
          F[1e400,2] A
            ^^^^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    (
        "F[.5,2] A",
        """
        `.5` is not a number that a bound can be.
          F[.5,2] A
            ^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    (
        "F[5.,6] A",
        """
        `5.` is not a number that a bound can be.
          F[5.,6] A
            ^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    (
        "F[1/2/3,4] A",
        """
        `1/2/3` is not a number that a bound can be.
          F[1/2/3,4] A
            ^^^^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    (
        "F[0,5s] A",
        """
        `5s` is not a number that a bound can be.
          F[0,5s] A
              ^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    (
        "F[1/0,2] A",
        """
        The fraction 1/0 divides by zero.
          F[1/0,2] A
            ^^^
        """,
    ),
    (
        "F[1234567890123456789,2] A",
        """
        The number has more than 18 digits.
          F[1234567890123456789,2] A
            ^^^^^^^^^^^^^^^^^^^
          hint: choose a larger unit of time
        """,
    ),
    (
        "F[0,0.1234567890123456789] A",
        """
        The number has more than 18 digits.
          F[0,0.1234567890123456789] A
              ^^^^^^^^^^^^^^^^^^^^^
          hint: choose a larger unit of time
        """,
    ),
    (
        "F[9eeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeee,2] A",
        """
        `9eeeeeeeeeeeeeeeeeeeeeeeeee...` is not a number that a bound can be.
          F[9eeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeeee,2] A
            ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
          hint: write an integer 5, a decimal 2.5, a fraction 7/2, or inf
        """,
    ),
    # Signs that have no meaning
    (
        "A = B",
        """
        The sign `=` has no meaning in a formula.
          A = B
            ^
          hint: write -> for implies and <-> for if and only if
        """,
    ),
    (
        "A => B",
        """
        The sign `=` has no meaning in a formula.
          A => B
            ^
          hint: write -> for implies and <-> for if and only if
        """,
    ),
    (
        "A - B",
        """
        The sign `-` has no meaning in a formula.
          A - B
            ^
          hint: write -> for implies; a name has no hyphen, use an underscore
        """,
    ),
    (
        "A-B",
        """
        The sign `-` has no meaning in a formula.
          A-B
           ^
          hint: write -> for implies; a name has no hyphen, use an underscore
        """,
    ),
    (
        "A < B",
        """
        The sign `<` has no meaning in a formula.
          A < B
            ^
          hint: write <-> for if and only if; a bound is written F[0,5]
        """,
    ),
    (
        "A > B",
        """
        The sign `>` has no meaning in a formula.
          A > B
            ^
          hint: write -> for implies; a bound is written F[0,5]
        """,
    ),
    (
        "A / B",
        """
        The sign `/` has no meaning in a formula.
          A / B
            ^
          hint: write & for and
        """,
    ),
    (
        "A \\/ B",
        """
        The sign `\\` has no meaning in a formula.
          A \\/ B
            ^
          hint: write | for or
        """,
    ),
    (
        "A ^ B",
        """
        The sign `^` has no meaning in a formula.
          A ^ B
            ^
          hint: write & for and
        """,
    ),
    (
        "A + B",
        """
        The sign `+` has no meaning in a formula.
          A + B
            ^
          hint: write | for or
        """,
    ),
    (
        "A * B",
        """
        The sign `*` has no meaning in a formula.
          A * B
            ^
          hint: write & for and
        """,
    ),
    (
        "_a",
        """
        The sign `_` has no meaning in a formula.
          _a
          ^
          hint: a name begins with a letter
        """,
    ),
    (
        "'A'",
        """
        The sign `'` has no meaning in a formula.
          'A'
          ^
          hint: names stand without quotation marks
        """,
    ),
    (
        '"A"',
        """
        The sign `"` has no meaning in a formula.
          "A"
          ^
          hint: names stand without quotation marks
        """,
    ),
    (
        "{A}",
        """
        The sign `{` has no meaning in a formula.
          {A}
          ^
          hint: group with ( and )
        """,
    ),
    (
        "A }",
        """
        The sign `}` has no meaning in a formula.
          A }
            ^
          hint: group with ( and )
        """,
    ),
    (
        "A; B",
        """
        The sign `;` has no meaning in a formula.
          A; B
           ^
          hint: join requirements with &; between bounds stands a comma
        """,
    ),
    (
        "A @ B",
        """
        The sign `@` has no meaning in a formula.
          A @ B
            ^
        """,
    ),
    (
        "A \x00 B",
        """
        The sign U+0000 has no meaning in a formula.
          A   B
            ^
        """,
    ),
    (
        "A %",
        """
        The sign `%` has no meaning in a formula.
          A %
            ^
        """,
    ),
    # Exact instants
    (
        "G F[2,2] A",
        f"""
        `F[2,2]` {AGAIN}
          G F[2,2] A
            ^^^^^^
          hint: allow a little time: F[2,2.1] A
        """,
    ),
    (
        "G X A",
        f"""
        `X` {AGAIN}
          G X A
            ^
          hint: allow a little time: F[1,1.1] A
        """,
    ),
    (
        "G X(A & B)",
        f"""
        `X` {AGAIN}
          G X(A & B)
            ^
          hint: allow a little time: F[1,1.1](A & B)
        """,
    ),
    (
        "G[2,3] G[7/2,7/2] A",
        f"""
        `G[7/2,7/2]` {AGAIN}
          G[2,3] G[7/2,7/2] A
                 ^^^^^^^^^^
          hint: allow a little time: G[7/2,18/5] A
        """,
    ),
    (
        "G(A U[2,2] B)",
        f"""
        `U[2,2]` {AGAIN}
          G(A U[2,2] B)
              ^^^^^^
          hint: allow a little time: U[2,2.1]
        """,
    ),
    (
        "G(A R_[1, 1] B)",
        f"""
        `R[1,1]` {AGAIN}
          G(A R_[1, 1] B)
              ^^^^^^^^
          hint: allow a little time: R[1,1.1]
        """,
    ),
    (
        "A W F[2.5,2.5] B",
        f"""
        `F[5/2,5/2]` {AGAIN}
          A W F[2.5,2.5] B
              ^^^^^^^^^^
          hint: allow a little time: F[5/2,13/5] B
        """,
    ),
    (
        "!F X A",
        f"""
        `X` {AGAIN}
          !F X A
             ^
          hint: allow a little time: F[1,1.1] A
        """,
    ),
    (
        "G ◇_[2,2] " + "b" * 60,
        f"""
        `F[2,2]` {AGAIN}
          G ◇_[2,2] {"b" * 52}...
            ^^^^^^^
          hint: allow a little time: F[2,2.1] ...
        """,
    ),
    # Size
    (
        "!" * 101 + "A",
        """
        The formula is nested more than 100 levels deep.
          ...!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!!A
                                                                         ^
          hint: write it as several requirements, or as one long & or | without parentheses
        """,
    ),
    (
        "A & " * 60_000 + "A",
        f"""
        The formula has 240001 characters; the most that are read is 200000.
          ...{"A & " * 30}...
                                                                         ^
          hint: name the cells together as one region and use its name
        """,
    ),
]


@pytest.mark.parametrize(("text", "message"), CASES)
def test_messages(text: str, message: str) -> None:
    with pytest.raises(FormulaError) as refusal:
        parse(text)
    assert str(refusal.value).rstrip() == dedent(message).strip()
