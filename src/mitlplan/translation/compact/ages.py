"""Guards that compare the age of a claim with an interval.

Ages are asked at steps after the claim, so a lower end of 0, open or not, has always been passed.
"""

from __future__ import annotations

from fractions import Fraction

from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.logic.interval import Interval


def above(clock: str, interval: Interval) -> Guard:
    """The age has reached the interval."""
    if interval.lower == 0:
        return ()
    relation = Relation.GREATER if interval.lower_open else Relation.AT_LEAST
    return (Constraint(clock, relation, interval.lower),)


def below(clock: str, interval: Interval) -> Guard:
    """The age has not left the interval."""
    if interval.upper is None:
        return ()
    relation = Relation.LESS if interval.upper_open else Relation.AT_MOST
    return (Constraint(clock, relation, interval.upper),)


def short_of(clock: str, interval: Interval) -> Guard:
    """The age has not reached the interval."""
    relation = Relation.AT_MOST if interval.lower_open else Relation.LESS
    return (Constraint(clock, relation, interval.lower),)


def beyond(clock: str, interval: Interval) -> Guard:
    """The age has left the interval, which has an upper end."""
    assert interval.upper is not None
    relation = Relation.AT_LEAST if interval.upper_open else Relation.GREATER
    return (Constraint(clock, relation, interval.upper),)


def exactly(clock: str, bound: Fraction) -> Guard:
    """The age equals the bound."""
    return (
        Constraint(clock, Relation.AT_LEAST, bound),
        Constraint(clock, Relation.AT_MOST, bound),
    )
