"""Rewriting a formula in normal form so that its automata are smaller.

Each rule keeps more than the truth on right-continuous signals. In Kleene's three values it keeps the times
at which a signal known up to T already decides the formula, so that a plan's makespan stays as it is; and it
keeps them where operators that reach to infinity speak of [0,T] only (horizon "finite"). What is right for an
infinite horizon alone is done only there. I + J are the sums of a time of I and one of J.

    p U_I (p U_J q)  =  p U_(I+J) q        so F_I F_J q = F_(I+J) q, for open and closed ends alike
    p R_I (p R_J q)  =  p R_(I+J) q        if both intervals are bounded, or neither
    G_[a,a] q        =  F_[a,a] q
    G_I F_(J+a) q    =  G_(I+a) F_J q      where G is asked once: F needs one clock, not a line of them
    G_I (p & q)      =  G_I p & G_I q      below no other operator: each temporal part by itself

Side by side, with p and q propositional; below ``|`` the duals:

    (p U_I f) & (q U_I f)  =  (p & q) U_I f          (f R_I p) & (f R_I q)  =  f R_I (p & q)
    (f U_I g) & (f U_J g)  =  f U_I g, I within J    (f R_I g) & (f R_J g)  =  f R_(I or J) g, if they touch
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeAlias, Union

from mitlplan.logic.core import (
    FALSE,
    TRUE,
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Disjunction,
    Literal,
    Truth,
    always,
    conjunction,
    disjunction,
    eventually,
    propositional,
    release,
    until,
)
from mitlplan.logic.interval import Interval
from mitlplan.logic.labels import certain, possible

_Temporal: TypeAlias = Union[CoreUntil, CoreRelease]


def simplify(core: Core, *, endless: bool) -> Core:
    """Apply the identities until none applies.

    Parameters
    ----------
    core
        A formula in normal form.
    endless
        Whether the mission has no end (horizon "infinite"), so that G reaches to infinity.

    Examples
    --------
    >>> soon = Interval(Fraction(0), Fraction(2))
    >>> simplify(eventually(eventually(Literal("A"), soon), soon), endless=True) == eventually(
    ...     Literal("A"), Interval(Fraction(0), Fraction(4)))
    True
    """
    rules = _Rules(endless)
    while (simpler := rules.apart(rules.inside(core))) != core:
        core = simpler
    return core


@dataclass(frozen=True, slots=True)
class _Rules:
    endless: bool

    def inside(self, core: Core) -> Core:
        """The rules that hold anywhere, innermost first."""
        match core:
            case Truth() | Literal():
                return core
            case Conjunction(operands):
                return self._joined(_AND, [self.inside(operand) for operand in operands])
            case Disjunction(operands):
                return self._joined(_OR, [self.inside(operand) for operand in operands])
            case CoreUntil(left, right, interval):
                return _until(self.inside(left), self.inside(right), interval)
            case CoreRelease(left, right, interval):
                return self._release(self.inside(left), self.inside(right), interval)

    def _release(self, left: Core, right: Core, interval: Interval) -> Core:
        if left == FALSE and interval.punctual:
            return _until(TRUE, right, interval)
        if isinstance(right, CoreRelease) and right.left == left:
            later = right.interval
            if self._cut_short(interval) == self._cut_short(later):
                return release(left, right.right, _sum(interval, later))
        return release(left, right, interval)

    def _cut_short(self, interval: Interval) -> bool:
        """Whether a release over this interval ends with the mission, not with the interval."""
        return interval.upper is None and not self.endless

    def _joined(self, junction: _Junction, operands: Iterable[Core]) -> Core:
        core = junction.join(*operands)
        while (simpler := self._joined_once(junction, core)) != core:
            core = simpler
        return core

    def _joined_once(self, junction: _Junction, core: Core) -> Core:
        if not isinstance(core, junction.kind):
            return core
        if junction.decides(operand for operand in core.operands if propositional(operand)):
            return junction.decided
        temporal, rest = _temporal_and_rest(core.operands)
        groups: dict[object, list[_Temporal]] = {}
        for operand in temporal:
            groups.setdefault(junction.alike_but_one_side(operand), []).append(operand)
        combined = [part for group in groups.values() for part in junction.combined(group)]
        return junction.join(*rest, *self._with_fewer_intervals(junction, combined))

    def _with_fewer_intervals(self, junction: _Junction, operands: list[Core]) -> Iterator[Core]:
        temporal, rest = _temporal_and_rest(operands)
        yield from rest
        groups: dict[object, list[_Temporal]] = {}
        for operand in temporal:
            cut_short = isinstance(operand, CoreRelease) and self._cut_short(operand.interval)
            key = type(operand), operand.left, operand.right, cut_short
            groups.setdefault(key, []).append(operand)
        for group in groups.values():
            fewer = _narrowest if isinstance(group[0], junction.narrowing) else _united
            for interval in fewer([operand.interval for operand in group]):
                yield _rebuilt(group[0], interval=interval)

    def apart(self, core: Core) -> Core:
        """The rules for operators below no other: each temporal part of a G by itself."""
        match core:
            case Conjunction(operands):
                return conjunction(*(self.apart(operand) for operand in operands))
            case Disjunction(operands):
                return disjunction(*(self.apart(operand) for operand in operands))
            case CoreRelease(left, Conjunction(operands), interval) if left == FALSE:
                temporal, rest = _temporal_and_rest(operands)
                parts = conjunction(*rest), *temporal
                return conjunction(*(self.once(always(part, interval)) for part in parts))
            case _:
                return self.once(core)

    def once(self, core: Core) -> Core:
        """The rules for operators in one-shot positions: a chain's delay goes to its first operator."""
        match core:
            case Truth() | Literal():
                return core
            case Conjunction(operands):
                return conjunction(*(self.once(operand) for operand in operands))
            case Disjunction(operands):
                return disjunction(*(self.once(operand) for operand in operands))
            case CoreUntil(left, right, interval):
                return until(left, self.once(right), interval)
            case CoreRelease(left, right, interval) if left == FALSE and not self._cut_short(interval):
                delay, prompt = self._without_delay(right)
                return always(prompt, _moved(interval, delay))
            case CoreRelease(left, right, interval):
                return release(self.once(left), right, interval)

    def _without_delay(self, core: Core) -> tuple[Fraction, Core]:
        """A time, and a formula that means, that much later, what `core` means now."""
        match core:
            case CoreUntil(left, right, interval) if left == TRUE:
                delay, prompt = self._without_delay(right)
                return interval.lower + delay, eventually(prompt, _moved(interval, -interval.lower))
            case CoreRelease(left, right, interval) if left == FALSE and not self._cut_short(interval):
                delay, prompt = self._without_delay(right)
                return interval.lower + delay, always(prompt, _moved(interval, -interval.lower))
            case _:
                return Fraction(0), core


