"""The repaired construction: the paper's idea with transducers that are right.

Every temporal part of the formula has one transducer, which says what is true (two-sided: yes and no), so a
negation costs nothing and G is not F not, as in the paper. Lower bounds are delays; an until with an interval
is rewritten as the paper does, the second only where q implies p (the closed until),

    p U[0,b] q = (p U q) & F[0,b] q        p U[a,b] q = G[0,a](p U q) & F[a,b] q.

Right-continuous signals only: with a bound that is open, or a standard until with a lower bound above 0, the
truth of a part may hold or begin at a single instant, which these transducers cannot say. Such formulas are
refused; the compact construction has them.
"""

from __future__ import annotations

from enum import Enum
from fractions import Fraction
from itertools import count

from mitlplan.automata.transducer import Transducer
from mitlplan.errors import TranslationError
from mitlplan.logic.core import (
    TRUE,
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Disjunction,
    Literal,
    Truth,
    negate,
    propositional,
)
from mitlplan.logic.interval import Interval
from mitlplan.translation.compact.translate import Obligations, name_of
from mitlplan.translation.seed import two_sided
from mitlplan.translation.seed.exact_transducers import outstanding_pairs
from mitlplan.translation.seed.two_sided import DelayClocks, Value

MOST_PAIRS = 64
"""Longer delays are refused: each pair of outstanding edges has two clocks."""


def translate(core: Core, *, until_the_end: bool = False) -> Obligations:
    """The transducers that together guarantee `core` at time 0.

    Parameters
    ----------
    core
        The formula.
    until_the_end
        Whether ``G``, ``R`` and ``W`` without an upper bound speak only of the time up to the end of a finite
        plan (``horizon: finite``).

    Raises
    ------
    TranslationError
        If a part of the formula may be true at a single instant (see above), or needs too many clocks.

    Examples
    --------
    >>> from mitlplan.logic.core import eventually
    >>> formula = eventually(Literal("A"), Interval(Fraction(0), Fraction(2)))
    >>> [transducer.name for transducer in translate(formula).transducers]
    ['the mission', 'F[0,2] A']
    """
    translator = _Translator(until_the_end, _asked_parts(core))
    mission = translator.value_of(core)
    askers_first = (two_sided.root(mission), *reversed(translator.transducers))
    return Obligations(askers_first, translator.predicates)


class _Asked(Enum):
    """When a part is asked what it is; to be ready to be asked again costs states."""

    ONCE = "once"
    THROUGHOUT = "throughout"
    AGAIN = "again"


def _asked_parts(core: Core) -> dict[Core, _Asked]:
    """How each part is asked, of `core` at time 0; parts as they are translated, without their negations."""
    found: dict[Core, _Asked] = {}
    pending = [(core, _Asked.ONCE)]
    while pending:
        part, asked = pending.pop()
        if propositional(part) or found.get(part) == _Asked.AGAIN:
            continue
        if isinstance(part, Disjunction):
            # One operand is asked now, and perhaps another one later.
            pending.append((negate(part), _Asked.ONCE if asked == _Asked.ONCE else _Asked.AGAIN))
        elif isinstance(part, CoreRelease):
            pending.append((negate(part), asked))
        else:
            found[part] = _Asked.AGAIN if part in found else asked
            pending += _asked_operands(part, found[part])
    return found


def _asked_operands(part: Core, asked: _Asked) -> list[tuple[Core, _Asked]]:
    after = _Asked.THROUGHOUT if asked == _Asked.ONCE else _Asked.AGAIN
    match part:
        case Conjunction(operands):
            return [(operand, asked) for operand in operands]
        case CoreUntil(left, right, Interval(lower, upper)) if upper is not None and lower > 0:
            inner = CoreUntil(TRUE, right, Interval(Fraction(0), upper - lower))
            return [(inner, after), *((each, _Asked.AGAIN) for each in (left, right) if left != TRUE)]
        case CoreUntil(left, right, Interval(lower, upper)):
            single = left == TRUE if upper is not None else lower == 0
            return [(each, after if single else _Asked.AGAIN) for each in (left, right)]
        case _:
            return []


