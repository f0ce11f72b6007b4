"""The compact construction: one small transducer for each temporal part of the formula.

Each is one-sided (:mod:`mitlplan.translation.compact.claims`). Parts in one-shot positions get a transducer
of their own for every place they stand in; a part that may be claimed again and again shares one transducer
however often it occurs. A lower bound above 0 is a delay line, or is rewritten where that is cheaper:

    p U[a,b] q = G[0,a) p & G[0,a](p U q) & F[a,b] q        and its dual,

where an upper bound of infinity drops the last conjunct. In the paper's construction every interval costs
2m + 1 clocks; here an operator under none but "and" and "or" needs no clock but the time, and [0,b] needs
one anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction
from graphlib import TopologicalSorter

from mitlplan.automata.transducer import Edge, Location, Transducer
from mitlplan.errors import TranslationError
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
from mitlplan.logic.normalize import written
from mitlplan.logic.show import show
from mitlplan.translation.compact.choice import choice
from mitlplan.translation.compact.claims import Claim, Demand, Operands, edge, made
from mitlplan.translation.compact.delay_line import recorder, recorder_count, smoother
from mitlplan.translation.compact.one_shot import release_once, until_once
from mitlplan.translation.compact.repeated import release_repeated, until_repeated

MAXIMAL_RECORDERS = 64
"""Delay lines longer than this are refused: each recorder has two clocks."""


@dataclass(frozen=True)
class Obligations:
    """A formula as transducers, emitters before readers, and the meaning of the predicates they read."""

    transducers: tuple[Transducer, ...]
    predicates: dict[str, Core]


def translate(core: Core, *, until_the_end: bool = False) -> Obligations:
    """The transducers that together guarantee `core` at time 0.

    Parameters
    ----------
    core
        The formula.
    until_the_end
        Whether ``G``, ``R`` and ``W`` without an upper bound speak only of the time up to the end of a
        finite plan (``horizon: finite``).

    Raises
    ------
    TranslationError
        If a delay is so long against the width of its interval that a delay line would need too many clocks.

    Examples
    --------
    >>> from mitlplan.logic.core import Literal, eventually
    >>> [transducer.name for transducer in translate(eventually(Literal("A"))).transducers]
    ['start', 'F A']
    """
    return _Translator(until_the_end).run(core)


@dataclass(frozen=True, slots=True)
class _Part:
    """What a repeated transducer is shared by: a formula and how it treats the end of the mission."""

    core: Core
    until_the_end: bool
    vacuous_at_end: bool = False


@dataclass
class _Translator:
    until_the_end: bool
    predicates: dict[str, Core] = field(default_factory=dict)
    made: dict[int, Transducer] = field(default_factory=dict)
    shared: dict[_Part, Claim] = field(default_factory=dict)
    numbers: int = 0

    def run(self, core: Core) -> Obligations:
        root = self.demand(core, once=True, at_start=True)
        start = Transducer(
            "start",
            (Location("start"), Location("running")),
            made((edge("start", "running", at_point=(root,)), Edge("running", "running"))),
            made((edge("start", "running", at_point=(root,)), Edge("running", "running"))),
            made(
                (
                    edge("start", "running", at_point=(self.parked(core),)),
                    Edge("running", "running"),
                )
            ),
        )
        return Obligations(_in_order((start, *self.made.values())), self.predicates)

    def number(self) -> int:
        self.numbers += 1
        return self.numbers

    def predicate(self, core: Core) -> Demand:
        """The demand that the label satisfies a propositional formula."""
        match core:
            case Truth(value):
                return Demand(impossible=not value)
            case _:
                name = name_of(core)
                self.predicates[name] = core
                return Demand(frozenset((name,)))

    def parked(self, core: Core) -> Demand:
        """The demand that `core` holds if the label never changes again."""
        return self.predicate(constant_value(core))

    def demand(self, core: Core, *, once: bool, at_start: bool = False) -> Demand:
        """What must hold for `core` to hold; makes the transducers that see to it."""
        if propositional(core):
            return self.predicate(core)
        match core:
            case Conjunction(operands):
                label = conjunction(*(part for part in operands if propositional(part)))
                demands = [self.predicate(label)]
                demands += [
                    self.demand(part, once=once, at_start=at_start)
                    for part in operands
                    if not propositional(part)
                ]
                return Demand(
                    frozenset().union(*(demand.predicates for demand in demands)),
                    frozenset().union(*(demand.claims for demand in demands)),
                    any(demand.impossible for demand in demands),
                )
            case Disjunction() if once:
                return _claiming(self.make_choice(core, once=True, at_start=at_start))
            case CoreRelease(left) if once and not _begins_attained(left) and not _punctual(core):
                return self.repeated(_Part(core, self.until_the_end))
            case CoreUntil() | CoreRelease() if once:
                return _claiming(self.make_once(core, at_start=at_start))
            case _:
                return self.repeated(_Part(core, self.until_the_end))

    def make_choice(self, core: Disjunction, *, once: bool, at_start: bool) -> Claim:
        claim = Claim(self.number())
        label = disjunction(*(part for part in core.operands if propositional(part)))
        others = tuple(
            self.demand(part, once=once, at_start=at_start)
            for part in core.operands
            if not propositional(part)
        )
        self.made[claim.number] = choice(
            name_of(core), claim, self.predicate(label), others, self.parked(core)
        )
        return claim

    def make_once(self, core: CoreUntil | CoreRelease, *, at_start: bool) -> Claim:
        claim = Claim(self.number())
        match core:
            case CoreUntil(left, right, interval):
                operands = self.operands(core, self.demand(left, once=False), self.demand(right, once=True))
                self.made[claim.number] = until_once(
                    name_of(core), claim, interval, operands, at_start=at_start
                )
            case CoreRelease(left, right, interval):
                operands = self.operands(core, self.demand(left, once=True), self.demand(right, once=False))
                self.made[claim.number] = release_once(
                    name_of(core),
                    claim,
                    interval,
                    operands,
                    at_start=at_start,
                    until_the_end=self.until_the_end,
                )
        return claim

    def operands(self, core: CoreUntil | CoreRelease, left: Demand, right: Demand) -> Operands:
        necessary = necessary_label(core.right)
        target = "" if necessary == TRUE else next(iter(self.predicate(necessary).predicates), "")
        left_value, right_value = constant_value(core.left), constant_value(core.right)
        return Operands(
            left,
            right,
            parked_left=self.predicate(left_value),
            parked_right=self.predicate(right_value),
            parked_either=self.predicate(disjunction(left_value, right_value)),
            parked=self.parked(core),
            target=target,
        )

    def repeated(self, part: _Part) -> Demand:
        """The claim of a part that may be claimed any number of times, at any time."""
        if propositional(part.core):
            return self.predicate(part.core)
        if isinstance(part.core, Conjunction):
            return self.demand(part.core, once=False)
        if part not in self.shared:
            match part.core:
                case Disjunction():
                    claim = self.make_choice(part.core, once=False, at_start=False)
                case CoreUntil(_, _, interval) | CoreRelease(_, _, interval) if interval.lower == 0:
                    claim = self.make_repeated(part)
                case CoreUntil(left, _, interval) if left == TRUE and interval.upper is not None:
                    claim = self.make_delayed(part, interval.upper)
                case CoreRelease(left, _, interval) if left == FALSE and interval.upper is not None:
                    claim = self.make_delayed(part, interval.upper)
                case CoreUntil():
                    return self.demand(without_delay_until(part.core), once=False)
                case CoreRelease():
                    return self.release_without_delay(part.core)
                case _:
                    raise AssertionError("a propositional part needs no claim")
            self.shared[part] = claim
        return _claiming(self.shared[part])

    def make_repeated(self, part: _Part) -> Claim:
        claim = Claim(self.number())
        core = part.core
        assert isinstance(core, CoreUntil | CoreRelease)
        operands = self.operands(
            core, self.demand(core.left, once=False), self.demand(core.right, once=False)
        )
        if isinstance(core, CoreUntil):
            self.made[claim.number] = until_repeated(
                name_of(core), claim, core.interval, operands, vacuous_at_end=part.vacuous_at_end
            )
        else:
            self.made[claim.number] = release_repeated(
                name_of(core), claim, core.interval, operands, until_the_end=part.until_the_end
            )
        return claim

    def make_delayed(self, part: _Part, upper: Fraction) -> Claim:
        claim = Claim(self.number())
        core = part.core
        assert isinstance(core, CoreUntil | CoreRelease)
        interval = core.interval
        width = upper - interval.lower
        count = recorder_count(interval.lower, width)
        if count > MAXIMAL_RECORDERS:
            raise TranslationError(
                f"{name_of(core)}: the delay of {interval.lower} s is so long against the width of {width} s "
                f"that it would take {count} pairs of clocks; widen the interval to at least "
                f"{interval.lower / (MAXIMAL_RECORDERS - 2)} s"
            )
        undelayed = replace(
            core,
            interval=Interval(Fraction(0), width, interval.lower_open, interval.upper_open),
        )
        replayed = self.repeated(_Part(undelayed, part.until_the_end))
        parked = self.parked(core)
        self.made[claim.number] = smoother(name_of(core), claim, parked)
        for index in range(count):
            self.made[self.number()] = recorder(
                f"{name_of(core)}, recorder {index + 1}",
                claim,
                index,
                index == count - 1,
                interval.lower,
                replayed,
                parked,
            )
        return claim

    def release_without_delay(self, core: CoreRelease) -> Demand:
        """The dual of :func:`without_delay_until`.

        With ``horizon: finite`` a release without an upper bound asks nothing where its interval begins
        after the end; the rewriting of a bounded one, in turn, must not profit from that rule.
        """
        interval = core.interval
        up_to = Interval(Fraction(0), interval.lower)
        inner_interval = Interval(lower_open=interval.lower_open)
        lenient = self.until_the_end and interval.upper is None
        inner = release(core.left, core.right, inner_interval)
        alternatives: list[Demand] = []
        if not interval.lower_open:
            before = Interval(Fraction(0), interval.lower, upper_open=True)
            alternatives.append(self.demand(eventually(core.left, before), once=False))
        delayed = eventually(inner, up_to)
        alternatives.append(self.repeated_over(delayed, inner, until_the_end=lenient, vacuous_at_end=lenient))
        if interval.upper is not None:
            alternatives.append(self.demand(always(core.right, interval), once=False))
        claim = Claim(self.number())
        possible = tuple(demand for demand in alternatives if not demand.impossible)
        self.made[claim.number] = choice(
            name_of(core), claim, Demand(impossible=True), possible, self.parked(core)
        )
        self.shared[_Part(core, self.until_the_end)] = claim
        return _claiming(claim)

    def repeated_over(self, outer: Core, inner: Core, *, until_the_end: bool, vacuous_at_end: bool) -> Demand:
        """A bounded eventually whose argument treats the end of the mission in its own way."""
        part = _Part(outer, until_the_end, vacuous_at_end)
        if propositional(outer):
            return self.predicate(outer)
        if part in self.shared:
            return _claiming(self.shared[part])
        assert isinstance(outer, CoreUntil)
        inner_demand = self.repeated(_Part(inner, until_the_end))
        claim = Claim(self.number())
        operands = self.operands(outer, self.predicate(outer.left), inner_demand)
        self.made[claim.number] = until_repeated(
            name_of(outer), claim, outer.interval, operands, vacuous_at_end=vacuous_at_end
        )
        self.shared[part] = claim
        return _claiming(claim)


def without_delay_until(core: CoreUntil) -> Core:
    """``p U_I q`` with a lower bound above 0, by operators that begin at 0 and a delayed eventually.

    Valid for the standard until on right-continuous signals (docs: translation, section 4).
    """
    interval = core.interval
    up_to = Interval(Fraction(0), interval.lower)
    parts = [
        always(until(core.left, core.right, Interval(lower_open=interval.lower_open)), up_to),
    ]
    if not interval.lower_open:
        parts.append(always(core.left, Interval(Fraction(0), interval.lower, upper_open=True)))
    if interval.upper is not None:
        parts.append(eventually(core.right, interval))
    return conjunction(*parts)


def constant_value(core: Core) -> Core:
    """The propositional formula that `core` amounts to if the label never changes again."""
    match core:
        case Truth() | Literal():
            return core
        case Conjunction(operands):
            return conjunction(*(constant_value(operand) for operand in operands))
        case Disjunction(operands):
            return disjunction(*(constant_value(operand) for operand in operands))
        case CoreUntil(left, right, interval):
            if 0 in interval:
                return constant_value(right)
            return conjunction(constant_value(left), constant_value(right))
        case CoreRelease(left, right, interval):
            if 0 in interval:
                return constant_value(right)
            return disjunction(constant_value(left), constant_value(right))


def necessary_label(core: Core) -> Core:
    """A propositional formula that holds whenever `core` does."""
    match core:
        case Truth() | Literal():
            return core
        case Conjunction(operands):
            return conjunction(*(necessary_label(operand) for operand in operands))
        case Disjunction(operands):
            return disjunction(*(necessary_label(operand) for operand in operands))
        case CoreRelease(_, right, interval) if 0 in interval:
            return necessary_label(right)
        case CoreUntil(left, right, interval):
            if 0 in interval:
                return disjunction(necessary_label(left), necessary_label(right))
            return necessary_label(left)
        case CoreRelease():
            return TRUE


def name_of(core: Core) -> str:
    """The name of a transducer or a predicate: its formula."""
    return show(written(core))


def _begins_attained(core: Core) -> bool:
    """Whether `core` holds at the first instant of each stretch on which it holds; ``False`` is a guess."""
    match core:
        case Conjunction(operands) | Disjunction(operands):
            return all(map(_begins_attained, operands))
        case CoreUntil(left, right, interval):
            attained = interval.upper is None or not interval.upper_open
        case CoreRelease(left, right, interval):
            attained = left == FALSE or (interval.lower == 0 and not interval.lower_open)
        case _:
            return True
    return attained and _begins_attained(left) and _begins_attained(right)


def _punctual(core: Core) -> bool:
    """Whether some interval is a single instant: no case for what is claimed again and again."""
    match core:
        case Conjunction(operands) | Disjunction(operands):
            return any(map(_punctual, operands))
        case CoreUntil(left, right, interval) | CoreRelease(left, right, interval):
            return interval.punctual or _punctual(left) or _punctual(right)
        case _:
            return False


def _claiming(claim: Claim) -> Demand:
    return Demand(claims=frozenset((claim,)))


def _in_order(transducers: tuple[Transducer, ...]) -> tuple[Transducer, ...]:
    """The transducers with emitters before readers."""
    every = [(*transducer.edges, *transducer.endings) for transducer in transducers]
    emitters: dict[str, set[int]] = {}
    for index, edges in enumerate(every):
        for one in edges:
            for signal in one.emits:
                emitters.setdefault(signal, set()).add(index)
    sorter: TopologicalSorter[int] = TopologicalSorter()
    for index, edges in enumerate(every):
        sorter.add(index)
        for one in edges:
            for signal in one.requires | one.excludes:
                sorter.add(index, *(emitters.get(signal, set()) - {index}))
    return tuple(transducers[index] for index in sorter.static_order())
