"""The judge: whether a formula holds on a signal, exactly, straight from its meaning (docs: semantics).

It shares no code with the normal form, the translation and the search, so that a plan is never confirmed by
the error that produced it. Every subformula becomes the set of times at which it *surely* holds, its negation
the set at which it surely fails: a negation turns every operator into its dual.

On a signal that repeats the two are complements. On a signal that ends, nothing is known after `end` but what
is true of every label, and truth is strong Kleene's: what surely holds, holds whatever follows. Horizon
"finite" lets a release (so G, W and a negated F or U) that reaches to infinity speak of [0, end] only; seen
from after `end` it must surely hold like everything else, so that ``F G p`` asks for p at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import reduce
from math import lcm
from operator import and_, or_
from typing import Literal, NamedTuple, TypeAlias

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

_Operator: TypeAlias = Callable[[IntervalSet, IntervalSet, Interval], IntervalSet]

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
    closed = until == "closed"
    present = _without_instants(formula, closed=closed)
    judge = _Judge.of(present, signal, closed_until=closed, finite_horizon=horizon == "finite")
    return judge.verdict(present)


def _without_instants(formula: Formula, *, closed: bool) -> Formula:
    """The formula without operators over ``[0,0]``.

    They speak of the present, so that ``F[0,0] p | !p`` is certain.
    """
    done: dict[int, Formula] = {}

    def rest(part: Formula) -> Formula:
        if id(part) not in done:
            done[id(part)] = _without_instant(part, rest, closed=closed)
        return done[id(part)]

    # Parts before wholes, so that no depth of nesting overflows the stack.
    for part in reversed(list(_parts(_Claim(formula)))):
        rest(part.formula)
    return rest(formula)


def _without_instant(formula: Formula, rest: Callable[[Formula], Formula], *, closed: bool) -> Formula:
    match formula:
        case Constant() | Atom():
            return formula
        case And(operands) | Or(operands):
            return replace(formula, operands=tuple(map(rest, operands)))
        case Eventually(operand, interval) | Always(operand, interval) if interval.upper == 0:
            return rest(operand)
        case Until(left, right, interval) if interval.upper == 0:
            return And((rest(left), rest(right))) if closed else rest(right)
        case Release(left, right, interval) if interval.upper == 0:
            return Or((rest(left), rest(right))) if closed else rest(right)
        case Not(operand) | Eventually(operand) | Always(operand) | Next(operand):
            return replace(formula, operand=rest(operand))
        case Implies(left, right) | Iff(left, right) | WeakUntil(left, right):
            return replace(formula, left=rest(left), right=rest(right))
        case Until(left, right) | Release(left, right):
            return replace(formula, left=rest(left), right=rest(right))


class _Claim(NamedTuple):
    """A formula or, if not positive, its negation."""

    formula: Formula
    positive: bool = True


@dataclass(frozen=True, slots=True)
class _Judge:
    """What is known of a signal, and how the operators are read.

    `literals` are the times at which an atom is surely true, or surely false; `unknown` those of which
    nothing is known. `memory` goes by identity: comparing large formulas costs more than judging them.
    """

    axis: Axis
    literals: dict[_Claim, IntervalSet]
    unknown: IntervalSet
    closed_until: bool
    finite_horizon: bool
    memory: dict[tuple[int, bool], IntervalSet] = field(default_factory=dict)

    @classmethod
    def of(cls, formula: Formula, signal: Signal, *, closed_until: bool, finite_horizon: bool) -> _Judge:
        nodes = [part.formula for part in _parts(_Claim(formula))]
        axis = _axis(nodes, signal)
        unknown = IntervalSet.nothing(axis)
        if signal.repeat_from is None:
            unknown = IntervalSet(axis, (2 * axis.count(signal.end) + 1, 2 * axis.end))
        literals = {}
        for atom, held in _held({node for node in nodes if isinstance(node, Atom)}, signal, axis):
            literals[_Claim(atom)] = held
            literals[_Claim(atom, positive=False)] = ~(held | unknown)
        return cls(axis, literals, unknown, closed_until, finite_horizon)

    def verdict(self, formula: Formula) -> IntervalSet:
        """When `formula` surely holds; its innermost parts first, so no nesting overflows the stack."""
        for part in reversed(list(_parts(_Claim(formula)))):
            self.surely(part)
        return self.surely(_Claim(formula))

    def surely(self, claim: _Claim) -> IntervalSet:
        """When `claim` holds whatever is true where nothing is known."""
        key = id(claim.formula), claim.positive
        if key not in self.memory:
            self.memory[key] = self._evaluated(claim)
        return self.memory[key]

    def _evaluated(self, claim: _Claim) -> IntervalSet:
        sides = [self.surely(operand) for operand in _operands(claim)]
        if self.closed_until and isinstance(claim.formula, (Until, Release, WeakUntil)):
            sides[1] = self._closed(claim, *sides)
        # A negation turns every operator into its dual; the operands are negated already.
        until: _Operator = IntervalSet.until
        release: _Operator = self._release
        everything, nothing = IntervalSet.everything(self.axis), IntervalSet.nothing(self.axis)
        either: Callable[[IntervalSet, IntervalSet], IntervalSet] = or_  # of the two cases of a weak until
        if not claim.positive:
            until, release, everything, nothing, either = release, until, nothing, everything, and_
        match claim.formula:
            case Constant(value):
                return everything if value else nothing
            case Atom():
                return self.literals[claim]
            case Not():
                return sides[0]
            case And() | Or() | Implies() | Iff():
                return self._junction(claim, sides)
            case Next():
                return sides[0].eventually(_ONE_LATER)
            case Eventually(_, interval):
                return until(everything, sides[0], interval)
            case Always(_, interval):
                return release(nothing, sides[0], interval)
            case Until(_, _, interval):
                return until(sides[0], sides[1], interval)
            case Release(_, _, interval):
                return release(sides[0], sides[1], interval)
            case WeakUntil():
                return either(release(nothing, sides[0], ALWAYS), until(sides[0], sides[1], ALWAYS))

    def _closed(self, claim: _Claim, left: IntervalSet, right: IntervalSet) -> IntervalSet:
        """The right side with which the standard operator means the closed one."""
        if isinstance(claim.formula, Release) == claim.positive:
            return left | right | self._known_of_every_label(_operands(claim))
        return left & right

    def _release(self, left: IntervalSet, right: IntervalSet, interval: Interval) -> IntervalSet:
        sure = ~(~left).until(~right, interval)
        if not self.finite_horizon or interval.upper is not None:
            return sure
        until_end = ~(~left).until(~(right | self.unknown), interval)
        return sure | (until_end & ~self.unknown)

    def _junction(self, claim: _Claim, sides: list[IntervalSet]) -> IntervalSet:
        if _conjunctive(claim):
            return intersection(self.axis, sides)
        if isinstance(claim.formula, Iff):
            sides = [sides[0] & sides[1], sides[2] & sides[3]]
        return union(self.axis, [*sides, self._known_of_every_label([claim])])

    def _known_of_every_label(self, disjuncts: Iterable[_Claim]) -> IntervalSet:
        """The times after the signal's end, if there one of `disjuncts` holds whatever the label is."""
        if self.unknown and _cover_every_label(disjuncts):
            return self.unknown
        return IntervalSet.nothing(self.axis)


