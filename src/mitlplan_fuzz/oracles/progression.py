"""Truth by progression: a formula is consumed half a tick at a time.

The time axis is cut into cells: the point 0, the open interval (0,1), the point 1, and so on; cell 2n is
the point n and cell 2n+1 the interval (n,n+1). If all bounds are whole and the signal changes at whole
times only, every formula has one truth value on each cell: a stretching of time that maps every unit
interval onto itself in the same way changes neither signal nor formula. So an operator is a bounded search
over cells, for open and closed bounds, both untils and any nesting, and no clock is needed.

A residual is what is still owed after the cells so far: a disjunction of conjunctions of started
operators. It is ``TRUE`` exactly when the known cells decide the formula whatever comes next, reading each
operator by itself (three truth values). Nothing here knows of automata, zones, or the product's own normal
form; the negation normal form is made anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, Union

from mitlplan.logic import formula as written
from mitlplan.logic.interval import ALWAYS, Interval

POINT, OPEN = 0, 1
"""The two phases: cell i has phase ``i % 2``."""


# --- The formula with negation on atoms only ---------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Known:
    """A constant."""

    value: bool


@dataclass(frozen=True, slots=True)
class Label:
    """An atom or its negation."""

    name: str
    positive: bool


@dataclass(frozen=True, slots=True)
class Every:
    """All operands hold."""

    operands: tuple[Need, ...]


@dataclass(frozen=True, slots=True)
class Some:
    """An operand holds."""

    operands: tuple[Need, ...]


@dataclass(frozen=True, slots=True)
class Timed:
    """Standard until (`strong`) or its dual, release; bounds in ticks, `upper` None is infinite."""

    strong: bool
    left: Need
    right: Need
    lower: int
    upper: int | None
    lower_open: bool
    upper_open: bool

    @property
    def includes_zero(self) -> bool:
        """Whether it may be met at once."""
        return self.lower == 0 and not self.lower_open

    def window(self, phase: int) -> tuple[int, int | None]:
        """First and last offset, in cells, of the cells that the interval meets from a cell of `phase`.

        From inside an open cell, t + [a,b] meets the open cells at both ends, and whether the ends
        themselves belong to the interval makes no difference; from a point it decides.
        """
        first = 2 * self.lower
        last = None if self.upper is None else 2 * self.upper
        if phase == POINT:
            first += self.lower_open
            if last is not None:
                last -= self.upper_open
        return first, last


Need = Union[Known, Label, Every, Some, Timed]


def every(operands: Iterable[Need]) -> Need:
    """Conjunction, without constants, copies, or an atom beside its negation."""
    return _gather(operands, Every, Known(True), Known(False))


def some(operands: Iterable[Need]) -> Need:
    """Disjunction, likewise."""
    return _gather(operands, Some, Known(False), Known(True))


def _gather(operands: Iterable[Need], kind: type[Every | Some], unit: Known, absorbing: Known) -> Need:
    kept: dict[Need, None] = {}
    for operand in operands:
        inner = operand.operands if isinstance(operand, kind) else (operand,)
        kept.update((need, None) for need in inner if need != unit)
    clash = any(isinstance(need, Label) and Label(need.name, not need.positive) in kept for need in kept)
    if clash or absorbing in kept:
        return absorbing
    if not kept:
        return unit
    return next(iter(kept)) if len(kept) == 1 else kind(tuple(kept))


def timed(strong: bool, left: Need, right: Need, interval: Interval, scale: Fraction) -> Need:
    """An until or a release; the bounds in ticks of ``1/scale`` must be whole."""
    neutral, decisive = Known(strong), Known(not strong)
    if right == decisive or (right == neutral and (left == neutral or Fraction(0) in interval)):
        return right
    if interval.upper == 0:
        # Of the present: what is known of it is known.
        return right
    upper = None if interval.upper is None else _whole(interval.upper * scale)
    return Timed(
        strong,
        left,
        right,
        _whole(interval.lower * scale),
        upper,
        interval.lower_open,
        interval.upper_open and upper is not None,
    )


def _whole(time: Fraction) -> int:
    if time.denominator != 1:
        raise ValueError(f"the time {time} is no whole number of ticks")
    return time.numerator


def need_of(
    formula: written.Formula,
    *,
    until: str = "standard",
    scale: Fraction = Fraction(1),
    wanted: bool = True,
) -> Need:
    """The negation normal form of `formula` (of its negation if not `wanted`), in ticks of ``1/scale``."""

    def convert(part: written.Formula, positive: bool) -> Need:
        return need_of(part, until=until, scale=scale, wanted=positive)

    def binary(strong: bool, left: Need, right: Need, interval: Interval) -> Need:
        if until == "closed":
            right = every([left, right]) if strong else some([left, right])
        return timed(strong, left, right, interval, scale)

    junction, dual = (every, some) if wanted else (some, every)
    match formula:
        case written.Constant(value):
            return Known(value == wanted)
        case written.Atom(name):
            return Label(name, wanted)
        case written.Not(operand):
            return convert(operand, not wanted)
        case written.And(operands):
            return junction(convert(operand, wanted) for operand in operands)
        case written.Or(operands):
            return dual(convert(operand, wanted) for operand in operands)
        case written.Implies(left, right):
            return dual([convert(left, not wanted), convert(right, wanted)])
        case written.Iff(left, right):
            return some(
                every([convert(left, value), convert(right, value == wanted)]) for value in (True, False)
            )
        case written.Eventually(operand, interval):
            return timed(wanted, Known(wanted), convert(operand, wanted), interval, scale)
        case written.Always(operand, interval):
            return timed(not wanted, Known(not wanted), convert(operand, wanted), interval, scale)
        case written.Next(operand):
            step = Interval(Fraction(1), Fraction(1))
            return timed(wanted, Known(wanted), convert(operand, wanted), step, scale)
        case written.Until(left, right, interval):
            return binary(wanted, convert(left, wanted), convert(right, wanted), interval)
        case written.Release(left, right, interval):
            return binary(not wanted, convert(left, wanted), convert(right, wanted), interval)
        case written.WeakUntil(left, right):
            for_ever = timed(not wanted, Known(not wanted), convert(left, wanted), ALWAYS, scale)
            reached = binary(wanted, convert(left, wanted), convert(right, wanted), ALWAYS)
            return dual([for_ever, reached])


def co_safe(formula: written.Formula, *, wanted: bool = True) -> bool:
    """Whether a finite plan can accomplish the mission, as it is written.

    No release of its negation normal form has an infinite upper bound (of its negation's, if not `wanted`).
    """
    match formula:
        case written.Constant() | written.Atom():
            return True
        case written.Not(operand):
            return co_safe(operand, wanted=not wanted)
        case written.And(operands) | written.Or(operands):
            return all(co_safe(operand, wanted=wanted) for operand in operands)
        case written.Implies(left, right):
            return co_safe(left, wanted=not wanted) and co_safe(right, wanted=wanted)
        case written.Iff(left, right):
            return all(co_safe(side, wanted=value) for side in (left, right) for value in (True, False))
        case written.Eventually(operand, interval):
            return (wanted or interval.upper is not None) and co_safe(operand, wanted=wanted)
        case written.Always(operand, interval):
            return (not wanted or interval.upper is not None) and co_safe(operand, wanted=wanted)
        case written.Next(operand):
            return co_safe(operand, wanted=wanted)
        case written.Until(left, right, interval):
            bounded = wanted or interval.upper is not None
            return bounded and co_safe(left, wanted=wanted) and co_safe(right, wanted=wanted)
        case written.Release(left, right, interval):
            bounded = not wanted or interval.upper is not None
            return bounded and co_safe(left, wanted=wanted) and co_safe(right, wanted=wanted)
        case written.WeakUntil():
            return False


# --- Residuals ---------------------------------------------------------------------------------------------


class Started(NamedTuple):
    """A timed operator claimed at an earlier cell; its window in cells, counted from the next cell.

    `source` is the operator's number (a comparison of formulas would cost more than all the rest).
    """

    source: int
    strong: bool
    first: int
    last: int | None

    def implies(self, other: Started) -> bool:
        """Whether this one holds only if `other` does: same operator, and the windows nest."""
        # An endless release holds when the mission ends and a bounded one does not, so under a finite
        # horizon the two must not be merged.
        if self.source != other.source or (self.last is None) != (other.last is None):
            return False
        inner, outer = (self, other) if self.strong else (other, self)
        within = outer.last is None or (inner.last is not None and inner.last <= outer.last)
        return outer.first <= inner.first and within


Clause = frozenset[Started]
Residual = frozenset[Clause]

FALSE: Residual = frozenset()
TRUE: Residual = frozenset([frozenset()])

MOST_CLAUSES = 60
MOST_RESIDUALS = 2000


class TooLargeError(Exception):
    """There are too many residuals, or one has too many clauses: no formula for a slow oracle."""


def either(left: Residual, right: Residual) -> Residual:
    """The disjunction of two residuals, without clauses that ask more than another."""
    if TRUE in (left, right):
        return TRUE
    return _weakest(left | right)


def both(left: Residual, right: Residual) -> Residual:
    """The conjunction of two residuals."""
    if FALSE in (left, right):
        return FALSE
    if left == TRUE:
        return right
    if right == TRUE:
        return left
    return _weakest({_strongest(mine | other) for mine in left for other in right})


def _strongest(clause: Clause) -> Clause:
    return frozenset(
        owed for owed in clause if not any(other != owed and other.implies(owed) for other in clause)
    )


def _weakest(clauses: Iterable[Clause]) -> Residual:
    found = set(clauses)
    if len(found) > MOST_CLAUSES:
        raise TooLargeError
    if len(found) < 2:
        return frozenset(found)
    return frozenset(
        clause
        for clause in found
        if not any(other is not clause and _covers(other, clause) for other in found)
    )


def _covers(weak: Clause, strong: Clause) -> bool:
    """Whether `strong` implies `weak`."""
    return all(any(mine == owed or mine.implies(owed) for mine in strong) for owed in weak)


class Progression:
    """Progression of one formula, with everything remembered.

    The residuals are numbered, so that a search can keep them in its states; number 0 is ``FALSE``,
    number 1 is ``TRUE`` and number ``initial`` is the formula itself, owed before the point 0.
    """

    def __init__(self, need: Need) -> None:
        self._sources: list[Timed] = []
        self._source_numbers: dict[Timed, int] = {}
        self._residuals: list[Residual] = [FALSE, TRUE]
        self._numbers: dict[Residual, int] = {FALSE: 0, TRUE: 1}
        self._steps: dict[tuple[int, frozenset[str], int], int] = {}
        self._claims: dict[tuple[Need, frozenset[str], int], Residual] = {}
        self._advances: dict[tuple[Started, frozenset[str], int], Residual] = {}
        at_once = Timed(True, Known(True), need, 0, 0, False, False)
        self.initial = self._number(frozenset([frozenset([Started(self._source(at_once), True, 0, 0)])]))

    def residual(self, number: int) -> Residual:
        """The residual of that number."""
        return self._residuals[number]

    def step(self, number: int, label: frozenset[str], phase: int) -> int:
        """What is owed after one more cell."""
        if number < 2:
            return number
        key = (number, label, phase)
        if key not in self._steps:
            result = FALSE
            for clause in self._residuals[number]:
                owed = TRUE
                for started in clause:
                    owed = both(owed, self.advance(started, label, phase))
                result = either(result, owed)
            self._steps[key] = self._number(result)
        return self._steps[key]

    def source(self, started: Started) -> Timed:
        """The operator that was started."""
        return self._sources[started.source]

    def _source(self, need: Timed) -> int:
        if need not in self._source_numbers:
            self._source_numbers[need] = len(self._sources)
            self._sources.append(need)
        return self._source_numbers[need]

    def _number(self, residual: Residual) -> int:
        if residual not in self._numbers:
            if len(self._residuals) > MOST_RESIDUALS:
                raise TooLargeError
            self._numbers[residual] = len(self._residuals)
            self._residuals.append(residual)
        return self._numbers[residual]

    def claim(self, need: Need, label: frozenset[str], phase: int) -> Residual:
        """What is owed after a cell at which `need` is to hold."""
        key = (need, label, phase)
        if key not in self._claims:
            self._claims[key] = self._claim(need, label, phase)
        return self._claims[key]

    def _claim(self, need: Need, label: frozenset[str], phase: int) -> Residual:
        match need:
            case Known(value):
                return TRUE if value else FALSE
            case Label(name, positive):
                return TRUE if (name in label) == positive else FALSE
            case Every(operands):
                result = TRUE
                for operand in operands:
                    result = both(result, self.claim(operand, label, phase))
                return result
            case Some(operands):
                result = FALSE
                for operand in operands:
                    result = either(result, self.claim(operand, label, phase))
                return result
            case Timed():
                first, last = need.window(phase)
                started = Started(self._source(need), need.strong, first, last)
                return self._unfold(started, label, phase, at_once=need.includes_zero)

    def advance(self, started: Started, label: frozenset[str], phase: int) -> Residual:
        """What is owed after one more cell of a started operator."""
        key = (started, label, phase)
        if key not in self._advances:
            self._advances[key] = self._unfold(started, label, phase, at_once=False)
        return self._advances[key]

    def _unfold(self, started: Started, label: frozenset[str], phase: int, *, at_once: bool) -> Residual:
        """One cell of the until: its right side here, or its left side here and the rest later.

        In an open cell an inner instant has a stretch of the same cell before it, on which the left side
        must hold too, unless the claim itself is met without delay (`at_once`).
        """
        source, first, last = self.source(started), started.first, started.last
        join, meet = (either, both) if started.strong else (both, either)
        left = self.claim(source.left, label, phase)
        later = FALSE if started.strong else TRUE
        if last is None or last > 0:
            rest = started._replace(first=max(first - 1, 0), last=None if last is None else last - 1)
            later = meet(left, frozenset([frozenset([rest])]))
        if first > 0:
            return later
        now = self.claim(source.right, label, phase)
        if phase == OPEN and not at_once:
            now = meet(left, now)
        return join(now, later)


def holds_at_the_end(residual: Residual) -> bool:
    """Whether a mission of finite horizon may end here: only what was to hold for ever is still owed."""
    return any(all(not owed.strong and owed.last is None for owed in clause) for clause in residual)


# --- Truth on a signal that repeats ------------------------------------------------------------------------


class Cycle:
    """A signal that repeats ``labels`` (one a tick) for ever, and the truth of formulas on it.

    Truth is a number whose bit i is the truth on cell i, cells counted modulo the period.
    """

    def __init__(self, labels: Sequence[frozenset[str]]) -> None:
        self._labels = labels
        self._size = 2 * len(labels)
        self._all = (1 << self._size) - 1
        self._points = sum(1 << cell for cell in range(0, self._size, 2))
        self._truth: dict[Need, int] = {}

    def pays(self, progression: Progression, number: int) -> bool:
        """Whether a residual owed just before cell 0 is paid by this signal."""
        return any(
            all(self._pays(progression.source(owed), owed.first, owed.last) for owed in clause)
            for clause in progression.residual(number)
        )

    def truth(self, need: Need) -> int:
        """The cells on which `need` holds."""
        if need not in self._truth:
            self._truth[need] = self._evaluate(need)
        return self._truth[need]

    def _evaluate(self, need: Need) -> int:
        match need:
            case Known(value):
                return self._all if value else 0
            case Label(name, positive):
                return sum(
                    3 << 2 * tick for tick, label in enumerate(self._labels) if (name in label) == positive
                )
            case Every(operands):
                result = self._all
                for operand in operands:
                    result &= self.truth(operand)
                return result
            case Some(operands):
                result = 0
                for operand in operands:
                    result |= self.truth(operand)
                return result
            case Timed():
                at_points = self._search(need, *need.window(POINT), fresh=True) & self._points
                inside = self._search(need, *need.window(OPEN), fresh=True) & ~self._points
                return at_points | inside

    def _pays(self, need: Timed, first: int, last: int | None) -> bool:
        return bool(self._search(need, first, last, fresh=False) & 1)

    def _search(self, need: Timed, first: int, last: int | None, *, fresh: bool) -> int:
        """The cells from which the window [first, last] brings what `need` asks.

        A release is computed as the complement of the until of the complements. A whole period after the
        window opens, nothing new can be seen.
        """
        flip = 0 if need.strong else self._all
        left, right = self.truth(need.left) ^ flip, self.truth(need.right) ^ flip
        farthest = first + self._size if last is None else min(last, first + self._size)
        unbroken, found = self._all, 0
        for offset in range(farthest + 1):
            here = self._ahead(left, offset)
            if offset >= first:
                witness = self._ahead(right, offset) & unbroken
                if not (offset == 0 and fresh and need.includes_zero):
                    witness &= here | self._ahead(self._points, offset)
                found |= witness
            unbroken &= here
            if not unbroken:
                break
        return found ^ flip

    def _ahead(self, cells: int, offset: int) -> int:
        offset %= self._size
        return (cells >> offset | cells << (self._size - offset)) & self._all
