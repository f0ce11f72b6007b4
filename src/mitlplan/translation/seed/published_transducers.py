"""The elementary transducers as Zhou, Maity and Baras published them (their Figs. 4 to 6).

UNSOUND, kept for comparison with the paper: plans made with these may violate the formula, and plans that
satisfy it may be missed. docs/paper.md tells what is wrong with which line; the repaired transducers are in
:mod:`mitlplan.translation.seed.exact_transducers`. Every transducer but those of the timed eventually has a
clock z with ``z>0 | z:=0`` on every edge: no two changes at one instant. The until is the closed one.

The timed eventually F_[a,b] guesses its output with a generator and verifies the guess with a checker. For
m = ceil(b/(b-a)) + 1 the i-th rising edge of the guess resets y_i and the i-th falling edge x_i, cyclically,
and the checker waits until y_i = b for the input to rise and until x_{i+1} = a for it to fall; shorter gaps
are allowed up to b-a, measured by z. The published program differs from the paper in three details
(:class:`Flavour`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from math import ceil
from typing import TypeAlias

from mitlplan.automata.iota import Iota, IotaEdge, IotaLocation, Letter
from mitlplan.automata.transducer import Constraint, Guard, Relation

Clocks: TypeAlias = Iterator[str]
"""Names of fresh clocks."""


class Flavour(Enum):
    """The construction as the paper describes it, or as its published program builds it.

    The program lets a gap last b-a (the paper: less), does not reset z when the checker begins with a gap,
    and lets the guess fall only when it has been true for b-a, even where it began at time 0.
    """

    PAPER = "paper"
    PROGRAM = "program"


_LETTERS: frozenset[Letter] = frozenset({(True,), (False,)})
_NOTHING_READ: frozenset[Letter] = frozenset({()})


def _location(name: str, letters: str, writes: bool, invariant: Guard = ()) -> IotaLocation:
    """A location that reads the given letters, written as in the paper: ``10 11``."""
    reads = frozenset(tuple(bit == "1" for bit in letter) for letter in letters.split())
    return IotaLocation(name, reads, writes, invariant)


def _hurried(pairs: list[tuple[int, int]], clock: str) -> tuple[IotaEdge, ...]:
    """Edges that all have the guard ``z>0`` and the reset ``z:=0``."""
    later = (Constraint(clock, Relation.GREATER, Fraction(0)),)
    return tuple(IotaEdge(source, target, later, frozenset({clock})) for source, target in pairs)


def constant(value: bool) -> Iota:
    """``true`` or ``false``: one location, no input."""
    location = IotaLocation("T" if value else "F", _NOTHING_READ, value)
    return Iota((), (location,), (), frozenset({0}))


def atom(name: str, clocks: Clocks) -> Iota:
    """A proposition: the output is the input."""
    z = next(clocks)
    locations = (_location(f"p({name})", "1", True), _location(f"!p({name})", "0", False))
    return Iota((name,), locations, _hurried([(0, 1), (1, 0)], z), frozenset({0, 1}), (z,))


def negation(clocks: Clocks) -> Iota:
    """``!p``."""
    z = next(clocks)
    locations = (_location("p", "1", False), _location("!p", "0", True))
    return Iota(("p",), locations, _hurried([(0, 1), (1, 0)], z), frozenset({0, 1}), (z,))


def conjunction(clocks: Clocks) -> Iota:
    """``p & q``."""
    z = next(clocks)
    locations = (_location("and", "11", True), _location("!and", "10 01 00", False))
    return Iota(("p", "q"), locations, _hurried([(0, 1), (1, 0)], z), frozenset({0, 1}), (z,))


def disjunction(clocks: Clocks) -> Iota:
    """``p | q``."""
    z = next(clocks)
    locations = (_location("!or", "00", False), _location("or", "10 01 11", True))
    return Iota(("p", "q"), locations, _hurried([(0, 1), (1, 0)], z), frozenset({0, 1}), (z,))


_UNTIL_EDGES = [(0, 1), (1, 0), (0, 2), (0, 3), (3, 0), (2, 3), (3, 2), (3, 1)]
"""What is missing is forbidden: the promises in 1 (never) and 2 (some time) are kept."""


def until(clocks: Clocks) -> Iota:
    """``p U q``, closed (Fig. 4): while p holds without q, the run promises that q comes, or never does."""
    z = next(clocks)
    locations = (
        _location("!p", "01 00", False),
        _location("!(p!q)", "10", False),
        _location("p!q", "10", True),
        _location("pq", "11", True),
    )
    edges = _hurried(_UNTIL_EDGES, z)
    return Iota(("p", "q"), locations, edges, frozenset(range(4)), (z,), (frozenset({0, 1, 3}),))


def release(clocks: Clocks) -> Iota:
    """``p R q``, the dual of the closed until."""
    z = next(clocks)
    locations = (
        _location("p", "10 11", True),
        _location("!(!pq)", "01", True),
        _location("!pq", "01", False),
        _location("!p!q", "00", False),
    )
    edges = _hurried(_UNTIL_EDGES, z)
    return Iota(("p", "q"), locations, edges, frozenset(range(4)), (z,), (frozenset({0, 1, 3}),))


@dataclass(frozen=True, slots=True)
class TimedEventually:
    """A timed eventually F_[least,most] and its clocks: of rising and of falling edges, and of a gap."""

    least: Fraction
    most: Fraction
    rising: tuple[str, ...]
    falling: tuple[str, ...]
    gap: str

    @property
    def pairs(self) -> int:
        """The number m of edge pairs that are remembered."""
        return len(self.rising)

    @property
    def all(self) -> tuple[str, ...]:
        """Every clock: x_1, y_1, ..., x_m, y_m, z."""
        pairs = zip(self.falling, self.rising, strict=True)
        return (*(clock for pair in pairs for clock in pair), self.gap)


def timed_eventually(least: Fraction, most: Fraction, clocks: Clocks) -> TimedEventually:
    """F_[least,most] with its 2m+1 clocks, in the order x_1, y_1, ..., x_m, y_m, z."""
    count = ceil(most / (most - least)) + 1
    both = [next(clocks) for _ in range(2 * count)]
    return TimedEventually(least, most, rising=tuple(both[1::2]), falling=tuple(both[0::2]), gap=next(clocks))


def generator(operator: TimedEventually, flavour: Flavour) -> Iota:
    """The generator (Fig. 5): it guesses the output, and resets a clock at each edge of the guess.

    In ``Gen0``, before the guess has begun, all clocks are stopped, and nothing forces the run to leave.
    """
    length = operator.most - operator.least
    locations: list[IotaLocation] = []
    edges: list[IotaEdge] = []
    for pair, (x, y) in enumerate(zip(operator.falling, operator.rising, strict=True)):
        following = (pair + 1) % operator.pairs
        low, high = 2 * pair, 2 * pair + 1
        long = (Constraint(y, Relation.AT_LEAST, length),) if flavour is Flavour.PROGRAM else ()
        locations.append(IotaLocation(f"Gen_{low + 1}", _NOTHING_READ, False, running=frozenset({x})))
        locations.append(IotaLocation(f"Gen_{high + 1}", _NOTHING_READ, True, running=frozenset({y})))
        edges.append(IotaEdge(low, high, resets=frozenset({y})))
        edges.append(IotaEdge(high, 2 * following, long, frozenset({operator.falling[following]})))
    start = len(locations)
    guessed = operator.all[:-1]
    locations.append(IotaLocation("Gen0", _NOTHING_READ, None, stopped=frozenset(guessed)))
    edges.append(IotaEdge(start, 0, resets=frozenset({operator.falling[0]})))
    edges.append(IotaEdge(start, 1, resets=frozenset({operator.rising[0]})))
    return Iota((), tuple(locations), tuple(edges), frozenset({start}), guessed)


def checker(operator: TimedEventually, flavour: Flavour, verified: str) -> Iota:
    """The checker (Fig. 6): it compares the input with the guess.

    Parameters
    ----------
    verified
        The event announced when the first falling edge has been verified (the paper's ``ch!``).
    """
    locations: list[IotaLocation] = []
    edges: list[IotaEdge] = []
    for pair in range(operator.pairs):
        locations += _checker_round(operator, flavour, pair)
        announced = frozenset({verified}) if pair == 0 else frozenset[str]()
        edges += _checker_round_edges(operator, pair, announced)
    locations += _checker_starts(operator)
    edges += _checker_start_edges(operator, flavour)
    start = 3 * operator.pairs
    return Iota(("p",), tuple(locations), tuple(edges), frozenset({start, start + 1}), operator.all)


def _next_fall(operator: TimedEventually, pair: int) -> str:
    return operator.falling[(pair + 1) % operator.pairs]


def _checker_round(operator: TimedEventually, flavour: Flavour, pair: int) -> list[IotaLocation]:
    """Waiting for the input to rise; the input true; a gap."""
    length = operator.most - operator.least
    rise = Constraint(operator.rising[pair], Relation.AT_MOST, operator.most)
    fall = Constraint(_next_fall(operator, pair), Relation.AT_MOST, operator.least)
    relation = Relation.LESS if flavour is Flavour.PAPER else Relation.AT_MOST
    short = Constraint(operator.gap, relation, length)
    return [
        IotaLocation(f"CHK_{3 * pair + 1}", frozenset({(False,)}), None, (rise,)),
        IotaLocation(f"CHK_{3 * pair + 2}", frozenset({(True,)}), None, (fall,)),
        IotaLocation(f"CHK_{3 * pair + 3}", frozenset({(False,)}), None, (fall, short)),
    ]


def _checker_round_edges(operator: TimedEventually, pair: int, announced: frozenset[str]) -> list[IotaEdge]:
    low, high, gap = 3 * pair, 3 * pair + 1, 3 * pair + 2
    rises = (Constraint(operator.rising[pair], Relation.AT_LEAST, operator.most),)
    falls = (Constraint(_next_fall(operator, pair), Relation.AT_LEAST, operator.least),)
    return [
        IotaEdge(low, high, rises),
        IotaEdge(high, 3 * ((pair + 1) % operator.pairs), falls, events=announced),
        IotaEdge(high, gap, resets=frozenset({operator.gap})),
        IotaEdge(gap, high),
    ]


def _checker_starts(operator: TimedEventually) -> list[IotaLocation]:
    """Where the checker waits until the first edge of the guess is `least` old."""
    first = (("CHK00", operator.falling[0]), ("CHK01", operator.rising[0]))
    return [
        IotaLocation(name, _LETTERS, None, (Constraint(clock, Relation.AT_MOST, operator.least),))
        for name, clock in first
    ]


def _checker_start_edges(operator: TimedEventually, flavour: Flavour) -> list[IotaEdge]:
    false_first, true_first = 3 * operator.pairs, 3 * operator.pairs + 1
    fallen = (Constraint(operator.falling[0], Relation.AT_LEAST, operator.least),)
    risen = (Constraint(operator.rising[0], Relation.AT_LEAST, operator.least),)
    reset = frozenset({operator.gap}) if flavour is Flavour.PAPER else frozenset[str]()
    return [
        IotaEdge(false_first, 0, fallen),
        IotaEdge(true_first, 1, risen),
        IotaEdge(true_first, 2, risen, reset),
    ]