def _operands(claim: _Claim) -> tuple[_Claim, ...]:
    """The parts on which `claim` depends, negated where it depends on their negation."""
    positive = claim.positive
    match claim.formula:
        case Constant() | Atom():
            return ()
        case Not(operand):
            return (_Claim(operand, not positive),)
        case And(operands) | Or(operands):
            return tuple(_Claim(operand, positive) for operand in operands)
        case Implies(left, right):
            return _Claim(left, not positive), _Claim(right, positive)
        case Iff(left, right):
            # Two pairs, one of which must hold.
            agree = _Claim(left, positive=True), _Claim(right, positive)
            return *agree, _Claim(left, positive=False), _Claim(right, not positive)
        case Eventually(operand) | Always(operand) | Next(operand):
            return (_Claim(operand, positive),)
        case Until(left, right) | Release(left, right) | WeakUntil(left, right):
            return _Claim(left, positive), _Claim(right, positive)


def _conjunctive(claim: _Claim) -> bool:
    """Whether a claim about a junction needs all its operands, not one."""
    match claim.formula:
        case And():
            return claim.positive
        case Or() | Implies():
            return not claim.positive
        case _:
            return False


def _parts(claim: _Claim) -> Iterator[_Claim]:
    """The claim and all it depends on, each once, wholes before their parts."""
    waiting = [claim]
    seen = set()
    while waiting:
        part = waiting.pop()
        key = id(part.formula), part.positive
        if key not in seen:
            seen.add(key)
            yield part
            waiting += _operands(part)


