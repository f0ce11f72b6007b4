"""Reading a formula from text.

lark's LALR parser, which keeps its own stack, makes a tree of the text; the tree's depth is checked before
anything recursive looks at it, so no input overflows the stack. What the grammar cannot say is checked next,
each with its place in the text: intervals that contain no time, numbers that are none, and punctual
intervals outside a one-shot position (:mod:`mitlplan.logic.one_shot`).
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, TypeAlias, cast

from mitlplan.errors import FormulaError
from mitlplan.logic.formula import (
    MOST_LEVELS,
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
from mitlplan.logic.interval import ALWAYS, Interval
from mitlplan.logic.one_shot import refuse_repeated_instants

if TYPE_CHECKING:
    from lark import Lark, Token, Tree, UnexpectedToken

    _Tree: TypeAlias = Tree[Token]

MOST_CHARACTERS = 200_000
MOST_DIGITS = 18


def parse(text: str) -> Formula:
    """Read a formula.

    Parameters
    ----------
    text
        A formula in the grammar of the semantics page; bounds are exact numbers of seconds.

    Returns
    -------
    Formula
        The formula as it was written: ``->`` stays an implication.

    Raises
    ------
    FormulaError
        If the text is no formula, or asks for what no timed automaton can do; the message shows the place.

    Examples
    --------
    >>> parse("!A U B")
    Until(left=Not(operand=Atom(name='A')), right=Atom(name='B'), interval=Interval(lower=Fraction(0, 1), \
upper=None, lower_open=False, upper_open=True))
    >>> parse("!A U (B")
    Traceback (most recent call last):
    mitlplan.errors.FormulaError: Expected an operator or `)`, but the text ends.
      !A U (B
             ^
      hint: the `(` at character 6 is not closed
    """
    tree = _tree(text)
    _refuse_deep(tree, text)
    reader = _Reader(text)
    formula = reader.formula(tree)
    refuse_repeated_instants(formula, text, lambda node: reader.places[id(node)])
    return formula


@cache
def _parser() -> Lark:
    # lark is imported with the first formula, not with the package: the command line answers at once.
    from lark import Lark

    grammar = resources.files("mitlplan.logic").joinpath("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="basic", maybe_placeholders=True, propagate_positions=True)


def _tree(text: str) -> _Tree:
    from lark import UnexpectedCharacters, UnexpectedToken

    if not text.strip():
        raise FormulaError("The formula is empty.", text, 0)
    if len(text) > MOST_CHARACTERS:
        raise FormulaError(
            f"The formula has {len(text)} characters; the most that are read is {MOST_CHARACTERS}.",
            text,
            MOST_CHARACTERS,
            hint="name the cells together as one region and use its name",
        )
    try:
        return _parser().parse(text)
    except UnexpectedCharacters as error:
        raise _unexpected_character(text, cast("int", error.pos_in_stream)) from None
    except UnexpectedToken as error:
        raise _unexpected_word(text, error) from None


def _refuse_deep(tree: _Tree, text: str) -> None:
    pending = [(tree, 1)]
    while pending:
        node, depth = pending.pop()
        if depth > MOST_LEVELS:
            raise FormulaError(
                f"The formula is nested more than {MOST_LEVELS} levels deep.",
                text,
                node.meta.start_pos,
                hint="write it as several requirements, or as one long & or | without parentheses",
            )
        pending += [(child, depth + 1) for child in _subtrees(node)]


def _subtrees(tree: _Tree) -> list[_Tree]:
    from lark import Tree

    return [child for child in tree.children if isinstance(child, Tree)]


# --------------------------------------------------------------------------------------- from tree to formula


@dataclass(frozen=True, slots=True)
class _Reader:
    """Makes the formula and remembers where in the text each temporal operator stands."""

    text: str
    places: dict[int, tuple[int, int]] = field(default_factory=dict)

    def formula(self, tree: _Tree) -> Formula:
        match tree.data:
            case "true" | "false":
                return Constant(tree.data == "true")
            case "atom":
                return Atom(str(tree.children[0]))
            case "eventually" | "always" | "next" | "until" | "release" | "weak_until":
                return self._temporal(tree)
            case "negation":
                return Not(*self._operands(tree))
            case "conjunction":
                return And(tuple(self._operands(tree)))
            case "disjunction":
                return Or(tuple(self._operands(tree)))
            case "implies":
                return Implies(*self._operands(tree))
            case "iff":
                return Iff(*self._operands(tree))
            case rule:
                raise AssertionError(f"the grammar has a rule {rule} that nothing reads")

    def _operands(self, tree: _Tree) -> list[Formula]:
        return [self.formula(child) for child in _subtrees(tree) if child.data != "interval"]

    def _temporal(self, tree: _Tree) -> Formula:
        interval = ALWAYS
        operator = next(child for child in tree.children if isinstance(child, str))
        start, end = cast("int", operator.start_pos), cast("int", operator.end_pos)
        for child in _subtrees(tree):
            if child.data == "interval":
                interval, end = self._interval(child), child.meta.end_pos
        node = _operator(str(tree.data), self._operands(tree), interval)
        self.places[id(node)] = (start, end)
        return node

    def _interval(self, tree: _Tree) -> Interval:
        start, end = tree.meta.start_pos, tree.meta.end_pos
        lower_bound, upper_bound = (cast("Token", child) for child in tree.children)
        lower, upper = self._bound(lower_bound), self._bound(upper_bound)
        lower_open, upper_open = self.text[start] == "(", self.text[end - 1] == ")"
        if lower is None:
            raise self._error("An interval begins at a finite time.", lower_bound)
        if upper is None and not upper_open:
            raise self._error(
                "No time is infinity itself: an interval without an upper end is open there.",
                upper_bound,
                hint=f"write {_shortened(self.text[start : end - 1])})",
            )
        if upper is not None and (upper < lower or (upper == lower and (lower_open or upper_open))):
            raise FormulaError(
                f"The interval {_shortened(self.text[start:end])} contains no time.",
                self.text,
                start,
                length=end - start,
                hint="write the smaller bound first"
                if upper < lower
                else "a bracket `[` or `]` keeps the bound itself, a parenthesis leaves it out",
            )
        return Interval(lower, upper, lower_open, upper_open)

    def _bound(self, token: Token) -> Fraction | None:
        if token.type == "INF":
            return None
        if token.startswith("-"):
            raise self._error(
                f"The bound {_shortened(token)} is negative; time begins at 0.",
                token,
                hint="bounds are counted from the present instant into the future",
            )
        if not re.fullmatch(r"[0-9]+(\.[0-9]+|/[0-9]+)?", token):
            raise self._error(
                f"`{_shortened(token)}` is not a number that a bound can be.",
                token,
                hint="write an integer 5, a decimal 2.5, a fraction 7/2, or inf",
            )
        if sum(map(str.isdigit, token)) > MOST_DIGITS:
            raise self._error(
                f"The number has more than {MOST_DIGITS} digits.", token, hint="choose a larger unit of time"
            )
        try:
            return Fraction(token)
        except ZeroDivisionError:
            raise self._error(f"The fraction {token} divides by zero.", token) from None

    def _error(self, problem: str, token: Token, hint: str = "") -> FormulaError:
        start, end = cast("int", token.start_pos), cast("int", token.end_pos)
        return FormulaError(problem, self.text, start, length=end - start, hint=hint)


def _operator(rule: str, operands: list[Formula], interval: Interval) -> Formula:
    left, right = operands[0], operands[-1]
    match rule:
        case "eventually":
            return Eventually(right, interval)
        case "always":
            return Always(right, interval)
        case "next":
            return Next(right)
        case "until":
            return Until(left, right, interval)
        case "release":
            return Release(left, right, interval)
        case _:
            return WeakUntil(left, right)


# ------------------------------------------------------------------------ what the grammar expected, in words

_FOREIGN_SIGNS = {
    "=": "write -> for implies and <-> for if and only if",
    "-": "write -> for implies; a name has no hyphen, use an underscore",
    "<": "write <-> for if and only if; a bound is written F[0,5]",
    ">": "write -> for implies; a bound is written F[0,5]",
    "/": "write & for and",
    "\\": "write | for or",
    "^": "write & for and",
    "+": "write | for or",
    "*": "write & for and",
    "_": "a name begins with a letter",
    "'": "names stand without quotation marks",
    '"': "names stand without quotation marks",
    "{": "group with ( and )",
    "}": "group with ( and )",
    ";": "join requirements with &; between bounds stands a comma",
}

_MOST_SHOWN = 30
_NO_NAMES = "the single letters F G U R W X V are operators, not names"
# From the beginning of a word only, or the search would look at a long one again from each of its letters.
_WORD_BEFORE = re.compile(r"(?<![\w.])([^\W\d_][\w.]*)\s*\Z")
_UNDERSCORED_OPERATOR = re.compile(r"[FGURWXV]_")
_GLUED_OPERATORS = re.compile(r"[FGXURWV]{2,}_?")
_CAPITAL_WORDS = re.compile(r"and|or|not", re.IGNORECASE)


def _unexpected_character(text: str, position: int) -> FormulaError:
    sign = text[position]
    name = f"`{sign}`" if sign.isprintable() else f"U+{ord(sign):04X}"
    return FormulaError(
        f"The sign {name} has no meaning in a formula.", text, position, hint=_FOREIGN_SIGNS.get(sign, "")
    )


def _unexpected_word(text: str, error: UnexpectedToken) -> FormulaError:
    ended = error.token.type == "$END"
    position = len(text) if ended else cast("int", error.token.start_pos)
    word = "" if ended else str(error.token)
    accepted: set[str] = error.interactive_parser.accepts()  # type: ignore[no-untyped-call]
    found = "the text ends" if ended else f"found `{_shortened(word)}`"
    return FormulaError(
        f"Expected {_expectation(accepted)}, but {found}.",
        text,
        position,
        length=max(1, len(word)),
        hint=_hint(text[:position], word, accepted),
    )


def _expectation(accepted: Collection[str]) -> str:
    if "_LSQB" in accepted:
        return "a formula or an interval"
    if "NAME" in accepted:
        return "a formula"
    if "NUMBER" in accepted:
        return "a number"
    if "_COMMA" in accepted:
        return "a comma between the two bounds"
    if "_RSQB" in accepted:
        return "`]` or `)` to end the interval"
    if "_RPAR" in accepted:
        return "an operator or `)`"
    return "an operator or the end of the formula"


def _hint(before: str, word: str, accepted: Collection[str]) -> str:
    preceding = _WORD_BEFORE.search(before)
    last = preceding.group(1) if preceding else ""
    if "_COMMA" in accepted:
        return "an interval has two bounds, as in F[0,5]"
    if "NAME" in accepted:
        return _hint_for_a_formula(last, word)
    if "_RSQB" in accepted or "NUMBER" in accepted:
        return "an interval has two numbers as bounds, as in F[0,5] or F(1/2,inf)"
    if _UNDERSCORED_OPERATOR.fullmatch(last):
        return "after an operator an underscore begins an interval, as in F_[0,5]"
    if _GLUED_OPERATORS.fullmatch(last):
        return f"put a space between operators: {' '.join(last.rstrip('_'))}"
    for capital in (word, last):
        if _CAPITAL_WORDS.fullmatch(capital) and not capital.islower():
            return f"write `{capital.lower()}`, in small letters"
    if not word and "_RPAR" in accepted:
        return f"the `(` at character {_open_parenthesis(before) + 1} is not closed"
    if word == ")":
        return "there is no `(` for it"
    if word == "[":
        return "an interval follows F, G, U or R"
    return "join two formulas with an operator such as & or U"


def _hint_for_a_formula(last: str, word: str) -> str:
    if last in ("W", "X") and word == "[":
        return f"{last} takes no interval"
    if word[:1].isdigit():
        return "numbers stand in intervals only; a name begins with a letter"
    if word in ("U", "R", "V", "W"):
        return f"{word} stands between two formulas; {_NO_NAMES}"
    if not word and last in tuple("FGURWXV"):
        return _NO_NAMES
    return ""


def _open_parenthesis(text: str) -> int:
    closed = 0
    for position in range(len(text) - 1, -1, -1):
        if text[position] == ")":
            closed += 1
        elif text[position] == "(":
            if closed == 0:
                return position
            closed -= 1
    return 0


def _shortened(word: str) -> str:
    return word if len(word) <= _MOST_SHOWN else word[: _MOST_SHOWN - 3] + "..."
