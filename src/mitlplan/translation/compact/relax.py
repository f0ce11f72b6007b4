"""What a loop must have shown by the end of its first round.

A loop shows nothing later that it has not shown in the prefix or the first round. So if it satisfies f, its
first ``prefix + cycle`` seconds satisfy a relaxation of f in which every bound is dropped and "again and
again" is "once", read as a mission that ends there. The least makespan of the relaxation bounds that of
every loop from below.
"""

from __future__ import annotations

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
from mitlplan.translation.compact.translate import constant_value, necessary_label


def relax(core: Core) -> Core:
    """A formula that a loop satisfies by the end of its first round, if for ever it satisfies `core`.

    To be read with ``horizon: finite``.
    """
    match core:
        case Truth() | Literal():
            return core
        case Conjunction(operands):
            return conjunction(*map(relax, operands))
        case Disjunction(operands):
            return disjunction(*map(relax, operands))
        case CoreUntil(left, right, _):
            # The right label is first seen no later, and the left side held until then.
            return conjunction(until(necessary_label(left), necessary_label(right)), _shown(right))
        case CoreRelease(left, right, interval) if left == FALSE and interval.unrestricted:
            return conjunction(always(necessary_label(right)), _throughout(right))
        case CoreRelease(left, right, interval) if interval.unrestricted:
            return release(necessary_label(left), necessary_label(right))
        case CoreRelease():
            return TRUE


def can_end(core: Core) -> bool:
    """Whether a finite plan may satisfy `core` whatever follows; ``False`` is certain."""
    match core:
        case Conjunction(operands):
            return all(map(can_end, operands))
        case Disjunction(operands):
            return any(map(can_end, operands))
        case CoreRelease(left, _, interval):
            return left != FALSE or interval.upper is not None
        case _:
            return True


def parked_label(core: Core) -> Core:
    """A propositional formula that holds where the robot may stay for ever if `core` is to hold at time 0."""
    match core:
        case Conjunction(operands):
            return conjunction(*map(parked_label, operands))
        case Disjunction(operands):
            return disjunction(*map(parked_label, operands))
        case CoreRelease(left, right, interval) if left == FALSE and interval.upper is None:
            return constant_value(right)
        case _:
            return TRUE


def _throughout(core: Core) -> Core:
    """What has been shown if `core` holds at every time."""
    match core:
        case Conjunction(operands):
            return conjunction(*map(_throughout, operands))
        case Disjunction(operands):
            label = disjunction(*(operand for operand in operands if propositional(operand)))
            shown = [_shown(operand) for operand in operands if not propositional(operand)]
            return disjunction(always(label), *shown)
        case _ if propositional(core):
            return always(core)
        case _:
            return _shown(core)


def _shown(core: Core) -> Core:
    """What has been shown if `core` holds at some time."""
    match core:
        case Conjunction(operands):
            return conjunction(*map(_shown, operands))
        case Disjunction(operands):
            return disjunction(*map(_shown, operands))
        case CoreUntil(_, right, _):
            return _shown(right)
        case CoreRelease(_, right, interval) if 0 in interval:
            return _shown(right)
        case CoreRelease():
            return TRUE
        case _:
            return eventually(core)
