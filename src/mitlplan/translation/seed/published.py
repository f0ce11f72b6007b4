"""The construction of Zhou, Maity and Baras exactly as published: formula automaton, product, acceptance.

UNSOUND, kept for comparison with the paper (its Figs. 7 to 9 and Table I): docs/paper.md has the faults, each
with a run. The formula is rewritten to atoms, not, and, or, untimed until and release, and timed eventually;
every operator becomes a transducer (:mod:`mitlplan.translation.seed.published_transducers`), and these are
composed from the leaves up. A timed eventually feeds its guess upwards and leaves a checker behind, which
shares nothing with the rest but clocks. The until is the closed one of the paper's Definition 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from typing import TypeAlias, Union

from mitlplan.automata.iota import BuechiSets, Iota, Parts, compose
from mitlplan.errors import TranslationError
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
from mitlplan.translation.seed import published_transducers as elementary
from mitlplan.translation.seed.published_transducers import Clocks, Flavour


def published_buechi(parent: Iota, children: Sequence[Iota], parts: Sequence[Parts]) -> BuechiSets:
    """The paper's rule F = (F1 & F2) | F3: the children's sets at the same time, or the parent's.

    Wrong twice: a promise inside the operands may be dropped, and promises kept in turn are not seen.
    """
    own = frozenset[int]().union(*parent.buechi)
    theirs = [frozenset[int]().union(*child.buechi) for child in children]
    accepting = frozenset(
        index
        for index, part in enumerate(parts)
        if part[0] in own or all(at in accepted for at, accepted in zip(part[1:], theirs, strict=True))
    )
    return (accepting,) if accepting else ()


@dataclass(frozen=True, slots=True)
class PublishedAutomaton:
    """What a formula becomes.

    Parameters
    ----------
    main
        Writes the truth of the formula; reads atoms, or guesses.
    checkers
        One for each timed eventually, in the order in which these are written.
    """

    main: Iota
    checkers: tuple[Iota, ...]

    @property
    def size(self) -> tuple[int, int]:
        """The numbers of locations and of edges, as the paper counts them: all side by side."""
        sizes = [automaton.size for automaton in (*self.checkers, self.main)]
        return sum(locations for locations, _ in sizes), sum(edges for _, edges in sizes)

    @property
    def clocks(self) -> tuple[str, ...]:
        """Every clock, in the order of creation."""
        together = dict.fromkeys(clock for each in (self.main, *self.checkers) for clock in each.clocks)
        return tuple(sorted(together, key=clock_number))


def clock_name(number: int) -> str:
    """The paper's name for the clock with that number: an element of the array ``z``."""
    return f"z[{number}]"


def clock_number(name: str) -> int:
    """The number of the clock called `name` by :func:`clock_name`."""
    return int(name[2:-1])


def event_name(number: int) -> str:
    """The channel on which the checker with that number tells that it has verified a first falling edge."""
    return f"ch[{number}]"


def published_automaton(formula: Formula, *, flavour: Flavour = Flavour.PAPER) -> PublishedAutomaton:
    """Translate `formula` as the paper does.

    Raises
    ------
    TranslationError
        If the paper has no transducer for an operator or an interval.

    Examples
    --------
    >>> soon = Eventually(Atom("A"), Interval(Fraction(0), Fraction(2)))
    >>> published_automaton(Always(soon)).size
    (17, 27)
    """
    return _Builder(flavour).build(rewrite(formula))


class _Builder:
    """Hands out clocks and channels in the order in which the published program does."""

    def __init__(self, flavour: Flavour) -> None:
        self._flavour = flavour
        self._clocks: Clocks = (clock_name(number) for number in count())
        self._checkers = count()

    def build(self, formula: Rewritten) -> PublishedAutomaton:
        match formula:
            case Constant(value):
                return PublishedAutomaton(elementary.constant(value), ())
            case Atom(name):
                return PublishedAutomaton(elementary.atom(name, self._clocks), ())
            case RewrittenNot(operand):
                inner = self.build(operand)
                parent = elementary.negation(self._clocks)
                return PublishedAutomaton(
                    compose(parent, inner.main, buechi=published_buechi), inner.checkers
                )
            case Binary(operator, left, right):
                first, second = self.build(left), self.build(right)
                parent = _BINARY[operator](self._clocks)
                return PublishedAutomaton(
                    compose(parent, first.main, second.main, buechi=published_buechi),
                    first.checkers + second.checkers,
                )
            case TimedEventually(operand, least, most):
                return self._timed(operand, least, most)

    def _timed(self, operand: Rewritten, least: Fraction, most: Fraction) -> PublishedAutomaton:
        inner = self.build(operand)
        operator = elementary.timed_eventually(least, most, self._clocks)
        verified = event_name(next(self._checkers))
        checker = elementary.checker(operator, self._flavour, verified)
        return PublishedAutomaton(
            elementary.generator(operator, self._flavour),
            (*inner.checkers, compose(checker, inner.main, buechi=published_buechi)),
        )


