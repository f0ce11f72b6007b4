"""Signals in short, and random signals and formulas on a grid of whole seconds as Hypothesis strategies.

The labels change and the bounds lie at whole seconds, where coincidences are frequent: they are what tells
one end of an interval from the other.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate, combinations

from hypothesis import strategies as st

from mitlplan.logic import formula as f
from mitlplan.logic.interval import ALWAYS, Interval
from mitlplan.logic.signal import Segment, Signal

ATOMS = ("a", "b")


def ending(text: str) -> Signal:
    """A signal that ends, from labels and durations: ``"- 1, AB 1/2, A 0"``; atoms are single letters."""
    segments, end = _read(text)
    return Signal(tuple(segments), end)


def looping(text: str, repeat_from: int | str = 0) -> Signal:
    """A signal that repeats, from labels and durations."""
    segments, end = _read(text)
    return Signal(tuple(segments), end, Fraction(repeat_from))


def _read(text: str) -> tuple[list[Segment], Fraction]:
    segments, start = [], Fraction(0)
    for part in text.split(","):
        label, duration = part.split()
        segments.append(Segment(start, frozenset(label.replace("-", ""))))
        start += Fraction(duration)
    return segments, start


def stretches(atoms: tuple[str, ...]) -> st.SearchStrategy[tuple[tuple[Segment, ...], int]]:
    """Segments in order, and the start of the one that would come next."""
    labels = [frozenset(chosen) for size in range(len(atoms) + 1) for chosen in combinations(atoms, size)]
    stays = st.sampled_from([(label, duration) for duration in (1, 2, 3) for label in labels])
    return st.lists(stays, min_size=1, max_size=6).map(_in_order)


def _in_order(stays: list[tuple[frozenset[str], int]]) -> tuple[tuple[Segment, ...], int]:
    starts = list(accumulate((duration for _, duration in stays), initial=0))
    segments = (Segment(Fraction(start), label) for (label, _), start in zip(stays, starts, strict=False))
    return tuple(segments), starts[-1]


@st.composite
def looping_signals(draw: st.DrawFn, atoms: tuple[str, ...] = ATOMS) -> Signal:
    """Signals that repeat, from anywhere, also from within a segment."""
    segments, end = draw(stretches(atoms))
    return Signal(segments, Fraction(end), Fraction(draw(st.integers(0, end - 1))))


@st.composite
def ending_signals(draw: st.DrawFn, atoms: tuple[str, ...] = ATOMS) -> Signal:
    """Signals that end, also at the very start of the last segment."""
    segments, end = draw(stretches(atoms))
    last = int(segments[-1].start)
    return Signal(segments, Fraction(draw(st.integers(last, end))))


@st.composite
def continuations(draw: st.DrawFn, signal: Signal, atoms: tuple[str, ...] = ATOMS) -> Signal:
    """Signals that repeat and agree with a signal that ends as long as that lasts."""
    wait = Fraction(draw(st.integers(1, 4)), 2)
    more, length = draw(stretches(atoms))
    later = [Segment(signal.end + wait + segment.start, segment.holds) for segment in more]
    end = signal.end + wait + length
    repeat_from = Fraction(draw(st.integers(0, int(2 * end) - 1)), 2)
    return Signal((*signal.segments, *later), end, repeat_from)


@st.composite
def intervals(draw: st.DrawFn, largest: int = 4) -> Interval:
    """Intervals with whole ends: open, closed, punctual, unbounded."""
    lower = Fraction(draw(st.integers(0, largest)))
    if draw(st.integers(0, 3)) == 0:
        return Interval(lower, None, draw(st.booleans()))
    upper = Fraction(draw(st.integers(int(lower), largest)))
    if lower == upper:
        return Interval(lower, upper)
    return Interval(lower, upper, draw(st.booleans()), draw(st.booleans()))


def formulas(atoms: tuple[str, ...] = ATOMS, leaves: int = 5) -> st.SearchStrategy[f.Formula]:
    """Formulas with every operator in every place."""
    literal: st.SearchStrategy[f.Formula] = st.sampled_from(atoms).map(f.Atom)
    base = st.one_of(literal, literal, literal, st.booleans().map(f.Constant))
    return st.recursive(base, _wider, max_leaves=leaves)


def _wider(inner: st.SearchStrategy[f.Formula]) -> st.SearchStrategy[f.Formula]:
    bounds = st.one_of(st.just(ALWAYS), intervals(), intervals())
    several = st.lists(inner, min_size=2, max_size=3).map(tuple)
    return st.one_of(
        st.builds(f.Not, inner),
        st.builds(f.And, several),
        st.builds(f.Or, several),
        st.builds(f.Implies, inner, inner),
        st.builds(f.Iff, inner, inner),
        st.builds(f.Eventually, inner, bounds),
        st.builds(f.Always, inner, bounds),
        st.builds(f.Next, inner),
        st.builds(f.Until, inner, inner, bounds),
        st.builds(f.Until, inner, inner, bounds),
        st.builds(f.Release, inner, inner, bounds),
        st.builds(f.WeakUntil, inner, inner),
    )
