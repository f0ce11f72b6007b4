"""From the formula as written to the core: negation only on atoms, until and release only.

The closed until and X are written out; a weak until becomes a release where its sides are propositional,
since there the first instant of q exists: ``p W q = q R (p | q)``. Then the identities of
:mod:`mitlplan.logic.identities` are applied. What :func:`written` makes of a core has that core for its
normal form again. ``<->`` and W need their sides twice: what would grow exponentially is refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import repeat
from typing import Literal as Choice

from mitlplan.errors import FormulaError
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
    negate,
    propositional,
    release,
)
from mitlplan.logic.core import until as standard_until
from mitlplan.logic.formula import (
    MOST_LEVELS,
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
    operands_of,
)
from mitlplan.logic.identities import simplify
from mitlplan.logic.interval import Interval
from mitlplan.logic.labels import certain, possible
from mitlplan.logic.one_shot import refuse_repeated_instants
from mitlplan.logic.show import show

MOST_COPIES = 10_000

_ONE_LATER = Interval(Fraction(1), Fraction(1))


def normalize(
    formula: Formula,
    until: Choice["standard", "closed"] = "standard",
    *,
    horizon: Choice["finite", "infinite"] = "finite",
) -> Core:
    """The normal form of a formula.

    Parameters
    ----------
    formula
        Any formula, read or built; bounds in seconds.
    until
        ``"closed"``: the left side of an until must still hold at the instant of the right side.
    horizon
        What is done for ``"finite"`` is right for either; ``"infinite"`` allows more, such as one clock for
        ``G F[a,b]``.

    Returns
    -------
    Core
        True of the same signals, and decided by the same prefixes of them.

    Raises
    ------
    FormulaError
        If the formula is too deep or would grow too large, or repeats a question about an exact instant.

    Examples
    --------
    >>> from mitlplan.logic.parse import parse
    >>> show(written(normalize(parse("!(A -> F[0,2] F[1,3) B)"))))
    'G[1,5) !B & A'
    >>> show(written(normalize(parse("A U B"), "closed")))
    'A U (A & B)'
    """
    closed = until == "closed"
    _refuse_large(formula, closed=closed)
    text = show(formula)
    refuse_repeated_instants(formula, text, lambda node: _place(text, show(node)))
    return simplify(_core(formula, positive=True, closed=closed), endless=horizon == "infinite")


def accomplishable(formula: Formula, *, positive: bool = True) -> bool:
    """Whether a formula is co-safe as it is written: a finite plan can accomplish it.

    In its negation normal form no G, R or W reaches to infinity (docs: semantics, section 3). This is asked
    of the formula and not of its core: an identity may well do away with such an operator, and which plans
    count must not depend on that.

    Parameters
    ----------
    positive
        ``False`` asks it of the negation.

    Examples
    --------
    >>> from mitlplan.logic.parse import parse
    >>> accomplishable(parse("!G !A")), accomplishable(parse("G[1,3] A | G A"))
    (True, False)
    """
    match formula:
        case Constant() | Atom():
            return True
        case Not(operand):
            return accomplishable(operand, positive=not positive)
        case And(operands) | Or(operands):
            return all(accomplishable(operand, positive=positive) for operand in operands)
        case Implies(left, right):
            return accomplishable(left, positive=not positive) and accomplishable(right, positive=positive)
        case Iff(left, right):
            return all(
                accomplishable(side, positive=sign) for side in (left, right) for sign in (True, False)
            )
        case Next(operand):
            return accomplishable(operand, positive=positive)
        case Eventually(operand, interval):
            return (positive or interval.upper is not None) and accomplishable(operand, positive=positive)
        case Always(operand, interval):
            return (not positive or interval.upper is not None) and accomplishable(operand, positive=positive)
        case Until(left, right, interval):
            return (positive or interval.upper is not None) and all(
                accomplishable(side, positive=positive) for side in (left, right)
            )
        case Release(left, right, interval):
            return (not positive or interval.upper is not None) and all(
                accomplishable(side, positive=positive) for side in (left, right)
            )
        case WeakUntil():
            # G p | (p U q), and negated F !p & (!p R !q): either way one part reaches to infinity.
            return False


def written(core: Core) -> Formula:
    """A formula in normal form as a user would write it.

    Examples
    --------
    >>> written(eventually(Literal("A", positive=False)))
    Eventually(operand=Not(operand=Atom(name='A')), interval=Interval(lower=Fraction(0, 1), upper=None, \
lower_open=False, upper_open=True))
    """
    match core:
        case Truth(value):
            return Constant(value)
        case Literal(name, positive):
            return Atom(name) if positive else Not(Atom(name))
        case Conjunction(operands):
            return And(tuple(written(operand) for operand in operands))
        case Disjunction(operands):
            return Or(tuple(written(operand) for operand in operands))
        case CoreUntil(left, right, interval):
            return (
                Eventually(written(right), interval)
                if left == TRUE
                else Until(written(left), written(right), interval)
            )
        case CoreRelease(left, right, interval):
            return (
                Always(written(right), interval)
                if left == FALSE
                else Release(written(left), written(right), interval)
            )


def co_safe(core: Core) -> bool:
    """Whether a finite plan can satisfy `core` whatever follows: no release reaches to infinity.

    Examples
    --------
    >>> co_safe(eventually(Literal("A"))), co_safe(always(Literal("A")))
    (True, False)
    """
    match core:
        case Truth() | Literal():
            return True
        case Conjunction(operands) | Disjunction(operands):
            return all(co_safe(operand) for operand in operands)
        case CoreUntil(left, right):
            return co_safe(left) and co_safe(right)
        case CoreRelease(left, right, interval):
            return interval.upper is not None and co_safe(left) and co_safe(right)


def warnings(formula: Formula, until: Choice["standard", "closed"] = "standard") -> tuple[str, ...]:
    """What the writer of a formula may not have meant, a sentence each.

    Parameters
    ----------
    formula
        The formula as it was written.
    until
        Which until its operators are read with. The closed one asks both sides to hold at one instant, which
        sides that exclude each other never do.

    Examples
    --------
    >>> from mitlplan.logic.parse import parse
    >>> warnings(parse("!A U A"), "closed")[0]
    '`!A U A` can never hold: with the closed until `!A` must still hold at the instant of `A`, but excludes \
it; take the standard until, or change one side.'
    """
    if until != "closed":
        return ()
    _refuse_large(formula, closed=True)
    sentences: dict[str, None] = {}
    waiting = [formula]
    while waiting:
        node = waiting.pop()
        waiting += reversed(operands_of(node))
        if isinstance(node, (Until, WeakUntil, Release)) and (sentence := _warning(node)):
            sentences[sentence] = None
    return tuple(sentences)


def _warning(node: Until | WeakUntil | Release) -> str:
    left, right = _shortened(node.left), _shortened(node.right)
    apart = f"with the closed until `{left}` must still hold at the instant of `{right}`, but excludes it"
    match node:
        case Until() if _exclude_each_other(node.left, node.right):
            consequence, because = "can never hold", apart
        case WeakUntil() if _exclude_each_other(node.left, node.right):
            consequence, because = f"can hold only if `{left}` holds for ever", apart
        case Release() if _exclude_each_other(Not(node.left), Not(node.right)):
            consequence = "always holds"
            because = f"with the closed until it asks for `{left}` or `{right}`, and one of them always holds"
        case _:
            return ""
    return f"`{_shortened(node)}` {consequence}: {because}; take the standard until, or change one side."


def _exclude_each_other(left: Formula, right: Formula) -> bool:
    sides = (_core(side, positive=True, closed=True) for side in (left, right))
    return not possible(conjunction(*sides))


def _shortened(formula: Formula, longest: int = 60) -> str:
    text = show(formula)
    return text if len(text) <= longest else text[: longest - 3] + "..."


def _refuse_large(formula: Formula, *, closed: bool) -> None:
    copied = 0
    waiting = [(formula, 1, 1)]
    while waiting:
        node, depth, copies = waiting.pop()
        if depth > MOST_LEVELS:
            raise FormulaError(f"The formula is nested more than {MOST_LEVELS} levels deep.", "", 0)
        copied += copies - 1
        for operand, times in zip(operands_of(node), _times_needed(node, closed=closed), strict=False):
            waiting.append((operand, depth + 1, copies * times))
    if copied > MOST_COPIES:
        raise FormulaError(
            f"Written with until and release only, the formula grows by more than {MOST_COPIES} parts.",
            show(formula),
            0,
            hint="nested <-> and W double at every level; write -> where one direction is enough",
        )


def _times_needed(node: Formula, *, closed: bool) -> Iterable[int]:
    """How often the normal form of a formula names each of its operands, at most."""
    match node:
        case Iff():
            return 2, 2
        case WeakUntil():
            return 3 if closed else 2, 2
        case Until() | Release():
            return 2 if closed else 1, 1
        case _:
            return repeat(1)


def _place(text: str, part: str) -> tuple[int, int]:
    start = text.find(part)
    return start, start + len(part)


def _core(formula: Formula, *, positive: bool, closed: bool) -> Core:
    """The normal form of `formula` or, if not `positive`, of its negation."""

    def core(operand: Formula, *, negated: bool = False) -> Core:
        return _core(operand, positive=positive != negated, closed=closed)

    match formula:
        case Constant(value):
            return TRUE if value == positive else FALSE
        case Atom(name):
            return Literal(name, positive)
        case Not(operand):
            return core(operand, negated=True)
        case And(operands):
            return (conjunction if positive else disjunction)(*(core(operand) for operand in operands))
        case Or(operands):
            return (disjunction if positive else conjunction)(*(core(operand) for operand in operands))
        case Implies(left, right):
            return (disjunction if positive else conjunction)(core(left, negated=True), core(right))
        case Iff(left, right):
            return disjunction(
                conjunction(_core(left, positive=True, closed=closed), core(right)),
                conjunction(_core(left, positive=False, closed=closed), core(right, negated=True)),
            )
        case Next(operand):
            return eventually(core(operand), _ONE_LATER)
        case Eventually(operand, interval):
            return (eventually if positive else always)(core(operand), interval)
        case Always(operand, interval):
            return (always if positive else eventually)(core(operand), interval)
        case Until(left, right, interval) | Release(left, right, interval):
            build = _until if isinstance(formula, Until) == positive else _release
            return build(core(left), core(right), interval, closed=closed)
        case WeakUntil(left, right):
            sides = (_core(side, positive=True, closed=closed) for side in (left, right))
            weak_until = _weak_until(*sides, closed=closed)
            return weak_until if positive else negate(weak_until)


def _until(left: Core, right: Core, interval: Interval, *, closed: bool) -> Core:
    return standard_until(left, conjunction(left, right) if closed else right, interval)


def _release(left: Core, right: Core, interval: Interval, *, closed: bool) -> Core:
    return release(left, disjunction(left, right) if closed else right, interval)


def _weak_until(left: Core, right: Core, *, closed: bool) -> Core:
    if closed:
        right = conjunction(left, right)
    either = left if closed else disjunction(left, right)
    # If every label made `either` true the release would be known at once, the weak until only by and by.
    if propositional(left) and propositional(right) and not certain(either):
        return release(right, either)
    return disjunction(always(left), standard_until(left, right))
