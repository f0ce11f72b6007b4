"""The judge: whether a formula holds on a signal, exactly, straight from its meaning (docs: semantics).

It shares no code with the normal form, the translation and the search, so that a plan is never confirmed by
the error that produced it. Every subformula becomes the set of times at which it *surely* holds, its negation
the set at which it surely fails: one function, :meth:`_Judge.surely`, with the polarity as an argument.

On a signal that repeats the two are complements. On a signal that ends, nothing is known after `end` but what
is true of every label, and truth is strong Kleene's: what surely holds, holds whatever follows. Horizon
"finite" lets a release (so G, W and a negated F or U) that reaches to infinity speak of [0, end] only; seen
from after `end` it must surely hold like everything else, so that ``F G p`` asks for p at the end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce
from math import lcm
from operator import and_, or_
from typing import Literal

from mitlplan.logic.formula import (
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
from mitlplan.logic.interval_set import Axis, IntervalSet, intersection, union
from mitlplan.logic.signal import Signal

_ONE_LATER = Interval(Fraction(1), Fraction(1))

# What is true of every label is found by trying them all: with more atoms than this it counts as unknown.
_MOST_ATOMS = 16


def satisfies(
    formula: Formula,
    signal: Signal,
    *,
    until: Literal["standard", "closed"] = "standard",
    horizon: Literal["infinite", "finite"] = "infinite",
) -> bool:
    """Whether `formula` holds at time 0: on a signal that ends, whatever follows its end.

    Parameters
    ----------
    formula, signal
        Times in seconds.
    until
        ``"closed"``: the left side of an until must still hold at the instant of the right side.
    horizon
        ``"finite"``: operators that hold for ever need hold only until the signal ends.

    Raises
    ------
    ValueError
        If an option is not one of those named, or the horizon is finite and the signal repeats.

    Examples
    --------
    >>> from mitlplan.logic.signal import Segment
    >>> stay, arrive = Segment(Fraction(0), frozenset()), Segment(Fraction(2), frozenset({"dock"}))
    >>> soon = Eventually(Atom("dock"), Interval(Fraction(0), Fraction(2)))
    >>> satisfies(soon, Signal((stay, arrive), end=Fraction(2)))
    True
    >>> satisfies(Not(soon), Signal((stay, arrive), end=Fraction(2)))
    False
    """
    return Fraction(0) in truth(formula, signal, until=until, horizon=horizon)


def truth(
    formula: Formula,
    signal: Signal,
    *,
    until: Literal["standard", "closed"] = "standard",
    horizon: Literal["infinite", "finite"] = "infinite",
) -> IntervalSet:
    """The times at which `formula` holds: on a signal that ends, at which it holds whatever follows.

    Parameters, errors and units are those of :func:`satisfies`.

    Examples
    --------
    >>> from mitlplan.logic.signal import Segment
    >>> visits = Segment(Fraction(0), frozenset()), Segment(Fraction(3), frozenset({"dock"}))
    >>> print(truth(Eventually(Atom("dock"), Interval(Fraction(0), Fraction(1))),
    ...             Signal(visits, end=Fraction(4), repeat_from=Fraction(0))))
    [2,4), and again every 4 from 0 on
    """
    if until not in ("standard", "closed"):
        raise ValueError(f"the until is standard or closed, not {until!r}")
    if horizon not in ("infinite", "finite"):
        raise ValueError(f"the horizon is infinite or finite, not {horizon!r}")
    if horizon == "finite" and signal.repeat_from is not None:
        raise ValueError("a signal that repeats has no end to which a finite horizon could refer")
    return _Judge.of(formula, signal, until == "closed", horizon == "finite").verdict(formula)


@dataclass(frozen=True, slots=True)
class _Judge:
    """What is known of a signal, and how the operators are read.

    `literals` are the times at which an atom is surely true, or surely false; `unknown` those of which
    nothing is known. `memory` goes by identity: comparing large formulas costs more than judging them.
    """

    axis: Axis
    literals: dict[tuple[str, bool], IntervalSet]
    unknown: IntervalSet
    closed_until: bool
    finite_horizon: bool
    memory: dict[tuple[int, bool], IntervalSet] = field(default_factory=dict)

    @classmethod
    def of(cls, formula: Formula, signal: Signal, closed_until: bool, finite_horizon: bool) -> _Judge:
        nodes = [node for node, _ in _uses(formula)]
        axis = _axis(nodes, signal)
        unknown = IntervalSet.nothing(axis)
        if signal.repeat_from is None:
            unknown = IntervalSet(axis, (2 * axis.count(signal.end) + 1, 2 * axis.end))
        literals = {}
        for name, held in _held({node.name for node in nodes if isinstance(node, Atom)}, signal, axis):
            literals[name, True] = held
            literals[name, False] = ~(held | unknown)
        return cls(axis, literals, unknown, closed_until, finite_horizon)

    def verdict(self, formula: Formula) -> IntervalSet:
        """When `formula` surely holds, its parts first: so no depth of nesting overflows the stack."""
        for part, positive in reversed(list(_uses(formula))):
            self.surely(part, positive)
        return self.surely(formula, True)

    def surely(self, formula: Formula, positive: bool) -> IntervalSet:
        """When `formula` (or, if not `positive`, its negation) surely holds."""
        key = id(formula), positive
        if key not in self.memory:
            self.memory[key] = self._evaluated(formula, positive)
        return self.memory[key]

    def _evaluated(self, formula: Formula, positive: bool) -> IntervalSet:
        sides = [self.surely(part, sign) for part, sign in _operands(formula, positive)]
        match formula:
            case Constant(value):
                return self._constant(value is positive)
            case Atom(name):
                return self.literals[name, positive]
            case Not():
                return sides[0]
            case And() | Or() | Implies():
                if _all_needed(formula, positive):
                    return intersection(self.axis, sides)
                return union(self.axis, sides) | self._known_of_every_label(formula, positive)
            case Iff():
                left, right, not_left, not_right = sides
                if not positive:
                    right, not_right = not_right, right
                agreed = (left & right) | (not_left & not_right)
                return agreed | self._known_of_every_label(formula, positive)
            case Next():
                return sides[0].eventually(_ONE_LATER)
            case Eventually(_, interval):
                return self._until(positive, self._constant(positive), sides[0], interval)
            case Always(_, interval):
                return self._until(not positive, self._constant(not positive), sides[0], interval)
            case Until(_, _, interval):
                return self._until(positive, sides[0], sides[1], interval)
            case Release(_, _, interval):
                return self._until(not positive, sides[0], sides[1], interval)
            case WeakUntil():
                ever = self._until(not positive, self._constant(not positive), sides[0], ALWAYS)
                handed = self._until(positive, sides[0], sides[1], ALWAYS)
                return ever | handed if positive else ever & handed

    def _constant(self, value: bool) -> IntervalSet:
        return IntervalSet.everything(self.axis) if value else IntervalSet.nothing(self.axis)

    def _until(
        self, positive: bool, left: IntervalSet, right: IntervalSet, interval: Interval
    ) -> IntervalSet:
        """The until of the sides or, if not `positive`, its dual, the release."""
        if not positive:
            return self._release(left, right, interval)
        return left.until(left & right if self.closed_until else right, interval)

    def _release(self, left: IntervalSet, right: IntervalSet, interval: Interval) -> IntervalSet:
        if self.closed_until:
            right = left | right
        sure = ~(~left).until(~right, interval)
        if not self.finite_horizon or interval.upper is not None:
            return sure
        until_end = ~(~left).until(~(right | self.unknown), interval)
        return sure | (until_end & ~self.unknown)

    def _known_of_every_label(self, formula: Formula, positive: bool) -> IntervalSet:
        """The times after the signal's end, if there some disjuncts hold whatever the label is."""
        if self.unknown and _valid(list(_disjuncts(formula, positive))):
            return self.unknown
        return self._constant(False)


