"""One process of a UPPAAL model: a template with values for its parameters."""

from __future__ import annotations

from dataclasses import replace

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    Channel,
    Edge,
    Expression,
    Location,
    Number,
    Synchronisation,
    Test,
    Urgency,
    Variable,
)
from mitlplan.automata.transducer import Constraint
from mitlplan.formats.uppaal_declarations import constant
from mitlplan.formats.uppaal_scope import ClockName, IntegerName, Scope, View
from mitlplan.formats.uppaal_syntax import Name, Operation, Place, Reader, Tree, conjuncts
from mitlplan.formats.uppaal_tree import Node, place_of


def read_process(node: Node, name: str, scope: Scope, file: str) -> Automaton:
    """The automaton of the process `name`.

    Parameters
    ----------
    node
        The template.
    scope
        What its names mean, parameters and own declarations included.
    file
        For messages.
    """
    return _Process(node, name, scope, file).read()


class _Process:
    def __init__(self, node: Node, name: str, scope: Scope, file: str) -> None:
        self._node = node
        self._name = name
        self._scope = scope
        self._file = file
        self._index: dict[str, int] = {}
        self._shown: list[str] = []

    def read(self) -> Automaton:
        locations = tuple(self._location(node) for node in self._node.all("location"))
        place = self._place(self._node, f"template {self._name}")
        initial = self._node.first("init")
        if initial is None or initial.attributes.get("ref") not in self._index:
            raise place.complain("there is no initial location")
        edges = tuple(self._edge(node) for node in self._node.all("transition"))
        try:
            return Automaton(self._name, locations, edges, self._index[initial.attributes["ref"]])
        except ValueError as error:
            raise place.complain(str(error)) from None

    def _location(self, node: Node) -> Location:
        identity = node.attributes.get("id", "")
        name_node = node.first("name")
        name = (name_node.text.strip() if name_node else "") or identity
        place = self._place(node, f"location {self._name}.{name}")
        if not identity or identity in self._index:
            raise place.complain("every location needs an id of its own")
        self._index[identity] = len(self._index)
        self._shown.append(name)
        location = Location(name)
        for label in node.all("label"):
            kind = label.attributes.get("kind", "")
            if kind == "invariant":
                location = self._invariant(location, label)
            elif kind not in {"comments", "testcodeEnter", "testcodeExit"} and label.text.strip():
                raise self._place(label, place.element).complain(f"a label of kind {kind} is not read")
        if node.first("committed") is not None:
            return replace(location, urgency=Urgency.COMMITTED)
        return replace(location, urgency=Urgency.URGENT) if node.first("urgent") is not None else location

    def _invariant(self, location: Location, label: Node) -> Location:
        place = self._place(label, f"invariant of {self._name}.{location.name}")
        if not label.text.strip():
            return location
        reader = Reader(label.text, place)
        tree = reader.expression()
        reader.finish()
        view = View(self._scope, place)
        constraints: list[Constraint] = []
        rates: dict[str, int] = {}
        for part in conjuncts(tree):
            rate = self._rate(part, view)
            if rate is not None:
                rates[rate[0]] = rate[1]
                continue
            clocks, tests = view.condition(part)
            if tests:
                raise place.complain("an invariant over integers is not read")
            constraints += clocks
        return replace(
            location,
            invariant=tuple(constraints),
            stopped=frozenset(clock for clock, rate in rates.items() if rate == 0),
            running=frozenset(clock for clock, rate in rates.items() if rate == 1),
        )

    def _rate(self, part: Tree, view: View) -> tuple[str, int] | None:
        match part:
            case Operation("==", (Name(rate=True) as name, value)):
                pass
            case Operation("==", (value, Name(rate=True) as name)):
                pass
            case _:
                return None
        clock, rate = view.meaning(replace(name, rate=False)), view.constant(value)
        if not isinstance(clock, ClockName) or rate not in (0, 1):
            raise view.place.complain("only clocks have rates, and only the rates 0 and 1 are read")
        return clock.name, rate

    def _edge(self, node: Node) -> Edge:
        edge = Edge(self._end(node, "source"), self._end(node, "target"))
        shown = f"{self._shown[edge.source]} -> {self._shown[edge.target]}"
        for label in node.all("label"):
            kind = label.attributes.get("kind", "")
            place = self._place(label, f"{kind} of {self._name}: {shown}")
            if not label.text.strip() or kind in {"comments", "testcode"}:
                continue
            reader = Reader(label.text, place)
            if kind == "guard":
                edge = self._guarded(edge, reader)
            elif kind == "synchronisation":
                edge = replace(edge, synchronisation=self._synchronisation(reader))
            elif kind == "assignment":
                edge = self._updated(edge, reader)
            else:
                raise place.complain(f"a label of kind {kind} is not read")
            reader.finish()
        return edge

    def _end(self, node: Node, kind: str) -> int:
        end = node.first(kind)
        index = self._index.get(end.attributes.get("ref", "")) if end is not None else None
        if index is None:
            place = self._place(node, f"transition in {self._name}")
            raise place.complain(f"the {kind} is no location of the template")
        return index

    def _guarded(self, edge: Edge, reader: Reader) -> Edge:
        guard: list[Constraint] = []
        tests: list[Test] = []
        for part in conjuncts(reader.expression()):
            clocks, integers = View(self._scope, reader.place).condition(part)
            guard += clocks
            tests += integers
        return replace(edge, guard=tuple(guard), tests=tuple(tests))

    def _synchronisation(self, reader: Reader) -> Synchronisation:
        name = reader.reference()
        channel = View(self._scope, reader.place).meaning(name, reader.line)
        if not isinstance(channel, Channel):
            raise reader.complain(f"{name} is no channel")
        if reader.take("!"):
            return Synchronisation(channel.name, sends=True)
        reader.expect("?")
        return Synchronisation(channel.name, sends=False)

    def _updated(self, edge: Edge, reader: Reader) -> Edge:
        resets: set[str] = set()
        assignments: list[Assignment] = []
        while True:
            name = reader.reference()
            meaning = View(self._scope, reader.place).meaning(name, reader.line)
            match meaning:
                case ClockName(clock):
                    if not reader.take("=", ":="):
                        raise reader.complain("a clock can only be reset to 0")
                    if constant(reader, self._scope) != 0:
                        raise reader.complain("a clock can only be reset to 0")
                    resets.add(clock)
                case IntegerName(variable):
                    assignments.append(Assignment(variable, self._assigned(reader, variable)))
                case _:
                    raise reader.complain(f"{name} cannot be assigned to")
            if not reader.take(","):
                return replace(edge, resets=frozenset(resets), assignments=tuple(assignments))

    def _assigned(self, reader: Reader, variable: str) -> Expression:
        for sign, operator in (("++", "+"), ("--", "-")):
            if reader.take(sign):
                return Arithmetic(operator, Variable(variable), Number(1))
        for sign in ("+=", "-=", "*="):
            if reader.take(sign):
                value = View(self._scope, reader.place).integer(reader.expression(), reader.line)
                return Arithmetic(sign[0], Variable(variable), value)
        if not reader.take("=", ":="):
            raise reader.complain("'=' was expected")
        return View(self._scope, reader.place).integer(reader.expression(), reader.line)

    def _place(self, node: Node, element: str) -> Place:
        return place_of(node, element, self._file)
