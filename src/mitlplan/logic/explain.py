"""In words: which part of a formula does not hold on a signal, when, and why.

The judge's sets of times are asked, from the whole down to the part that is to blame: the first conjunct that
fails, the first instant at which what should always hold does not, the side that an until misses. What needs
more than a sentence is only named.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from mitlplan.logic.formula import Always, And, Eventually, Formula, Implies, Not, Until
from mitlplan.logic.interval import Interval
from mitlplan.logic.interval_set import IntervalSet
from mitlplan.logic.semantics import truth
from mitlplan.logic.show import show
from mitlplan.logic.signal import Signal


def explain(
    formula: Formula,
    signal: Signal,
    *,
    until: Literal["standard", "closed"] = "standard",
    horizon: Literal["infinite", "finite"] = "infinite",
) -> str:
    """One sentence on why `formula` does not hold at time 0; if it does, the sentence says so.

    Parameters, errors and units are those of :func:`mitlplan.logic.semantics.satisfies`.

    Examples
    --------
    >>> from mitlplan.logic.parse import parse
    >>> from mitlplan.logic.signal import Segment
    >>> stops = Segment(Fraction(0), frozenset()), Segment(Fraction(3), frozenset({"dock"}))
    >>> explain(parse("F dock & F[0,2] dock"), Signal(stops, end=Fraction(4)))
    'F[0,2] dock does not hold at 0: dock never holds in [0,2].'
    """
    blame = _Blame(signal, until, horizon)
    zero = Fraction(0)
    return f"{blame.clause(formula, zero) if zero not in blame.holds(formula) else show(formula) + ' holds'}."


@dataclass(frozen=True, slots=True)
class _Blame:
    signal: Signal
    until: Literal["standard", "closed"]
    horizon: Literal["infinite", "finite"]

    def holds(self, formula: Formula) -> IntervalSet:
        return truth(formula, self.signal, until=self.until, horizon=self.horizon)

    @property
    def _end(self) -> Fraction | None:
        """The last instant that is known, if there is one."""
        return self.signal.end if self.signal.repeat_from is None else None

    def clause(self, formula: Formula, time: Fraction) -> str:
        """Why `formula` does not hold at `time`."""
        match formula:
            case And(operands):
                return self.clause(next(part for part in operands if time not in self.holds(part)), time)
            case Implies(left, right) if time in self.holds(left):
                return f"{show(left)} holds at {time}, but {self.clause(right, time)}"
            case Always(operand, interval):
                why = self._not_always(operand, self._asked(interval, time))
            case Eventually(operand, interval):
                why = self._never(operand, self._asked(interval, time))
            case Until(left, right, interval):
                why = self._not_until(left, right, self._asked(interval, time), time)
            case _:
                why = ""
        return f"{self._verdict(formula, time)}: {why}" if why else self._verdict(formula, time)

    def _verdict(self, formula: Formula, time: Fraction) -> str:
        if time in self.holds(Not(formula)):
            return f"{show(formula)} does not hold at {time}"
        return f"{show(formula)} is not decided at {time} by a signal that ends at {self.signal.end}"

    def _asked(self, interval: Interval, time: Fraction) -> Interval:
        """The times of which an operator speaks at `time`."""
        upper = None if interval.upper is None else interval.upper + time
        return Interval(interval.lower + time, upper, interval.lower_open, interval.upper_open)

    def _not_always(self, operand: Formula, asked: Interval) -> str:
        gap = _first_within(~self.holds(operand), asked)
        if gap is None or (gap.lower_open and gap.lower == self._end):
            return ""
        if gap.lower_open:
            return f"{show(operand)} does not hold {_begin(gap)}"
        return self.clause(operand, gap.lower)

    def _never(self, operand: Formula, asked: Interval) -> str:
        if self._end is not None and (asked.upper is None or asked.upper > self._end):
            return ""
        return f"{show(operand)} never holds in {asked}"

    def _not_until(self, left: Formula, right: Formula, asked: Interval, time: Fraction) -> str:
        wanted = And((left, right)) if self.until == "closed" else right
        come = _first_within(self.holds(wanted), asked)
        if come is None and (never := self._never(wanted, asked)):
            return never
        before = Interval(time) if come is None or come.lower == time else Interval(time, come.lower)
        gap = _first_within(~self.holds(left), before)
        if gap is None or (gap.lower_open and gap.lower == self._end):
            return ""
        missed = f"{show(left)} does not hold {_begin(gap)}"
        if come is None:
            return f"{missed}, and {show(wanted)} has not held before"
        return f"{show(wanted)} holds {_begin(come)} first, but {missed}"


def _begin(piece: Interval) -> str:
    return f"just after {piece.lower}" if piece.lower_open else f"at {piece.lower}"


def _first_within(times: IntervalSet, window: Interval) -> Interval | None:
    """The first piece of `times` in `window`, or ``None`` if there is none."""
    return next((piece for part in _from(times, window.lower) if (piece := _common(part, window))), None)


def _from(times: IntervalSet, start: Fraction) -> Iterator[Interval]:
    """The pieces of `times` in order, from the repetition in which `start` lies to the end of the next."""
    repeat_from = times.axis.repeat_from * times.axis.tick
    period = times.axis.end * times.axis.tick - repeat_from
    pieces = list(times.intervals())
    passed = max(0, (start - repeat_from) // period)
    if passed == 0:
        yield from pieces
    loop = Interval(repeat_from, repeat_from + period, upper_open=True)
    for rounds in (passed, passed + 1):
        for piece in pieces:
            part = _common(piece, loop)
            if part is not None and part.upper is not None and rounds > 0:
                late = rounds * period
                yield Interval(part.lower + late, part.upper + late, part.lower_open, part.upper_open)


def _common(one: Interval, other: Interval) -> Interval | None:
    lower, lower_open = max((one.lower, one.lower_open), (other.lower, other.lower_open))
    ends = [(each.upper, not each.upper_open) for each in (one, other) if each.upper is not None]
    if not ends:
        return Interval(lower, None, lower_open)
    upper, closed = min(ends)
    if upper < lower or (upper == lower and (lower_open or not closed)):
        return None
    return Interval(lower, upper, lower_open, not closed)