def _operands(formula: Formula, positive: bool) -> tuple[tuple[Formula, bool], ...]:
    """The parts on which `formula` depends, each with the polarity in which it is needed."""
    match formula:
        case Constant() | Atom():
            return ()
        case Not(operand):
            return ((operand, not positive),)
        case And(operands) | Or(operands):
            return tuple((operand, positive) for operand in operands)
        case Implies(left, right):
            return ((left, not positive), (right, positive))
        case Iff(left, right):
            return ((left, True), (right, True), (left, False), (right, False))
        case Eventually(operand) | Always(operand) | Next(operand):
            return ((operand, positive),)
        case Until(left, right) | Release(left, right) | WeakUntil(left, right):
            return ((left, positive), (right, positive))


def _all_needed(formula: Formula, positive: bool) -> bool:
    """Whether a junction, or its negation if not `positive`, needs all its operands rather than one."""
    return isinstance(formula, And) == positive


def _uses(formula: Formula) -> Iterator[tuple[Formula, bool]]:
    """Every part of `formula`, once for each polarity in which it is needed, wholes before their parts."""
    waiting = [(formula, True)]
    seen = set()
    while waiting:
        part, positive = waiting.pop()
        if (id(part), positive) not in seen:
            seen.add((id(part), positive))
            yield part, positive
            waiting += _operands(part, positive)


