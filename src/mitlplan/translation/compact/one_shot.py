"""Until and release that are claimed once: in one-shot positions (docs: semantics, section 2).

One clock measures the age of the one claim, so any interval will do, a punctual one included. A claim made
at time 0 needs no clock of its own: it uses the time of the mission, or, where a lower bound is asked, one
clock that all such claims share (the time itself must keep "later is never better", see the search). An
until in a one-shot position is fulfilled at an instant, and a release released at one; a step without a
move can be put at any instant, so this loses nothing but a release by what holds just after an instant and
not at it: such a release is no case for this module.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mitlplan.automata.transducer import (
    TIME,
    Constraint,
    Edge,
    Guard,
    Location,
    Relation,
    Restless,
    Transducer,
)
from mitlplan.logic.interval import Interval
from mitlplan.translation.compact.ages import above, below, beyond, exactly, short_of
from mitlplan.translation.compact.claims import (
    NOTHING,
    Claim,
    Inputs,
    Operands,
    Use,
    edge,
    made,
    uses,
)

SINCE_START = "since start"
"""The clock that all claims made at time 0 share where they ask for lower bounds."""

IDLE, PENDING, FREE, HELD, DONE = "idle", "pending", "free", "held", "done"


@dataclass(frozen=True, slots=True)
class Age:
    """The clock that measures the age of the claim, and what the claim resets."""

    clock: str
    resets: frozenset[str]


def age_of(claim: Claim, *, at_start: bool, lower_bounds: bool, timed: bool = True) -> Age:
    """The clock for a claim that is made at time 0, or at any one instant."""
    if at_start:
        return Age(SINCE_START if lower_bounds else TIME, NOTHING)
    clock = f"age {claim.number}"
    return Age(clock, frozenset((clock,)) if timed else NOTHING)


def until_once(
    name: str, claim: Claim, interval: Interval, operands: Operands, *, at_start: bool
) -> Transducer:
    """``left U_I right``, claimed at one instant."""
    left, right = operands.left, operands.right
    now = 0 in interval
    delayed = not now
    waits = interval.lower > 0
    timed = waits or interval.upper is not None
    age = age_of(claim, at_start=at_start, lower_bounds=waits, timed=timed)
    in_time = above(age.clock, interval) + below(age.clock, interval)
    not_late = below(age.clock, interval)
    asked, unasked = Inputs(claim, True, False), Inputs(claim, False, False)

    def edges() -> Iterator[Edge | None]:
        yield edge(IDLE, IDLE, inputs=unasked, marked=True)
        yield edge(DONE, DONE, marked=True)
        for use in uses(right, now, False):
            if use.point:
                yield edge(IDLE, DONE, inputs=asked, at_point=(right,), marked=True)
            else:
                yield edge(
                    IDLE,
                    PENDING,
                    inputs=asked,
                    resets=age.resets,
                    at_point=(left,),
                    in_open=(left,),
                    excludes=use.excludes,
                )
        yield edge(PENDING, DONE, guard=in_time, at_point=(right,), marked=True)
        # With a lower bound the time may not be ripe, although the label is right.
        for use in uses(right, now, False):
            if delayed or not use.point:
                yield edge(
                    PENDING,
                    PENDING,
                    guard=not_late,
                    at_point=(left,),
                    in_open=(left,),
                    excludes=use.excludes,
                )

    def endings() -> Iterator[Edge | None]:
        yield edge(IDLE, DONE, inputs=unasked)
        yield edge(DONE, DONE)
        if now:
            yield edge(IDLE, DONE, inputs=asked, at_point=(right,))
        yield edge(PENDING, DONE, guard=in_time, at_point=(right,))

    def parkings() -> Iterator[Edge | None]:
        yield edge(IDLE, DONE, inputs=unasked)
        yield edge(DONE, DONE)
        yield edge(IDLE, DONE, inputs=asked, at_point=(operands.parked,))
        yield edge(PENDING, DONE, guard=in_time, at_point=(operands.parked_right,))
        if waits:
            yield edge(
                PENDING,
                DONE,
                guard=short_of(age.clock, interval),
                at_point=(operands.parked_left, operands.parked_right),
            )

    restless = Restless.ALWAYS
    if left.label_alone and right.label_alone:
        restless = Restless.WHEN_TARGET if delayed else Restless.NEVER
    deadline = None
    if interval.upper is not None:
        deadline = Constraint(age.clock, Relation.AT_MOST, interval.upper)
    return Transducer(
        name,
        (
            Location(IDLE),
            Location(DONE),
            Location(PENDING, not_late, operands.target, deadline, restless, relief=DONE),
        ),
        made(edges()),
        made(endings()),
        made(parkings()),
        acceptance=interval.upper is None,
    )


def release_once(
    name: str,
    claim: Claim,
    interval: Interval,
    operands: Operands,
    *,
    at_start: bool,
    until_the_end: bool,
) -> Transducer:
    """``left R_I right``, claimed at one instant.

    In `free` the open phase lies before the interval; in `held` the right side is demanded throughout it.
    With `until_the_end` a release without an upper bound asks nothing after the end of the mission.
    """
    left, right = operands.left, operands.right
    now = 0 in interval
    bounded = interval.upper is not None
    waits = interval.lower > 0
    timed = waits or bounded
    age = age_of(claim, at_start=at_start, lower_bounds=timed, timed=timed)
    asked, unasked = Inputs(claim, True, False), Inputs(claim, False, False)
    stages = tuple(_stages(age.clock, interval))

    def step(
        source: str, stage: Stage, inputs: Inputs | None, resets: frozenset[str]
    ) -> Iterator[Edge | None]:
        held = (right,) if stage.inside else ()
        if stage.last:
            yield edge(source, DONE, inputs=inputs, guard=stage.guard, at_point=held)
            return
        for use in uses(left, True, False):
            if use.point:
                yield edge(source, DONE, inputs=inputs, guard=stage.guard, at_point=(*held, left))
                continue
            for keep in uses(right, False, True) if stage.early else (Use(False, True),):
                if keep.open:
                    yield edge(
                        source,
                        HELD,
                        inputs=inputs,
                        guard=stage.guard,
                        resets=resets,
                        at_point=held,
                        in_open=(right,),
                        excludes=use.excludes,
                    )
                else:
                    yield edge(
                        source,
                        FREE,
                        inputs=inputs,
                        guard=stage.guard,
                        resets=resets,
                        at_point=held,
                        excludes=use.excludes | keep.excludes,
                    )

    at_claim = Stage((), inside=now, early=waits, last=False)

    def edges() -> Iterator[Edge | None]:
        yield edge(IDLE, IDLE, inputs=unasked)
        yield edge(DONE, DONE)
        yield from step(IDLE, at_claim, asked, age.resets)
        for source in (FREE, HELD) if waits else (HELD,):
            for stage in stages:
                yield from step(source, stage, None, NOTHING)

    def ending(source: str, stage: Stage, inputs: Inputs | None) -> Iterator[Edge | None]:
        held = (right,) if stage.inside else ()
        if stage.last or (until_the_end and not bounded):
            yield edge(source, DONE, inputs=inputs, guard=stage.guard, at_point=held)
        else:
            yield edge(source, DONE, inputs=inputs, guard=stage.guard, at_point=(*held, left))

    def endings() -> Iterator[Edge | None]:
        yield edge(IDLE, DONE, inputs=unasked)
        yield edge(DONE, DONE)
        yield from ending(IDLE, at_claim, asked)
        for source in (FREE, HELD):
            for stage in stages:
                yield from ending(source, stage, None)

    def parkings() -> Iterator[Edge | None]:
        yield edge(IDLE, DONE, inputs=unasked)
        yield edge(DONE, DONE)
        yield edge(IDLE, DONE, inputs=asked, at_point=(operands.parked,))
        for source in (FREE, HELD):
            for stage in stages:
                if stage.inside:
                    yield edge(source, DONE, guard=stage.guard, at_point=(operands.parked_right,))
                elif stage.last:
                    yield edge(source, DONE, guard=stage.guard)
                else:
                    yield edge(source, DONE, guard=stage.guard, at_point=(operands.parked_either,))

    restless = Restless.ALWAYS
    if (left.label_alone and right.label_alone) or (left.impossible and not timed):
        restless = Restless.NEVER
    before = (Constraint(age.clock, Relation.AT_MOST, interval.lower),)
    return Transducer(
        name,
        (
            Location(IDLE),
            Location(DONE),
            Location(FREE, before, restless=restless, relief=DONE),
            Location(HELD, restless=restless, relief=DONE),
        ),
        made(edges()),
        made(endings()),
        made(parkings()),
    )


@dataclass(frozen=True, slots=True)
class Stage:
    """Where the age of a claim stands against its interval at a step.

    Parameters
    ----------
    inside
        The instant of the step belongs to the interval.
    early
        An open phase that starts now may lie before the interval.
    last
        Nothing of the interval lies after the instant.
    """

    guard: Guard
    inside: bool
    early: bool
    last: bool


def _stages(clock: str, interval: Interval) -> Iterator[Stage]:
    lower, upper = interval.lower, interval.upper
    if lower > 0:
        yield Stage((Constraint(clock, Relation.LESS, lower),), inside=False, early=True, last=False)
    if interval.lower_open and lower > 0:
        yield Stage(exactly(clock, lower), inside=False, early=False, last=False)
    if upper is None:
        yield Stage(above(clock, interval), inside=True, early=False, last=False)
        return
    if lower < upper:
        until_upper = (Constraint(clock, Relation.LESS, upper),)
        yield Stage(above(clock, interval) + until_upper, inside=True, early=False, last=False)
    if interval.upper_open:
        yield Stage((Constraint(clock, Relation.AT_LEAST, upper),), inside=False, early=False, last=True)
    else:
        yield Stage(exactly(clock, upper), inside=True, early=False, last=True)
        yield Stage(beyond(clock, interval), inside=False, early=False, last=True)
