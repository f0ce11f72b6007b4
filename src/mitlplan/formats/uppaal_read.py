"""Reading UPPAAL models: the subset that networks such as ours are made of.

Templates without parameters or with integer ones, clocks and arrays of them, bounded integers, guards,
invariants, rates 0 and 1, resets, binary and broadcast channels, urgent and committed locations, and ``E<>``
queries over locations and bounds (:mod:`mitlplan.formats.uppaal_query`). Anything else is an error that names
element and line: a model is never read as something that it is not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from mitlplan.automata.timed_automaton import Automaton, Network
from mitlplan.errors import ModelError
from mitlplan.formats.uppaal_declarations import MOST_NAMES, UNBOUNDED, Declarations, constant
from mitlplan.formats.uppaal_process import read_process
from mitlplan.formats.uppaal_scope import Scope, TypeName
from mitlplan.formats.uppaal_syntax import Place, Reader
from mitlplan.formats.uppaal_tree import MOST_ELEMENTS, Node, parse_xml, place_of


@dataclass(frozen=True, slots=True)
class UppaalModel:
    """What was read.

    Parameters
    ----------
    network
        Times are the model's time units. Local names are those of the instance and the template, joined by
        an underscore.
    queries
        The texts of the queries in the file; :func:`read_query` makes sense of one.
    """

    network: Network
    queries: tuple[str, ...]
    scope: Scope
    file: str


def read_uppaal(text: bytes, *, file: str = "") -> UppaalModel:
    """Read a UPPAAL model.

    Parameters
    ----------
    text
        The contents of the file.
    file
        Its name, for messages.

    Raises
    ------
    ModelError
        If it is no such model, or uses what is outside the subset: with line and element.

    Examples
    --------
    >>> model = read_uppaal(b'''<nta><declaration>clock x;</declaration>
    ... <template><name>P</name><location id="a"><name>A</name></location><init ref="a"/></template>
    ... <system>system P;</system></nta>''')
    >>> [location.name for location in model.network.automata[0].locations]
    ['A']
    """
    return _Model(parse_xml(text, file), file).read()


@dataclass(frozen=True, slots=True)
class _Template:
    node: Node
    parameters: tuple[tuple[str, TypeName | None], ...]


class _Model:
    def __init__(self, root: Node, file: str) -> None:
        self._root = root
        self._file = file
        self._scope = Scope()
        self._declarations = Declarations()
        self._templates: dict[str, _Template] = {}

    def read(self) -> UppaalModel:
        for unread in ("imports", "lsc", "dynamic"):
            if (node := self._root.first(unread)) is not None:
                raise self._place(node, unread).complain(f"{unread} is not read")
        self._declare(self._root, self._scope, "")
        for node in self._root.all("template"):
            self._template(node)
        automata = tuple(self._system())
        try:
            declared = self._declarations
            clocks, channels = tuple(declared.clocks), tuple(declared.channels)
            network = Network(automata, clocks, channels, tuple(declared.variables))
        except ValueError as error:
            raise ModelError(str(error), file=self._file) from None
        return UppaalModel(network, tuple(self._queries()), self._scope, self._file)

    def _place(self, node: Node, element: str) -> Place:
        return place_of(node, element, self._file)

    def _queries(self) -> Iterator[str]:
        queries = self._root.first("queries")
        for query in queries.all("query") if queries else ():
            formula = query.first("formula")
            if formula is not None and formula.text.strip():
                yield formula.text.strip()

    def _declare(self, parent: Node, scope: Scope, process: str) -> None:
        node = parent.first("declaration")
        if node is not None:
            element = f"declaration of {process}" if process else "declaration"
            self._declarations.read(node.text, self._place(node, element), scope, process)

    def _template(self, node: Node) -> None:
        name_node = node.first("name")
        name = name_node.text.strip() if name_node else ""
        place = self._place(node, f"template {name}")
        if not name:
            raise place.complain("a template without a name is not read")
        if name in self._templates:
            raise place.complain(f"two templates are called {name}")
        if node.first("branchpoint") is not None:
            raise place.complain("branch points are not read")
        self._templates[name] = _Template(node, tuple(self._parameters(node, name)))

    def _parameters(self, node: Node, name: str) -> Iterator[tuple[str, TypeName | None]]:
        parameter = node.first("parameter")
        if parameter is None or not parameter.text.strip():
            return
        reader = Reader(parameter.text, self._place(parameter, f"parameter of {name}"))
        while True:
            reader.take("const")
            if not self._declarations.kind_follows(reader, self._scope):
                raise reader.complain("only integer parameters are read")
            kind = self._declarations.kind(reader, self._scope)
            if reader.take("&"):
                raise reader.complain("parameters by reference are not read")
            yield reader.name(), None if kind == UNBOUNDED else kind
            if not reader.take(","):
                break
        reader.finish()

    def _system(self) -> Iterator[Automaton]:
        instances: dict[str, tuple[str, tuple[int, ...]]] = {}
        for node in (self._root.first("instantiation"), self._root.first("system")):
            if node is None:
                continue
            reader = Reader(node.text, self._place(node, node.name))
            while not reader.done:
                if reader.take("system"):
                    chosen = reader.separated(reader.name)
                    reader.expect(";")
                    reader.finish()
                    yield from self._processes(reader, chosen, instances)
                    return
                self._instance(reader, instances)
        raise ModelError("there is no system line: which templates run is not said", file=self._file)

    def _instance(self, reader: Reader, instances: dict[str, tuple[str, tuple[int, ...]]]) -> None:
        """``P1 = P(1, 2);`` or a declaration."""
        if reader.next_is("const", "clock", "int", "bool", "chan", "broadcast", "urgent", "typedef"):
            self._declarations.declaration(reader, self._scope)
            return
        name = reader.name()
        if not reader.take("=", ":="):
            raise reader.complain(f"{name} is not read here; 'P = Template(1);' and 'system P;' are")
        template = reader.name()
        if template not in self._templates:
            raise reader.complain(f"there is no template {template}")
        values: list[int] = []
        reader.expect("(")
        if not reader.next_is(")"):
            values = reader.separated(lambda: constant(reader, self._scope))
        reader.expect(")")
        reader.expect(";")
        if len(values) != len(self._templates[template].parameters):
            wanted = len(self._templates[template].parameters)
            raise reader.complain(f"{template} has {wanted} parameters, not {len(values)}")
        if name in instances or name in self._templates:
            raise reader.complain(f"{name} is declared twice")
        instances[name] = (template, tuple(values))

    def _processes(
        self, reader: Reader, chosen: Sequence[str], instances: Mapping[str, tuple[str, tuple[int, ...]]]
    ) -> Iterator[Automaton]:
        made = 0
        for name in chosen:
            if name in instances:
                template, values = instances[name]
                every = [(name, values)]
            elif name in self._templates:
                template = name
                every = list(self._unbound(reader, name))
            else:
                raise reader.complain(f"there is no template or process {name}")
            made += len(every) * len(self._templates[template].node.children)
            if made > MOST_ELEMENTS:
                raise reader.complain(
                    f"the processes have more than {MOST_ELEMENTS} locations and transitions together, "
                    "which is not read"
                )
            for process, values in every:
                node = self._templates[template].node
                scope = self._process_scope(self._templates[template], process, values)
                yield read_process(node, process, scope, self._file)

    def _unbound(self, reader: Reader, name: str) -> Iterator[tuple[str, tuple[int, ...]]]:
        """A template with ranges as parameters stands for all its instances."""
        ranges = []
        for parameter, kind in self._templates[name].parameters:
            if kind is None:
                raise reader.complain(f"the parameter {parameter} of {name} has no value and no range")
            ranges.append(range(kind.least, kind.most + 1))
        if prod(len(values) for values in ranges) > MOST_NAMES:
            raise reader.complain(f"more than {MOST_NAMES} processes are not read")
        for values in product(*ranges):
            yield "_".join([name, *(str(value).replace("-", "m") for value in values)]), values

    def _process_scope(self, template: _Template, process: str, values: Sequence[int]) -> Scope:
        """The scope of one process, with its parameters and its own declarations."""
        scope = Scope(self._scope)
        for (name, _), value in zip(template.parameters, values, strict=True):
            scope.names[name] = value
        self._declare(template.node, scope, process)
        self._scope.processes[process] = scope
        return scope