def _axis(nodes: Iterable[Formula], signal: Signal) -> Axis:
    """An axis on which all changes of the signal and all bounds of the formula are whole numbers of ticks."""
    times = {segment.start for segment in signal.segments} | {signal.end, signal.repeat_from or Fraction(0)}
    for node in nodes:
        match node:
            case (
                Eventually(_, interval)
                | Always(_, interval)
                | Until(_, _, interval)
                | Release(_, _, interval)
            ):
                times |= {interval.lower, interval.upper or Fraction(0)}
            case _:
                pass
    ticks = lcm(*(time.denominator for time in times))
    end = int(signal.end * ticks)
    if signal.repeat_from is None:
        # After the end every label is equally unknown: one tick of it, repeated, stands for all.
        return Axis(Fraction(1, ticks), end + 1, end + 2)
    return Axis(Fraction(1, ticks), int(signal.repeat_from * ticks), end)


def _held(names: set[str], signal: Signal, axis: Axis) -> Iterator[tuple[str, IntervalSet]]:
    """When each of `names` holds, as far as the signal is known."""
    cuts: dict[str, list[int]] = {name: [] for name in names}
    lows = [2 * axis.count(segment.start) for segment in signal.segments]
    end = 2 * axis.count(signal.end) + (signal.repeat_from is None)
    for segment, low, high in zip(signal.segments, lows, [*lows[1:], end], strict=True):
        for name in segment.holds & names:
            if cuts[name] and cuts[name][-1] == low:
                cuts[name].pop()
            else:
                cuts[name].append(low)
            cuts[name].append(high)
    for name, held in cuts.items():
        yield name, IntervalSet(axis, tuple(held))


def _disjuncts(formula: Formula, positive: bool) -> Iterator[tuple[Formula, bool]]:
    """The operands of a disjunction, those of nested disjunctions in place of these."""
    match formula:
        case Not(operand):
            yield from _disjuncts(operand, not positive)
        case And() | Or() | Implies() if not _all_needed(formula, positive):
            for part, sign in _operands(formula, positive):
                yield from _disjuncts(part, sign)
        case _:
            yield formula, positive


def _valid(disjuncts: list[tuple[Formula, bool]]) -> bool:
    """Whether those of the `disjuncts` that have no temporal operator cover every label."""
    present = [(part, sign) for part, sign in disjuncts if _propositional(part)]
    names = {node.name for part, _ in present for node, _ in _uses(part) if isinstance(node, Atom)}
    if len(names) > _MOST_ATOMS:
        return False
    # A row of a truth table is a bit: the column of the i-th atom has 2^i ones, 2^i zeros, and so on.
    full = (1 << (1 << len(names))) - 1
    columns = {name: full // ((1 << (1 << i)) + 1) for i, name in enumerate(sorted(names))}
    covered = 0
    for part, sign in present:
        column = _column(part, columns, full)
        covered |= column if sign else full ^ column
    return covered == full


def _propositional(formula: Formula) -> bool:
    return all(isinstance(part, (Constant, Atom, Not, And, Or, Implies, Iff)) for part, _ in _uses(formula))


def _column(formula: Formula, columns: dict[str, int], full: int) -> int:
    """The truth table of a formula without temporal operators."""
    parts = [_column(part, columns, full) for part, _ in _operands(formula, True)]
    match formula:
        case Constant(value):
            return full if value else 0
        case Atom(name):
            return columns[name]
        case Not():
            return full ^ parts[0]
        case And():
            return reduce(and_, parts, full)
        case Or():
            return reduce(or_, parts, 0)
        case Implies():
            return (full ^ parts[0]) | parts[1]
        case Iff():
            return full ^ parts[0] ^ parts[1]
        case _:
            raise ValueError("a temporal operator has no truth table")
