"""Queries of UPPAAL: what is to be reached."""

from __future__ import annotations

from mitlplan.automata.timed_automaton import Query, Target
from mitlplan.formats.uppaal_read import UppaalModel
from mitlplan.formats.uppaal_scope import ClockName, View
from mitlplan.formats.uppaal_syntax import Name, Operation, Place, Reader, Tree

MOST_TARGETS = 10_000
_TOO_MANY = f"the query has too many cases; at most {MOST_TARGETS} are read"


def read_query(text: str, model: UppaalModel) -> Query:
    """What ``E<> ...`` or ``inf{...}: clock`` asks.

    Raises
    ------
    ModelError
        If it is another kind of query, or speaks of what the model does not have.

    Examples
    --------
    >>> from mitlplan.formats.uppaal_read import read_uppaal
    >>> model = read_uppaal(b'''<nta><declaration>clock x;</declaration>
    ... <template><name>P</name><location id="a"><name>A</name></location><init ref="a"/></template>
    ... <system>system P;</system></nta>''')
    >>> dict(read_query("E<> P.A and x <= 3", model).targets[0].locations)
    {'P': 'A'}
    """
    shown = text if len(text) < 80 else f"{text[:77]}..."
    reader = Reader(text, Place(model.file, 1, f"query {shown}"))
    view = View(model.scope, reader.place, from_query=True)
    if reader.take("inf"):
        reader.expect("{")
        tree = reader.expression()
        reader.expect("}")
        reader.expect(":")
        found = view.meaning(reader.reference())
        reader.finish()
        if not isinstance(found, ClockName):
            raise reader.place.complain("inf{...}: is asked for the least value of a clock")
        return Query(tuple(_targets(tree, model, view)), found.name)
    if not reader.take("E<>"):
        raise reader.place.complain("only 'E<> ...' and 'inf{...}: clock' are read")
    tree = reader.expression()
    reader.finish()
    return Query(tuple(_targets(tree, model, view)))


def _targets(tree: Tree, model: UppaalModel, view: View) -> list[Target]:
    """The disjunctive normal form."""
    match tree:
        case Operation("||", operands):
            cases = [target for operand in operands for target in _targets(operand, model, view)]
            if len(cases) > MOST_TARGETS:
                raise view.place.complain(_TOO_MANY)
            return cases
        case Operation("&&", operands):
            result = [Target()]
            for operand in operands:
                parts = _targets(operand, model, view)
                if len(result) * len(parts) > MOST_TARGETS:
                    raise view.place.complain(_TOO_MANY)
                pairs = (_joined(one, other) for one in result for other in parts)
                result = [both for both in pairs if both is not None]
            return result
        case Name(parts) if len(parts) == 2 and _is_location(parts, model):
            return [Target({parts[0]: parts[1]})]
        case Operation("!1", (Name(parts),)) if len(parts) == 2:
            raise view.place.complain("'not' is not read in a query")
        case _:
            guard, tests = view.condition(tree)
            return [Target(guard=tuple(guard), tests=tuple(tests))]


def _joined(one: Target, other: Target) -> Target | None:
    """Both at once, or ``None`` if an automaton would have to be in two places."""
    if any(other.locations.get(name, at) != at for name, at in one.locations.items()):
        return None
    return Target({**one.locations, **other.locations}, one.guard + other.guard, one.tests + other.tests)


def _is_location(parts: tuple[str, ...], model: UppaalModel) -> bool:
    return any(
        automaton.name == parts[0] and any(location.name == parts[1] for location in automaton.locations)
        for automaton in model.network.automata
    )
