"""The expressions and declarations inside a UPPAAL model: words, and trees of them.

Only the shape is known here; what a name stands for is decided by :mod:`mitlplan.formats.uppaal_read`. The
text is untrusted: nesting is limited, and every complaint knows its line.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar, Union

from mitlplan.errors import ModelError

DEEPEST = 50
MOST_DIGITS = 9
MOST_WORDS = 1_000_000

_WORDS = re.compile(
    r"(?P<space>\s+|//[^\n]*|/\*.*?\*/)"
    r"|(?P<unclosed>/\*)"
    r"|(?P<query>E<>)"
    r"|(?P<number>\d+)"
    r"|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<sign>:=|\+\+|--|\+=|-=|\*=|&&|\|\||<=|>=|==|!=|[-+*/%<>=!?()\[\]{},;:.'|&])",
    re.ASCII | re.DOTALL,
)
_SPELLINGS = {"and": "&&", "or": "||", "not": "!"}


@dataclass(frozen=True, slots=True)
class Word:
    """A number, a name or a sign, with its line."""

    kind: str
    text: str
    line: int


@dataclass(frozen=True, slots=True)
class Place:
    """Where a text stands: for messages."""

    file: str
    line: int
    element: str

    def complain(self, problem: str, line: int | None = None) -> ModelError:
        """The error to raise."""
        return ModelError(problem, file=self.file, line=line or self.line, element=self.element)


@dataclass(frozen=True, slots=True)
class Constant:
    """A number."""

    value: int


@dataclass(frozen=True, slots=True)
class Name:
    """``x``, ``x[i]``, ``P.x`` or ``x'`` (a rate)."""

    parts: tuple[str, ...]
    index: Tree | None = None
    rate: bool = False

    def __str__(self) -> str:
        return ".".join(self.parts)


@dataclass(frozen=True, slots=True)
class Operation:
    """An operator with one operand or two; ``&&`` and ``||`` may have more."""

    operator: str
    operands: tuple[Tree, ...]


Tree: TypeAlias = Union[Constant, Name, Operation]

Item = TypeVar("Item")

_LEVELS: tuple[tuple[str, ...], ...] = (
    ("||",),
    ("&&",),
    ("==", "!="),
    ("<", "<=", ">", ">="),
    ("+", "-"),
    ("*", "/", "%"),
)
"""Binary operators, loosest first."""

_LONG = _LEVELS[:2]
"""Those with any number of operands."""


def words_of(text: str, place: Place) -> list[Word]:
    """The words of `text`, without spaces and comments.

    Raises
    ------
    ModelError
        At a character that belongs to no word, and if there are more than :data:`MOST_WORDS`.
    """
    words: list[Word] = []
    at, line = 0, place.line
    while at < len(text):
        match = _WORDS.match(text, at)
        if match is None:
            raise place.complain(f"{text[at]!r} is not understood here", line)
        kind = str(match.lastgroup)
        if kind == "unclosed":
            raise place.complain("the comment that begins here does not end", line)
        if kind == "number" and len(match[0]) > MOST_DIGITS:
            raise place.complain(f"the number {match[0][:20]} is too large", line)
        if kind != "space":
            if len(words) == MOST_WORDS:
                raise place.complain(f"more than {MOST_WORDS} words in one text are not read", line)
            spelled = _SPELLINGS.get(match[0], match[0])
            words.append(Word("sign" if spelled != match[0] else kind, spelled, line))
        line += match[0].count("\n")
        at = match.end()
    return words


