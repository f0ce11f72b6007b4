"""Truth by trying every instant: slow, and written straight from the definitions.

Time is cut into regions: region 2k is the instant k/n, region 2k+1 the open interval (k/n, (k+1)/n), for a
given n. If the signal changes, and the bounds lie, at multiples of 1/n, a formula has one truth value on each
region: by induction, because which regions lie at a distance in I is the same for all instants of a region.
So "there is a time" becomes "there is a region"; a finer n must not change anything, which is tested.

There is one temporal operator here, the standard until; the others are what they abbreviate. A value is a
pair: the formula surely holds, the formula possibly holds (Kleene's three values, and the fourth that
the finite horizon makes). Shares nothing with the judge but the nouns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from mitlplan.logic import formula as written
from mitlplan.logic.interval import ALWAYS, Interval
from mitlplan.logic.signal import Signal

Values = list[tuple[bool, bool]]
"""For each region up to the end of the first repetition: surely true, possibly true."""

ONE_LATER = Interval(Fraction(1), Fraction(1))


@dataclass(frozen=True)
class Regions:
    """The regions of a signal: from `start` on they repeat with `period`; from `unknown` on, no label is."""

    resolution: int
    start: int
    period: int
    unknown: int | None

    @classmethod
    def of(cls, signal: Signal, resolution: int) -> Regions:
        end = int(2 * resolution * signal.end)
        if signal.repeat_from is None:
            return cls(resolution, end + 2, 2, end + 1)
        start = int(2 * resolution * signal.repeat_from)
        return cls(resolution, start, end - start, None)

    @property
    def stored(self) -> int:
        return self.start + self.period

    def index(self, region: int) -> int:
        """Where the value of `region` is stored."""
        if region < self.stored:
            return region
        return self.start + (region - self.start) % self.period

    def instant(self, region: int) -> Fraction:
        """An instant of the region."""
        return Fraction(region, 2 * self.resolution)


def brute_truth(
    formula: written.Formula,
    signal: Signal,
    *,
    until: str = "standard",
    horizon: str = "infinite",
    resolution: int = 1,
) -> dict[Fraction, bool]:
    """For an instant of each region: whether the formula surely holds there."""
    regions = Regions.of(signal, resolution)
    values = _Brute(signal, regions, until == "closed", horizon == "finite").values(formula)
    return {regions.instant(region): surely for region, (surely, _) in enumerate(values)}


@dataclass(frozen=True)
class _Brute:
    signal: Signal
    regions: Regions
    closed_until: bool
    finite_horizon: bool

    def values(self, formula: written.Formula) -> Values:
        match formula:
            case written.Constant(value):
                return [(value, value)] * self.regions.stored
            case written.Atom(name):
                return [self.atom(name, region) for region in range(self.regions.stored)]
            case written.Not(operand):
                return negation(self.values(operand))
            case written.And(operands):
                return [both(row) for row in zip(*map(self.values, operands), strict=True)]
            case written.Or(operands):
                return disjunction(*map(self.values, operands))
            case written.Implies(left, right):
                return disjunction(negation(self.values(left)), self.values(right))
            case written.Iff(left, right):
                p, q = self.values(left), self.values(right)
                one = [both(row) for row in zip(p, q, strict=True)]
                other = [both(row) for row in zip(negation(p), negation(q), strict=True)]
                return disjunction(one, other)
            case written.Eventually(operand, interval):
                return self.until(self.true, self.values(operand), interval)
            case written.Always(operand, interval):
                return negation(self.until(self.true, negation(self.values(operand)), interval))
            case written.Next(operand):
                return self.until(self.true, self.values(operand), ONE_LATER)
            case written.Until(left, right, interval):
                return self.until(self.values(left), self.values(right), interval)
            case written.Release(left, right, interval):
                p, q = negation(self.values(left)), negation(self.values(right))
                return negation(self.until(p, q, interval))
            case written.WeakUntil(left, right):
                p, q = self.values(left), self.values(right)
                for_ever = negation(self.until(self.true, negation(p), ALWAYS))
                return disjunction(for_ever, self.until(p, q, ALWAYS))

    @property
    def true(self) -> Values:
        return [(True, True)] * self.regions.stored

    def atom(self, name: str, region: int) -> tuple[bool, bool]:
        if self.regions.unknown is not None and region >= self.regions.unknown:
            return False, True
        instant = self.regions.instant(region)
        label = [segment.holds for segment in self.signal.segments if segment.start <= instant][-1]
        return name in label, name in label

    def until(self, left: Values, right: Values, interval: Interval) -> Values:
        if self.closed_until:
            right = [both(row) for row in zip(left, right, strict=True)]
        unit = 2 * self.regions.resolution
        bound = interval.lower if interval.upper is None else interval.upper
        reach = self.regions.stored + self.regions.period + int(unit * bound) + 2
        wanted = [Fraction(distance, unit) in interval for distance in range(reach + 2)]
        left_sure, left_may = zip(*left, strict=True)
        right_sure, right_may = zip(*right, strict=True)
        values = []
        for region in range(self.regions.stored):
            last = region + reach
            surely = self.comes(left_sure, right_sure, wanted, region, last)
            last = self.last_asked(region, interval, last)
            values.append((surely, self.comes(left_may, right_may, wanted, region, last)))
        return values

    def last_asked(self, region: int, interval: Interval, last: int) -> int:
        """Up to which region a witness is possible: the finite horizon ends a release, a negated until."""
        known = self.regions.unknown
        if not self.finite_horizon or interval.upper is not None or known is None or region >= known:
            return last
        return known - 1

    def comes(
        self, left: Sequence[bool], right: Sequence[bool], wanted: list[bool], region: int, last: int
    ) -> bool:
        """Whether, from the instants of `region` on, `right` comes at a wanted distance, up to `last`."""
        for other in range(region, last + 1):
            index = self.regions.index(other)
            for distance in distances(region, other):
                # A witness inside an open region has instants of that region before it, unless it is now.
                covered = left[index] or other % 2 == 0 or distance == 0
                if wanted[distance] and right[index] and covered:
                    return True
            if not left[index]:
                return False
        return False


def distances(region: int, other: int) -> list[int]:
    """In which regions the distances from an instant of `region` to those of `other` lie."""
    if region % 2 == 1 and other % 2 == 1:
        return [d for d in (other - region - 1, other - region, other - region + 1) if d >= 0]
    return [other - region]


def negation(values: Values) -> Values:
    return [(not possibly, not surely) for surely, possibly in values]


def disjunction(*operands: Values) -> Values:
    rows = zip(*operands, strict=True)
    return [(any(surely for surely, _ in row), any(possibly for _, possibly in row)) for row in rows]


def both(row: tuple[tuple[bool, bool], ...]) -> tuple[bool, bool]:
    return all(surely for surely, _ in row), all(possibly for _, possibly in row)