@dataclass(frozen=True, slots=True)
class _Junction:
    """What is different below ``&`` and below ``|``.

    `decided` is what a junction is if it is the same of every label. Of the `narrowing` operator the narrower
    interval says more, and its left sides combine; of the other operator intervals and right sides do.
    """

    kind: type[Conjunction | Disjunction]
    join: Callable[..., Core]
    decided: Truth
    narrowing: type[_Temporal]

    def decides(self, operands: Iterable[Core]) -> bool:
        """Whether the junction of these operands is the same of every label."""
        joined = self.join(*operands)
        return certain(joined) if self.decided.value else not possible(joined)

    def alike_but_one_side(self, operand: _Temporal) -> object:
        """What operands that combine have in common."""
        own, shared = self._sides(operand)
        return (type(operand), shared, operand.interval) if propositional(own) else operand

    def combined(self, group: list[_Temporal]) -> list[Core]:
        """One operand for a group, unless every label would decide what its parts leave open."""
        sides = [self._sides(operand)[0] for operand in group]
        if len(group) == 1 or self.decides(sides):
            return [*group]
        first, joined = group[0], self.join(*sides)
        if isinstance(first, self.narrowing):
            return [_rebuilt(first, left=joined)]
        return [_rebuilt(first, right=joined)]

    def _sides(self, operand: _Temporal) -> tuple[Core, Core]:
        if isinstance(operand, self.narrowing):
            return operand.left, operand.right
        return operand.right, operand.left


_AND = _Junction(Conjunction, conjunction, FALSE, CoreUntil)
_OR = _Junction(Disjunction, disjunction, TRUE, CoreRelease)


def _temporal_and_rest(operands: Iterable[Core]) -> tuple[list[_Temporal], list[Core]]:
    temporal: list[_Temporal] = []
    rest: list[Core] = []
    for operand in operands:
        if isinstance(operand, (CoreUntil, CoreRelease)):
            temporal.append(operand)
        else:
            rest.append(operand)
    return temporal, rest


def _until(left: Core, right: Core, interval: Interval) -> Core:
    match right:
        case CoreUntil(same, inner, later) if same == left:
            return until(left, inner, _sum(interval, later))
        case _:
            return until(left, right, interval)


def _rebuilt(
    operand: _Temporal,
    *,
    left: Core | None = None,
    right: Core | None = None,
    interval: Interval | None = None,
) -> Core:
    build = until if isinstance(operand, CoreUntil) else release
    return build(left or operand.left, right or operand.right, interval or operand.interval)


# ------------------------------------------------------------------------------------------------ intervals


def _moved(interval: Interval, time: Fraction) -> Interval:
    upper = None if interval.upper is None else interval.upper + time
    return replace(interval, lower=interval.lower + time, upper=upper)


def _sum(first: Interval, second: Interval) -> Interval:
    upper = None if first.upper is None or second.upper is None else first.upper + second.upper
    return Interval(
        first.lower + second.lower,
        upper,
        first.lower_open or second.lower_open,
        first.upper_open or second.upper_open,
    )


def _starts(interval: Interval) -> tuple[Fraction, bool]:
    """Smaller, if the interval starts earlier."""
    return interval.lower, interval.lower_open


def _ends(interval: Interval) -> tuple[bool, Fraction, bool]:
    """Smaller, if the interval ends earlier."""
    return interval.upper is None, interval.upper or Fraction(0), not interval.upper_open


def _narrowest(intervals: list[Interval]) -> list[Interval]:
    """The intervals that contain no other."""
    kept: list[Interval] = []
    # Of two, the one that starts later, or ends earlier, comes first: it is contained, never contains.
    for interval in sorted(intervals, key=_ends):
        if not kept or _starts(interval) > _starts(kept[-1]):
            if kept and _ends(interval) == _ends(kept[-1]):
                kept.pop()
            kept.append(interval)
    return kept


def _united(intervals: list[Interval]) -> list[Interval]:
    """The fewest intervals with the same times."""
    united: list[Interval] = []
    for interval in sorted(intervals, key=_starts):
        if united and _touch(united[-1], interval):
            last = max(united[-1], interval, key=_ends)
            united[-1] = replace(united[-1], upper=last.upper, upper_open=last.upper_open)
        else:
            united.append(interval)
    return united


def _touch(earlier: Interval, later: Interval) -> bool:
    if earlier.upper is None or later.lower < earlier.upper:
        return True
    return later.lower == earlier.upper and not (earlier.upper_open and later.lower_open)
