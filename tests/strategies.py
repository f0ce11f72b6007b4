"""What Hypothesis draws, and how often: intervals, formulas as written, formulas in normal form, signals.

Every strategy is small by default, since most properties show on small cases, and takes as arguments what a
test wants to leave out: open ends, infinite ends, single instants.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from fractions import Fraction

from hypothesis import settings
from hypothesis import strategies as st

from mitlplan.logic.core import FALSE, TRUE, Core, Literal, conjunction, disjunction, release, until
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
from mitlplan.logic.interval import Interval
from mitlplan.logic.one_shot import repeated_instants
from mitlplan.logic.signal import Segment, Signal

ATOMS = ("A", "B")


def as_many(factor: int) -> settings:
    """So many times as many cases as the profile says, where a case takes little time."""
    return settings(max_examples=factor * settings().max_examples)


def times(longest: int = 4, denominator: int = 2) -> st.SearchStrategy[Fraction]:
    """Times from 0 to `longest`, multiples of 1/`denominator`."""
    return st.integers(0, longest * denominator).map(lambda ticks: Fraction(ticks, denominator))


@st.composite
def intervals(
    draw: st.DrawFn,
    *,
    longest: int = 4,
    denominator: int = 2,
    open_bounds: bool = True,
    unbounded: bool = True,
    punctual: bool = False,
    trivial: bool = True,
) -> Interval:
    """Intervals that are not empty; `punctual` allows ``[a,a]``, `trivial` then ``[0,0]`` as well."""
    lower = draw(times(longest, denominator))
    lower_open = open_bounds and draw(st.booleans())
    if unbounded and draw(st.integers(0, 3)) == 0:
        return Interval(lower, None, lower_open)
    length = draw(times(longest, denominator))
    if length == 0:
        if punctual and (lower > 0 or trivial):
            return Interval(lower, lower)
        length = Fraction(1, denominator)
    return Interval(lower, lower + length, lower_open, open_bounds and draw(st.booleans()))


def formulas(
    atoms: Sequence[str] = ATOMS,
    *,
    depth: int = 3,
    longest: int = 4,
    denominator: int = 2,
    open_bounds: bool = True,
    unbounded: bool = True,
    punctual: bool = False,
    trivial: bool = True,
) -> st.SearchStrategy[Formula]:
    """Formulas as a user may write them; punctual operators and X only in one-shot positions.

    Without `trivial` there are no constants, and no ``[0,0]``.
    """
    subscripts = intervals(
        longest=longest,
        denominator=denominator,
        open_bounds=open_bounds,
        unbounded=unbounded,
        punctual=punctual,
        trivial=trivial,
    )
    leaf: st.SearchStrategy[Formula] = st.sampled_from(tuple(atoms)).map(Atom)
    if trivial:
        # Constants are folded at once: most leaves are atoms, or little would be left to test.
        leaf = st.one_of(*[leaf] * 5, st.booleans().map(Constant))
    drawn = _formulas(leaf, depth, subscripts, unbounded=unbounded, punctual=punctual)
    return drawn.map(_with_instants_only_once)


def _with_instants_only_once(formula: Formula) -> Formula:
    return _without_instants(formula) if any(repeated_instants(formula)) else formula


def _without_instants(formula: Formula) -> Formula:
    """The formula with some time in place of every instant."""
    parts: dict[str, object] = {}
    for field in fields(formula):
        match getattr(formula, field.name):
            case tuple(operands):
                parts[field.name] = tuple(_without_instants(operand) for operand in operands)
            case Interval(lower, upper) if lower == upper:
                parts[field.name] = Interval(lower, lower + 1)
            case Interval() | bool() | str():
                pass
            case operand:
                parts[field.name] = _without_instants(operand)
    if isinstance(formula, Next):
        return Eventually(**parts)
    return replace(formula, **parts)


def _formulas(
    leaf: st.SearchStrategy[Formula],
    depth: int,
    subscripts: st.SearchStrategy[Interval],
    *,
    unbounded: bool,
    punctual: bool,
) -> st.SearchStrategy[Formula]:
    if depth == 0:
        return leaf
    part = st.deferred(lambda: _formulas(leaf, depth - 1, subscripts, unbounded=unbounded, punctual=punctual))
    parts = st.lists(part, min_size=2, max_size=3).map(tuple)
    nodes: list[st.SearchStrategy[Formula]] = [
        leaf,
        st.builds(Not, part),
        st.builds(And, parts),
        st.builds(Or, parts),
        st.builds(Implies, part, part),
        st.builds(Iff, part, part),
        st.builds(Eventually, part, subscripts),
        st.builds(Always, part, subscripts),
        st.builds(Until, part, part, subscripts),
        st.builds(Release, part, part, subscripts),
    ]
    if unbounded:
        nodes.append(st.builds(WeakUntil, part, part))
    if punctual:
        nodes.append(st.builds(Next, part))
    return st.one_of(nodes)


def core_formulas(
    atoms: Sequence[str] = ATOMS,
    *,
    depth: int = 3,
    longest: int = 4,
    denominator: int = 2,
    open_bounds: bool = True,
    unbounded: bool = True,
) -> st.SearchStrategy[Core]:
    """Formulas in normal form, as the constructors of the core leave them; no punctual ones."""
    subscripts = intervals(
        longest=longest, denominator=denominator, open_bounds=open_bounds, unbounded=unbounded
    )
    literals = st.builds(Literal, st.sampled_from(tuple(atoms)), st.booleans())
    return _core_formulas(literals, depth, subscripts)


def _core_formulas(
    literals: st.SearchStrategy[Core], depth: int, subscripts: st.SearchStrategy[Interval]
) -> st.SearchStrategy[Core]:
    if depth == 0:
        return literals
    part = st.deferred(lambda: _core_formulas(literals, depth - 1, subscripts))
    return st.one_of(
        literals,
        st.builds(conjunction, part, part),
        st.builds(disjunction, part, part),
        st.builds(until, st.one_of(st.just(TRUE), part), part, subscripts),
        st.builds(release, st.one_of(st.just(FALSE), part), part, subscripts),
    )


@st.composite
def signals(
    draw: st.DrawFn,
    atoms: Sequence[str] = ATOMS,
    *,
    segments: int = 4,
    denominator: int = 2,
    repeating: bool | None = None,
) -> Signal:
    """Right-continuous signals: repeating ones, ones that end, or (``repeating=None``) either."""
    lengths = draw(st.lists(st.integers(1, 2 * denominator), min_size=1, max_size=segments))
    labels = [draw(st.frozensets(st.sampled_from(tuple(atoms)))) for _ in lengths]
    starts = [Fraction(sum(lengths[:index]), denominator) for index in range(len(lengths) + 1)]
    parts = tuple(Segment(start, label) for start, label in zip(starts, labels, strict=False))
    if draw(st.booleans()) if repeating is None else repeating:
        back = draw(st.integers(0, sum(lengths) - 1))
        return Signal(parts, starts[-1], Fraction(back, denominator))
    # The label entered at the very end is known at that instant only.
    end = draw(st.sampled_from((starts[-1], starts[-2])))
    return Signal(parts, end)