def _axis(nodes: Iterable[Formula], signal: Signal) -> Axis:
    """An axis on which all changes of the signal and all bounds of the formula are whole numbers of ticks."""
    times = {segment.start for segment in signal.segments} | {signal.end, signal.repeat_from or Fraction(0)}
    for node in nodes:
        match node:
            case Eventually() | Always() | Until() | Release():
                times |= {node.interval.lower, node.interval.upper or Fraction(0)}
            case _:
                pass
    ticks = lcm(*(time.denominator for time in times))
    end = int(signal.end * ticks)
    if signal.repeat_from is None:
        # After the end every label is equally unknown: one tick of it, repeated, stands for all.
        return Axis(Fraction(1, ticks), end + 1, end + 2)
    return Axis(Fraction(1, ticks), int(signal.repeat_from * ticks), end)


def _held(atoms: set[Atom], signal: Signal, axis: Axis) -> Iterator[tuple[Atom, IntervalSet]]:
    """When each of `atoms` holds, as far as the signal is known."""
    cuts: dict[str, list[int]] = {atom.name: [] for atom in atoms}
    lows = [2 * axis.count(segment.start) for segment in signal.segments]
    end = 2 * axis.count(signal.end) + (signal.repeat_from is None)
    for segment, low, high in zip(signal.segments, lows, [*lows[1:], end], strict=True):
        for name in segment.holds & cuts.keys():
            if cuts[name] and cuts[name][-1] == low:
                cuts[name][-1] = high
            else:
                cuts[name] += (low, high)
    for atom in atoms:
        yield atom, IntervalSet(axis, tuple(cuts[atom.name]))


def _cover_every_label(claims: Iterable[_Claim]) -> bool:
    """Whether those disjuncts of `claims` that have no temporal operator cover every label."""
    present = [part for claim in claims for part in _disjuncts(claim) if _propositional(part)]
    names = {node.name for part in present for node, _ in _parts(part) if isinstance(node, Atom)}
    if len(names) > _MOST_ATOMS:
        return False
    # A label is a bit: the table of the i-th atom has 2^i ones, 2^i zeros, 2^i ones, and so on.
    full = (1 << (1 << len(names))) - 1
    tables = {name: full // ((1 << (1 << i)) + 1) for i, name in enumerate(sorted(names))}
    return reduce(or_, (_table(part, tables, full) for part in present), 0) == full


def _disjuncts(claim: _Claim) -> Iterator[_Claim]:
    """The operands of a disjunction, those of nested disjunctions in place of these."""
    match claim.formula:
        case Not() | And() | Or() | Implies() if not _conjunctive(claim):
            for operand in _operands(claim):
                yield from _disjuncts(operand)
        case _:
            yield claim


def _propositional(claim: _Claim) -> bool:
    present = Constant, Atom, Not, And, Or, Implies, Iff
    return all(isinstance(part.formula, present) for part in _parts(claim))


def _table(claim: _Claim, tables: dict[str, int], full: int) -> int:
    """The labels of which a claim without temporal operators is true."""
    sides = [_table(operand, tables, full) for operand in _operands(claim)]
    match claim.formula:
        case Constant(value):
            return full if value is claim.positive else 0
        case Atom(name):
            return tables[name] if claim.positive else full ^ tables[name]
        case Iff():
            return (sides[0] & sides[1]) | (sides[2] & sides[3])
        case _:
            return reduce(and_, sides, full) if _conjunctive(claim) else reduce(or_, sides, 0)