class Reader:
    """Goes through words, one construct after the other."""

    def __init__(self, text: str, place: Place) -> None:
        self.place = place
        self._words = words_of(text, place)
        self._at = 0
        self._depth = 0

    @property
    def line(self) -> int:
        """The line of the next word."""
        if self._at < len(self._words):
            return self._words[self._at].line
        return self._words[-1].line if self._words else self.place.line

    @property
    def done(self) -> bool:
        """Whether all words have been read."""
        return self._at == len(self._words)

    @property
    def ahead(self) -> str:
        """The next word, or the empty string."""
        return "" if self.done else self._words[self._at].text

    def complain(self, problem: str) -> ModelError:
        """The error to raise at the next word."""
        return self.place.complain(problem, self.line)

    def next_is(self, *texts: str) -> bool:
        """Whether the next word is one of `texts`."""
        return not self.done and self._words[self._at].text in texts

    def take(self, *texts: str) -> bool:
        """Read the next word if it is one of `texts`."""
        if self.next_is(*texts):
            self._at += 1
            return True
        return False

    def expect(self, text: str) -> None:
        """Read `text`, or complain."""
        if not self.take(text):
            found = "the end" if self.done else f"'{self._words[self._at].text}'"
            raise self.complain(f"'{text}' was expected, not {found}")

    def word(self) -> str:
        """Read any word."""
        if self.done:
            raise self.complain("something is missing at the end")
        self._at += 1
        return self._words[self._at - 1].text

    def name(self) -> str:
        """Read a name, or complain."""
        if self.done or self._words[self._at].kind != "name":
            found = "the end" if self.done else f"'{self._words[self._at].text}'"
            raise self.complain(f"a name was expected, not {found}")
        return self.word()

    def separated(self, item: Callable[[], Item], separator: str = ",") -> list[Item]:
        """One or more items with `separator` between them."""
        items = [item()]
        while self.take(separator):
            items.append(item())
        return items

    def finish(self) -> None:
        """Complain if anything is left."""
        if not self.done:
            raise self.complain(f"'{self._words[self._at].text}' was not expected here")

    def expression(self) -> Tree:
        """Read an expression."""
        return self._binary(0)

    def _binary(self, level: int) -> Tree:
        if level == len(_LEVELS):
            return self._unary()
        left = self._binary(level + 1)
        if _LEVELS[level] in _LONG:
            operands = [left]
            while self.take(*_LEVELS[level]):
                operands.append(self._binary(level + 1))
            return left if len(operands) == 1 else Operation(_LEVELS[level][0], tuple(operands))
        count = 0
        while self.next_is(*_LEVELS[level]):
            count += 1
            if count > DEEPEST:
                raise self.complain(f"an expression with more than {DEEPEST} operators in a row is not read")
            left = Operation(self.word(), (left, self._binary(level + 1)))
        return left

    def _unary(self) -> Tree:
        self._depth += 1
        if self._depth > DEEPEST:
            raise self.complain(f"an expression nested more than {DEEPEST} deep is not read")
        try:
            if self.next_is("!", "-", "+"):
                operator = self.word()
                return Operation(f"{operator}1", (self._unary(),))
            if self.take("("):
                inner = self.expression()
                self.expect(")")
                return inner
            return self._primary()
        finally:
            self._depth -= 1

    def _primary(self) -> Tree:
        if not self.done and self._words[self._at].kind == "number":
            return Constant(int(self.word()))
        if self.next_is("true", "false"):
            return Constant(int(self.word() == "true"))
        return self.reference()

    def reference(self) -> Name:
        """Read ``x``, ``x[i]``, ``P.x`` or ``x'``."""
        parts = [self.name()]
        while self.take("."):
            parts.append(self.name())
        index = None
        if self.take("["):
            index = self.expression()
            self.expect("]")
        if self.next_is("["):
            raise self.complain("an array of arrays is not read")
        if self.next_is("("):
            raise self.complain(f"the function {parts[-1]} is not read; only what the network itself does is")
        return Name(tuple(parts), index, self.take("'"))


def conjuncts(tree: Tree) -> Sequence[Tree]:
    """The parts of a conjunction."""
    found: list[Tree] = []
    waiting = [tree]
    while waiting:
        part = waiting.pop()
        if isinstance(part, Operation) and part.operator == "&&":
            waiting.extend(reversed(part.operands))
        else:
            found.append(part)
    return found
