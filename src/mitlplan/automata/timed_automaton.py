"""Timed automata and their networks, in the vocabulary that UPPAAL and TChecker share.

A timed automaton is a graph with clocks that run at rate 1, or stand still in the locations that stop them.
An invariant must hold while time passes in a location, a guard when an edge is taken; an edge may reset
clocks. Automata of a network move alone or in pairs over a channel (``ch!`` with ``ch?``), a broadcast takes
along everyone who can receive it, and they share bounded integers. No time passes in an urgent location; a
committed one must be left before anything else happens (Bengtsson and Yi 2004, "Timed automata: semantics,
algorithms and tools"). This is what goes out to other tools and what is read back; the planner itself
searches :mod:`mitlplan.automata.transducer`. Constants are seconds, exact; :func:`ticks_per_second` is the
factor that makes them integers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from math import lcm
from typing import TypeAlias, Union

from mitlplan.automata.transducer import Constraint, Guard, Relation


class Urgency(Enum):
    """Whether time may pass in a location."""

    NORMAL = "normal"
    URGENT = "urgent"
    COMMITTED = "committed"


@dataclass(frozen=True, slots=True)
class Location:
    """A location.

    Parameters
    ----------
    invariant
        Holds as long as the automaton is here.
    stopped
        The clocks whose rate is 0 here (UPPAAL: ``x' == 0``).
    running
        Clocks whose rate 1 is written out (``x' == 1``): it says nothing new, but the paper writes it.
    """

    name: str
    invariant: Guard = ()
    stopped: frozenset[str] = frozenset()
    running: frozenset[str] = frozenset()
    urgency: Urgency = Urgency.NORMAL


@dataclass(frozen=True, slots=True)
class Number:
    """A constant integer."""

    value: int


@dataclass(frozen=True, slots=True)
class Variable:
    """The present value of an integer variable."""

    name: str


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """``left + right``, ``left - right`` or ``left * right``."""

    operator: str
    left: Expression
    right: Expression

    def __post_init__(self) -> None:
        if self.operator not in {"+", "-", "*"}:
            raise ValueError(f"{self.operator} is no operator of integer arithmetic")


Expression: TypeAlias = Union[Number, Variable, Arithmetic]


@dataclass(frozen=True, slots=True)
class Test:
    """A comparison of integers, part of a guard."""

    left: Expression
    comparison: str
    right: Expression

    # Not a test case, whatever pytest makes of the name.
    __test__ = False

    def __post_init__(self) -> None:
        if self.comparison not in {"==", "!=", "<", "<=", ">", ">="}:
            raise ValueError(f"{self.comparison} is no comparison")


@dataclass(frozen=True, slots=True)
class Assignment:
    """``variable = value``, part of an update."""

    variable: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Synchronisation:
    """One side of a communication: ``channel!`` sends, ``channel?`` receives."""

    channel: str
    sends: bool

    def __str__(self) -> str:
        return f"{self.channel}{'!' if self.sends else '?'}"


@dataclass(frozen=True, slots=True)
class Edge:
    """A move from the location with index `source` to that with index `target`.

    Parameters
    ----------
    guard, tests
        Conditions on clocks and on integers; all must hold.
    resets
        Clocks set to 0.
    assignments
        Done in order, those of the sender before those of a receiver.
    synchronisation
        ``None`` for a move of this automaton alone.
    """

    source: int
    target: int
    guard: Guard = ()
    resets: frozenset[str] = frozenset()
    synchronisation: Synchronisation | None = None
    tests: tuple[Test, ...] = ()
    assignments: tuple[Assignment, ...] = ()


@dataclass(frozen=True, slots=True)
class Automaton:
    """One component.

    Raises
    ------
    ValueError
        If an edge or the initial location points nowhere, or two locations share a name.
    """

    name: str
    locations: tuple[Location, ...]
    edges: tuple[Edge, ...]
    initial: int = 0

    def __post_init__(self) -> None:
        count = len(self.locations)
        ends = [self.initial, *(edge.source for edge in self.edges), *(edge.target for edge in self.edges)]
        if not all(0 <= end < count for end in ends):
            raise ValueError(f"{self.name}: an edge or the start points outside the {count} locations")
        if len({location.name for location in self.locations}) < count:
            raise ValueError(f"{self.name}: two locations have the same name")

    def index(self, name: str) -> int:
        """The index of the location called `name`; :class:`KeyError` if there is none."""
        for index, location in enumerate(self.locations):
            if location.name == name:
                return index
        raise KeyError(name)


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel; a broadcast never blocks its sender."""

    name: str
    broadcast: bool = False


@dataclass(frozen=True, slots=True)
class BoundedInteger:
    """An integer variable with values from `least` to `most`."""

    name: str
    least: int = 0
    most: int = 1
    initial: int = 0

    def __post_init__(self) -> None:
        if not self.least <= self.initial <= self.most:
            raise ValueError(f"{self.name} begins with {self.initial}, outside [{self.least},{self.most}]")


@dataclass(frozen=True, slots=True)
class Network:
    """Automata that run side by side.

    Parameters
    ----------
    automata
        With different names.
    clocks
        All start at 0. Every clock, channel and variable that is used must be declared.

    Raises
    ------
    ValueError
        If something is used that is not declared, or is declared twice.

    Examples
    --------
    >>> walk = Automaton("robot", (Location("here"), Location("there")),
    ...     (Edge(0, 1, guard=(Constraint("z", Relation.AT_LEAST, Fraction(1)),)),))
    >>> Network((walk,), clocks=("z",)).automata[0].index("there")
    1
    """

    automata: tuple[Automaton, ...]
    clocks: tuple[str, ...] = ()
    channels: tuple[Channel, ...] = ()
    variables: tuple[BoundedInteger, ...] = ()

    def __post_init__(self) -> None:
        for kind, names in (
            ("automaton", [automaton.name for automaton in self.automata]),
            ("clock", list(self.clocks)),
            ("channel", [channel.name for channel in self.channels]),
            ("variable", [variable.name for variable in self.variables]),
        ):
            if len(set(names)) < len(names):
                raise ValueError(f"the network declares one {kind} twice: {', '.join(sorted(names))}")
        declared = {
            "clock": frozenset(self.clocks),
            "channel": frozenset(channel.name for channel in self.channels),
            "variable": frozenset(variable.name for variable in self.variables),
        }
        for automaton in self.automata:
            for kind, name in _names_used(automaton):
                if name not in declared[kind]:
                    raise ValueError(f"{automaton.name} uses the {kind} {name}, which is not declared")

    def automaton(self, name: str) -> int:
        """The index of the automaton called `name`; :class:`KeyError` if there is none."""
        for index, automaton in enumerate(self.automata):
            if automaton.name == name:
                return index
        raise KeyError(name)


def _names_used(automaton: Automaton) -> Iterator[tuple[str, str]]:
    for location in automaton.locations:
        yield from (("clock", constraint.clock) for constraint in location.invariant)
        yield from (("clock", clock) for clock in location.stopped | location.running)
    for edge in automaton.edges:
        yield from (("clock", constraint.clock) for constraint in edge.guard)
        yield from (("clock", clock) for clock in edge.resets)
        if edge.synchronisation is not None:
            yield "channel", edge.synchronisation.channel
        for test in edge.tests:
            yield from (("variable", name) for name in variables_of(test.left))
            yield from (("variable", name) for name in variables_of(test.right))
        for assignment in edge.assignments:
            yield "variable", assignment.variable
            yield from (("variable", name) for name in variables_of(assignment.value))


def variables_of(expression: Expression) -> Iterator[str]:
    """The variables that `expression` reads."""
    match expression:
        case Number():
            return
        case Variable(name):
            yield name
        case Arithmetic(_, left, right):
            yield from variables_of(left)
            yield from variables_of(right)


def value_of(expression: Expression, values: Mapping[str, int]) -> int:
    """The value of `expression` where the variables have `values`.

    Examples
    --------
    >>> value_of(Arithmetic("+", Variable("n"), Number(1)), {"n": 4})
    5
    """
    match expression:
        case Number(value):
            return value
        case Variable(name):
            return values[name]
        case Arithmetic(operator, left, right):
            one, other = value_of(left, values), value_of(right, values)
            if operator == "*":
                return one * other
            return one + other if operator == "+" else one - other


def holds(test: Test, values: Mapping[str, int]) -> bool:
    """Whether `test` holds where the variables have `values`."""
    left, right = value_of(test.left, values), value_of(test.right, values)
    match test.comparison:
        case "==":
            return left == right
        case "!=":
            return left != right
        case "<":
            return left < right
        case "<=":
            return left <= right
        case ">":
            return left > right
        case _:
            return left >= right


@dataclass(frozen=True, slots=True)
class Target:
    """A set of states: every named automaton in its location, clocks and integers as they must be."""

    locations: Mapping[str, str] = field(default_factory=dict)
    guard: Guard = ()
    tests: tuple[Test, ...] = ()


@dataclass(frozen=True, slots=True)
class Query:
    """Whether one of the targets can be reached (``E<> a or b``), and how early.

    Parameters
    ----------
    clock
        ``None``, or a clock whose infimum over the targets is asked for (UPPAAL: ``inf{a}: t``).
    """

    targets: tuple[Target, ...]
    clock: str | None = None


def exactly(clock: str, bound: Fraction) -> Guard:
    """The guard ``clock == bound``."""
    return (Constraint(clock, Relation.AT_LEAST, bound), Constraint(clock, Relation.AT_MOST, bound))


def ticks_per_second(network: Network, query: Query | None = None) -> int:
    """The least factor that makes every constant of the network, and of the query, an integer.

    Examples
    --------
    >>> late = (Constraint("z", Relation.AT_LEAST, Fraction(5, 2)),)
    >>> ticks_per_second(Network((Automaton("a", (Location("l", late),), ()),), clocks=("z",)))
    2
    """
    guards = [location.invariant for automaton in network.automata for location in automaton.locations]
    guards += [edge.guard for automaton in network.automata for edge in automaton.edges]
    guards += [target.guard for target in query.targets] if query is not None else []
    return lcm(*(constraint.bound.denominator for guard in guards for constraint in guard))
