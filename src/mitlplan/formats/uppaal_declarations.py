"""Declarations of a UPPAAL model: clocks, channels, integers, constants and ranges."""

from __future__ import annotations

from dataclasses import replace

from mitlplan.automata.timed_automaton import BoundedInteger, Channel
from mitlplan.formats.uppaal_scope import (
    ArrayName,
    ClockName,
    IntegerName,
    Make,
    Meaning,
    Scope,
    TypeName,
    View,
)
from mitlplan.formats.uppaal_syntax import Place, Reader

MOST_NAMES = 100_000
"""Clocks, channels and integers, with all elements of arrays; and processs of templates."""

UNBOUNDED = TypeName(-32768, 32767)
"""What ``int`` is in UPPAAL."""


class Declarations:
    """Everything declared so far, for the network; names go into the scopes."""

    def __init__(self) -> None:
        self.clocks: list[str] = []
        self.channels: list[Channel] = []
        self.variables: list[BoundedInteger] = []

    def read(self, text: str, place: Place, scope: Scope, process: str = "") -> None:
        """Read declarations; those of a process get full names that begin with its name."""
        reader = Reader(text, place)
        while not reader.done:
            self.declaration(reader, scope, process)

    def declaration(self, reader: Reader, scope: Scope, process: str = "") -> None:
        """Read one declaration, up to its semicolon."""
        if reader.take("typedef"):
            kind = self.kind(reader, scope)
            self._define(reader, scope, reader.name(), kind)
        elif reader.take("const"):
            self.kind(reader, scope)
            reader.separated(lambda: self._constant_value(reader, scope))
        elif reader.take("clock"):
            reader.separated(lambda: self._declared(reader, scope, process, self._new_clock))
        elif reader.next_is("chan", "broadcast", "urgent"):
            self._channel_declaration(reader, scope, process)
        elif self.kind_follows(reader, scope):
            self._integer_declaration(reader, scope, process)
        else:
            raise reader.complain(f"'{reader.word()}' is not read; only clocks, channels and integers are")
        reader.expect(";")

    def kind_follows(self, reader: Reader, scope: Scope) -> bool:
        """Whether the next word begins the type of an integer."""
        return reader.next_is("int", "bool") or isinstance(scope.find(reader.ahead), TypeName)

    def kind(self, reader: Reader, scope: Scope) -> TypeName:
        """``int``, ``int[a,b]``, ``bool`` or a name for one of them."""
        if reader.take("bool"):
            return TypeName(0, 1)
        if not reader.take("int"):
            kind = scope.find(reader.ahead)
            if not isinstance(kind, TypeName):
                raise reader.complain("the type of an integer was expected")
            reader.word()
            return kind
        if not reader.take("["):
            return UNBOUNDED
        least = constant(reader, scope)
        reader.expect(",")
        most = constant(reader, scope)
        reader.expect("]")
        return TypeName(least, most)

    def _define(self, reader: Reader, scope: Scope, name: str, meaning: Meaning) -> None:
        if name in scope.names:
            raise reader.complain(f"{name} is declared twice")
        scope.names[name] = meaning

    def _constant_value(self, reader: Reader, scope: Scope) -> None:
        name = reader.name()
        reader.expect("=")
        self._define(reader, scope, name, constant(reader, scope))

    def _declared(self, reader: Reader, scope: Scope, process: str, make: Make) -> None:
        """One name, or an array of them; `make` turns the full name into what it means."""
        name = reader.name()
        full = f"{process}_{name}" if process else name
        if not reader.take("["):
            self._checked(reader, 1)
            self._define(reader, scope, name, make(full))
            return
        size = constant(reader, scope)
        reader.expect("]")
        if reader.next_is("["):
            raise reader.complain("an array of arrays is not read")
        if size < 1:
            raise reader.complain(f"an array of {size} elements is not read")
        self._checked(reader, size)
        elements = tuple(make(f"{full}[{index}]") for index in range(size))
        self._define(reader, scope, name, ArrayName(elements))

    def _checked(self, reader: Reader, more: int) -> None:
        if len(self.clocks) + len(self.channels) + len(self.variables) + more > MOST_NAMES:
            raise reader.complain(f"more than {MOST_NAMES} clocks, channels and integers are not read")

    def _new_clock(self, name: str) -> ClockName:
        self.clocks.append(name)
        return ClockName(name)

    def _channel_declaration(self, reader: Reader, scope: Scope, process: str) -> None:
        broadcast = reader.take("broadcast")
        if reader.next_is("urgent"):
            raise reader.complain("urgent channels are not read")
        broadcast = reader.take("broadcast") or broadcast
        reader.expect("chan")

        def make(name: str) -> Channel:
            channel = Channel(name, broadcast)
            self.channels.append(channel)
            return channel

        reader.separated(lambda: self._declared(reader, scope, process, make))

    def _integer_declaration(self, reader: Reader, scope: Scope, process: str) -> None:
        kind = self.kind(reader, scope)
        least, most = kind.least, kind.most
        if least > most:
            raise reader.complain(f"no integer lies in [{least},{most}]")

        def make(name: str) -> IntegerName:
            initial = 0 if least <= 0 <= most else least
            self.variables.append(BoundedInteger(name, least, most, initial))
            return IntegerName(name)

        def one() -> None:
            count = len(self.variables)
            self._declared(reader, scope, process, make)
            if reader.take("="):
                if len(self.variables) != count + 1:
                    raise reader.complain("initial values of an array are not read")
                initial = constant(reader, scope)
                if not least <= initial <= most:
                    raise reader.complain(f"the initial value {initial} lies outside [{least},{most}]")
                self.variables[-1] = replace(self.variables[-1], initial=initial)

        reader.separated(one)


def constant(reader: Reader, scope: Scope) -> int:
    """Read an expression without variables."""
    return View(scope, reader.place).constant(reader.expression(), reader.line)
