"""What the names in a UPPAAL model stand for, and what expressions over them mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias, Union

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Channel,
    Expression,
    Number,
    Test,
    Variable,
    value_of,
)
from mitlplan.automata.transducer import Constraint, Relation
from mitlplan.formats.uppaal_syntax import Constant, Name, Operation, Place, Tree

GREATEST = 10**9
"""Of the numbers that constants come to."""

_MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


@dataclass(frozen=True, slots=True)
class ClockName:
    """A clock, by its name in the network."""

    name: str


@dataclass(frozen=True, slots=True)
class IntegerName:
    """An integer variable, by its name in the network."""

    name: str


@dataclass(frozen=True, slots=True)
class TypeName:
    """A range of integers."""

    least: int
    most: int


@dataclass(frozen=True, slots=True)
class ArrayName:
    """The elements of an array."""

    elements: tuple[Element, ...]


Element: TypeAlias = Union[ClockName, IntegerName, Channel]
Meaning: TypeAlias = Union[Element, ArrayName, TypeName, int]
"""What a name may stand for; a number is a constant."""


@dataclass(slots=True)
class Scope:
    """What names mean. The scope of a process lies in that of the model, and is one of its `processes`."""

    outer: Scope | None = None
    names: dict[str, Meaning] = field(default_factory=dict)
    processes: dict[str, Scope] = field(default_factory=dict)

    def find(self, name: str) -> Meaning | None:
        """What `name` means here, or ``None``."""
        if name in self.names or self.outer is None:
            return self.names.get(name)
        return self.outer.find(name)


@dataclass(frozen=True, slots=True)
class View:
    """Names as seen from a text: in a query, ``P.x`` is seen as well."""

    scope: Scope
    place: Place
    from_query: bool = False

    def meaning(self, name: Name, line: int | None = None) -> Meaning:
        """What `name` stands for; of an array, one element."""
        scope, last = self.scope, name.parts[-1]
        if len(name.parts) > 1:
            process = scope.processes.get(name.parts[0]) if self.from_query and len(name.parts) == 2 else None
            if process is None or last not in process.names:
                raise self.place.complain(f"there is no {name}", line)
            scope = process
        meaning = scope.find(last)
        if meaning is None:
            raise self.place.complain(f"{name} is not declared", line)
        if isinstance(meaning, ArrayName):
            return self._element(name, meaning, line)
        if name.index is not None:
            raise self.place.complain(f"{name} is no array", line)
        return meaning

    def _element(self, name: Name, array: ArrayName, line: int | None) -> Element:
        if name.index is None:
            raise self.place.complain(f"{name} is an array; one element was expected", line)
        index = self.constant(name.index, line)
        if not 0 <= index < len(array.elements):
            last = len(array.elements) - 1
            raise self.place.complain(f"{name} has no element {index}, only 0 to {last}", line)
        return array.elements[index]

    def constant(self, tree: Tree, line: int | None = None) -> int:
        """The value of an expression without variables."""
        expression = self.integer(tree, line)
        try:
            return value_of(expression, {})
        except KeyError:
            raise self.place.complain("a constant was expected here, not a variable", line) from None

    def integer(self, tree: Tree, line: int | None = None) -> Expression:
        """An expression over integers."""
        match tree:
            case Constant(value):
                return Number(value)
            case Name():
                meaning = self.meaning(tree, line)
                if isinstance(meaning, int):
                    return Number(meaning)
                if isinstance(meaning, IntegerName):
                    return Variable(meaning.name)
                raise self.place.complain(f"{tree} is no integer", line)
            case Operation("-1", (operand,)):
                return self._simplified("-", Number(0), self.integer(operand, line), line)
            case Operation("+1", (operand,)):
                return self.integer(operand, line)
            case Operation("+" | "-" | "*" as operator, (left, right)):
                return self._simplified(operator, self.integer(left, line), self.integer(right, line), line)
            case Operation(operator):
                raise self.place.complain(f"'{operator[0]}' is not read in an expression over integers", line)

    def _simplified(self, operator: str, left: Expression, right: Expression, line: int | None) -> Expression:
        value = Arithmetic(operator, left, right)
        if not (isinstance(left, Number) and isinstance(right, Number)):
            return value
        number = value_of(value, {})
        if abs(number) > GREATEST:
            raise self.place.complain(f"a number beyond {GREATEST} comes out here, which is not read", line)
        return Number(number)

    def condition(self, part: Tree) -> tuple[list[Constraint], list[Test]]:
        """One conjunct of a guard, as bounds on clocks or as a comparison of integers."""
        match part:
            case Constant(value) if value:
                return [], []
            case Operation("<" | "<=" | ">" | ">=" | "==" | "!=" as sign, (left, right)):
                return self._comparison(sign, left, right)
            case Name():
                return [], [Test(self._flag(part), "!=", Number(0))]
            case Operation("!1", (Name() as name,)):
                return [], [Test(self._flag(name), "==", Number(0))]
            case Operation("||"):
                raise self.place.complain("'||' is not read in a guard; write two edges")
            case _:
                raise self.place.complain("this is no comparison of clocks or integers")

    def _flag(self, name: Name) -> Variable:
        meaning = self.meaning(name)
        if not isinstance(meaning, IntegerName):
            raise self.place.complain(f"{name} is no condition")
        return Variable(meaning.name)

    def _comparison(self, sign: str, left: Tree, right: Tree) -> tuple[list[Constraint], list[Test]]:
        one, other = self._clock(left), self._clock(right)
        if one is not None and other is not None:
            raise self.place.complain("two clocks are compared, which is not read")
        if one is not None:
            return self._bounds(one, sign, self.constant(right)), []
        if other is not None:
            return self._bounds(other, _MIRRORED[sign], self.constant(left)), []
        if self._mentions_clock(left) or self._mentions_clock(right):
            raise self.place.complain("a difference of clocks is not read")
        return [], [Test(self.integer(left), sign, self.integer(right))]

    def _clock(self, tree: Tree) -> str | None:
        if not isinstance(tree, Name) or tree.rate:
            return None
        meaning = self.meaning(tree)
        return meaning.name if isinstance(meaning, ClockName) else None

    def _mentions_clock(self, tree: Tree) -> bool:
        match tree:
            case Name(rate=rate):
                return rate or self._clock(tree) is not None
            case Operation(_, operands):
                return any(self._mentions_clock(operand) for operand in operands)
            case Constant():
                return False

    def _bounds(self, clock: str, sign: str, value: int) -> list[Constraint]:
        if sign == "!=":
            raise self.place.complain("a clock compared by '!=' is not read; write two edges")
        if value < 0:
            raise self.place.complain(f"the clock {clock} is never negative, but compared with {value}")
        signs = [">=", "<="] if sign == "==" else [sign]
        return [Constraint(clock, Relation(each), Fraction(value)) for each in signs]


Make: TypeAlias = Callable[[str], Element]
"""Turns the full name of something declared into what it means."""