_BINARY = {
    "&": elementary.conjunction,
    "|": elementary.disjunction,
    "U": elementary.until,
    "R": elementary.release,
}


@dataclass(frozen=True, slots=True)
class RewrittenNot:
    """``!f``."""

    operand: Rewritten


@dataclass(frozen=True, slots=True)
class Binary:
    """``f & g``, ``f | g``, ``f U g`` or ``f R g``, without an interval."""

    operator: str
    left: Rewritten
    right: Rewritten


@dataclass(frozen=True, slots=True)
class TimedEventually:
    """``F_[least,most] f``."""

    operand: Rewritten
    least: Fraction
    most: Fraction


Rewritten: TypeAlias = Union[Constant, Atom, RewrittenNot, Binary, TimedEventually]
"""A formula in the operators that the paper has transducers for."""


def rewrite(formula: Formula) -> Rewritten:
    """Write `formula` in the paper's operators, as the paper does.

    Raises
    ------
    TranslationError
        If it cannot be done.

    Examples
    --------
    >>> rewrite(Always(Atom("A")))
    Binary(operator='R', left=Constant(value=False), right=Atom(name='A'))
    """
    match formula:
        case Constant() | Atom():
            return formula
        case Not(operand):
            return RewrittenNot(rewrite(operand))
        case And(operands):
            return _chain("&", [rewrite(operand) for operand in operands])
        case Or(operands):
            return _chain("|", [rewrite(operand) for operand in operands])
        case Implies(left, right):
            return Binary("|", RewrittenNot(rewrite(left)), rewrite(right))
        case Iff(left, right):
            one, other = rewrite(left), rewrite(right)
            neither = Binary("&", RewrittenNot(one), RewrittenNot(other))
            return Binary("|", Binary("&", one, other), neither)
        case Eventually(operand, interval):
            return _eventually(rewrite(operand), interval)
        case Always(operand, interval):
            inner = rewrite(operand)
            if interval.unrestricted:
                return Binary("R", Constant(False), inner)
            return RewrittenNot(_eventually(RewrittenNot(inner), interval))
        case Until(left, right, interval):
            return _until(rewrite(left), rewrite(right), interval)
        case Release(left, right, interval):
            if interval.unrestricted:
                return Binary("R", rewrite(left), rewrite(right))
            denied = _until(RewrittenNot(rewrite(left)), RewrittenNot(rewrite(right)), interval)
            return RewrittenNot(denied)
        case WeakUntil(left, right):
            one, other = rewrite(left), rewrite(right)
            return Binary("|", Binary("R", Constant(False), one), Binary("U", one, other))
        case Next():
            raise TranslationError(
                "the published construction has no transducer for X; use the compact construction"
            )


def _chain(operator: str, operands: list[Rewritten]) -> Rewritten:
    first, *rest = operands
    for operand in rest:
        first = Binary(operator, first, operand)
    return first


def _eventually(operand: Rewritten, interval: Interval) -> Rewritten:
    if interval.unrestricted:
        return Binary("U", Constant(True), operand)
    least, most = _closed(interval)
    return TimedEventually(operand, least, most)


def _until(left: Rewritten, right: Rewritten, interval: Interval) -> Rewritten:
    """``p U_[a,b] q`` is ``G_[0,a](p U q) & F_[a,b] q``; with a = 0 the first part is ``p U q``."""
    untimed = Binary("U", left, right)
    if interval.unrestricted:
        return untimed
    least, most = _closed(interval)
    timed = TimedEventually(right, least, most)
    if least == 0:
        return Binary("&", untimed, timed)
    denied = Binary("R", RewrittenNot(left), RewrittenNot(right))
    return Binary("&", RewrittenNot(TimedEventually(denied, Fraction(0), least)), timed)


def _closed(interval: Interval) -> tuple[Fraction, Fraction]:
    if interval.upper is None or interval.lower_open or interval.upper_open or interval.punctual:
        raise TranslationError(
            f"the published construction knows closed intervals [a,b] with a < b only, not {interval}; "
            "use the compact construction"
        )
    return interval.lower, interval.upper