class _Translator:
    """Translates every part once, operands first."""

    def __init__(self, until_the_end: bool, asked: dict[Core, _Asked]) -> None:
        self._asked = asked
        self.transducers: list[Transducer] = []
        self.predicates: dict[str, Core] = {}
        self._until_the_end = until_the_end
        self._values: dict[Core, Value] = {}
        self._untils: dict[tuple[Core, bool], Value] = {}
        self._numbers = count()

    def value_of(self, core: Core) -> Value:
        """Where the truth of `core` is said."""
        if core not in self._values:
            self._values[core] = self._make(core)
        return self._values[core]

    def _make(self, core: Core) -> Value:
        if propositional(core):
            return self._predicate(core)
        match core:
            case Conjunction(operands):
                return self._conjunction(core, [self.value_of(operand) for operand in operands])
            case Disjunction() | CoreRelease():
                return self.value_of(negate(core)).negated
            case CoreUntil(left, right, interval):
                return self._until(left, right, interval)
            case Truth() | Literal():
                return self._predicate(core)

    def _predicate(self, core: Core) -> Value:
        value = two_sided.value(next(self._numbers), label=True)
        self.predicates |= {value.yes: core, value.no: negate(core)}
        return value

    def _fresh(self) -> Value:
        return two_sided.value(next(self._numbers))

    def _conjunction(self, core: Core, operands: list[Value]) -> Value:
        value = self._fresh()
        self.transducers.append(two_sided.conjunction(name_of(core), tuple(operands), value))
        return value

    def _until(self, left: Core, right: Core, interval: Interval) -> Value:
        lower, upper = interval.lower, interval.upper
        core = CoreUntil(left, right, interval)
        if interval.lower_open or (upper is not None and interval.upper_open):
            raise TranslationError(
                f"the seed construction has no transducer for {name_of(core)}, whose open bound asks for "
                "single instants; use closed bounds, or the compact construction"
            )
        if lower > 0 and left != TRUE and not _implies(right, left):
            raise TranslationError(
                f"the seed construction has no transducer for {name_of(core)}, a standard until with a lower "
                "bound above 0; use until: closed, or the compact construction"
            )
        again = self._asked[core] == _Asked.AGAIN
        if upper is None:
            if lower > 0 and self._until_the_end:
                raise TranslationError(
                    f"the seed construction has no {name_of(core)} for horizon: finite; use the compact "
                    "construction"
                )
            return self._lasting(left, right, lower, until_the_end=self._until_the_end, again=again)
        timed = self._eventually(right, lower, upper, again=again)
        if left == TRUE:
            return timed
        lasting = self._lasting(left, right, lower, until_the_end=False, again=again)
        return self._conjunction(core, [lasting, timed])

    def _lasting(
        self, left: Core, right: Core, lower: Fraction, *, until_the_end: bool, again: bool
    ) -> Value:
        """``G[0,lower] (left U right)``."""
        core = CoreUntil(left, right)
        value = self._unbounded(core, until_the_end=until_the_end)
        if lower == 0:
            return value
        return self._within(f"F[0,{lower}] !({name_of(core)})", value.negated, lower, again=again).negated

    def _unbounded(self, core: CoreUntil, *, until_the_end: bool) -> Value:
        if (core, until_the_end) not in self._untils:
            operands = self.value_of(core.left), self.value_of(core.right)
            value = self._fresh()
            transducer = two_sided.until(name_of(core), *operands, value, until_the_end=until_the_end)
            self.transducers.append(transducer)
            self._untils[core, until_the_end] = value
        return self._untils[core, until_the_end]

    def _eventually(self, operand: Core, lower: Fraction, upper: Fraction, *, again: bool) -> Value:
        value, length = self.value_of(operand), upper - lower
        name = name_of(CoreUntil(TRUE, operand, Interval(lower, upper)))
        if length == 0:
            raise TranslationError(
                f"the seed construction has no transducer for {name}; widen the interval, or use the compact "
                "construction"
            )
        if lower == 0:
            return self._within(name, value, upper, again=again)
        pairs = outstanding_pairs(lower, length)
        if pairs > MOST_PAIRS:
            raise TranslationError(
                f"{name} needs {2 * pairs} clocks, because its delay is long and its interval short; "
                f"at most {2 * MOST_PAIRS} are allowed"
            )
        inner = self.value_of(CoreUntil(TRUE, operand, Interval(Fraction(0), length)))
        return self._delayed(name, inner, lower, pairs, again=again)

    def _within(self, name: str, operand: Value, most: Fraction, *, again: bool) -> Value:
        value = self._fresh()
        clock = f"x{value.yes}"
        self.transducers.append(two_sided.eventually_within(name, most, operand, value, clock, again=again))
        return value

    def _delayed(self, name: str, operand: Value, seconds: Fraction, pairs: int, *, again: bool) -> Value:
        value = self._fresh()
        edges = tuple(f"c{index}.{value.yes}" for index in range(2 * pairs))
        clocks = DelayClocks(f"s{value.yes}", edges, f"e{value.yes}")
        self.transducers.append(two_sided.delay(name, seconds, operand, value, clocks, again=again))
        return value


def _implies(core: Core, weaker: Core) -> bool:
    """Whether `core` is plainly a conjunction that contains `weaker`."""
    parts = frozenset(core.operands if isinstance(core, Conjunction) else (core,))
    wanted = frozenset(weaker.operands if isinstance(weaker, Conjunction) else (weaker,))
    return wanted <= parts
