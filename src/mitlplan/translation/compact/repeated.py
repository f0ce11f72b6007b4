"""Until and release that may be claimed again and again, with intervals that begin at 0.

One clock will do, because the oldest open claim of an until is the one that runs out first, and the newest
claim of a release the one that lasts longest. What an instant adds: the claim that is measured was made at
an instant (``attained``) or is the limit of claims made in an open phase, and that decides whether the
bound itself still counts (docs: translation, section 2; Maler, Nickovic and Pnueli 2006 need a clock for
every edge of the claim).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mitlplan.automata.transducer import (
    Constraint,
    Edge,
    Guard,
    Location,
    Relation,
    Restless,
    Transducer,
)
from mitlplan.logic.interval import Interval
from mitlplan.translation.compact.ages import below, beyond, exactly
from mitlplan.translation.compact.claims import (
    NOTHING,
    Claim,
    Demand,
    Inputs,
    Operands,
    Use,
    edge,
    every_input,
    made,
    uses,
)

IDLE, ATTAINED, LIMIT, GOING = "idle", "attained", "limit", "going"


@dataclass(frozen=True, slots=True)
class Window:
    """The clock of a repeated claim and its interval, which begins at 0."""

    clock: str
    interval: Interval

    @property
    def bounded(self) -> bool:
        """Whether the interval ends."""
        return self.interval.upper is not None

    @property
    def from_now(self) -> bool:
        """Whether the instant of the claim itself counts."""
        return not self.interval.lower_open

    @property
    def measured(self) -> tuple[str, ...]:
        """The locations that remember the claim that decides."""
        return (ATTAINED, LIMIT) if self.bounded else (ATTAINED,)

    def reliefs(self) -> Iterator[tuple[str, str]]:
        """The measuring locations, each behind the one that owes less: a limit owes less than an instant."""
        relief = IDLE
        for location in reversed(self.measured):
            yield location, relief
            relief = location

    def begin(self, location: str) -> tuple[str, frozenset[str]]:
        """The location that remembers a new claim, and what it resets."""
        if self.bounded:
            return location, frozenset((self.clock,))
        return ATTAINED, NOTHING

    def up_to_bound(self) -> Guard:
        """The age is at most the bound, whether that counts or not."""
        if self.interval.upper is None:
            return ()
        return (Constraint(self.clock, Relation.AT_MOST, self.interval.upper),)

    def before_bound(self) -> Guard:
        """The bound lies ahead."""
        if self.interval.upper is None:
            return ()
        return (Constraint(self.clock, Relation.LESS, self.interval.upper),)

    def in_time_at_point(self, location: str) -> Guard:
        """The claim remembered in `location` can be met at this very instant."""
        if location == IDLE:
            return ()
        return below(self.clock, self.interval) if location == ATTAINED else self.up_to_bound()

    def in_time_in_open(self, location: str) -> Guard:
        """The claim remembered in `location` can be met just after this instant."""
        if location == IDLE:
            return ()
        return self.before_bound() if location == ATTAINED else self.up_to_bound()


def until_repeated(
    name: str, claim: Claim, interval: Interval, operands: Operands, *, vacuous_at_end: bool = False
) -> Transducer:
    """``left U_I right`` for an interval that begins at 0, claimed any number of times.

    With `vacuous_at_end` a claim whose interval reaches past the end of the mission asks nothing.
    """
    window = Window(f"age {claim.number}", interval)
    left, right = operands.left, operands.right
    sources = (IDLE, *window.measured)

    def choices(waiting: bool, inputs: Inputs) -> Iterator[Use]:
        def waits_after(use_point: bool) -> bool:
            return inputs.point and not window.from_now if use_point else waiting or inputs.point

        asked = waiting or inputs.point
        for first in uses(right, asked, asked or inputs.open):
            if first.excludes:
                yield first
            elif first.open and not (waits_after(first.point) or inputs.open):
                if right.label_alone:
                    yield Use(first.point, False)
            else:
                yield first

    def step(source: str, inputs: Inputs, use: Use) -> Edge | None:
        waiting = source != IDLE
        at_point: tuple[Demand, ...] = ()
        guard: Guard = ()
        if use.point:
            at_point = (right,)
            guard = window.in_time_at_point(source)
            still = IDLE
            anew = inputs.point and not window.from_now
        else:
            still = source
            anew = inputs.point and not waiting
        if anew or still != IDLE:
            at_point += (left,)
        in_open: tuple[Demand, ...] = ()
        resets = NOTHING
        if use.open:
            in_open = (right,)
            if anew or still != IDLE or (inputs.open and not window.from_now):
                in_open += (left,)
            guard += window.in_time_in_open(still)
            target = IDLE
        else:
            target = still
            if anew:
                target, resets = window.begin(ATTAINED)
            elif still == IDLE and inputs.open:
                target, resets = window.begin(LIMIT)
            if target != IDLE:
                in_open = (left,)
        return edge(
            source,
            target,
            inputs=inputs,
            guard=guard,
            resets=resets,
            at_point=at_point,
            in_open=in_open,
            excludes=use.excludes,
            marked=not waiting or use.point or use.open,
        )

    def edges() -> Iterator[Edge | None]:
        for source in sources:
            for inputs in every_input(claim):
                for use in choices(source != IDLE, inputs):
                    yield step(source, inputs, use)

    def endings() -> Iterator[Edge | None]:
        for source in sources:
            for asked in (False, True):
                inputs = Inputs(claim, asked, False)
                if source == IDLE and not asked:
                    yield edge(source, IDLE, inputs=inputs)
                    continue
                if window.from_now or not asked:
                    guard = window.in_time_at_point(source)
                    yield edge(source, IDLE, inputs=inputs, guard=guard, at_point=(right,))
                if vacuous_at_end:
                    yield edge(source, IDLE, inputs=inputs, guard=window.in_time_in_open(source))

    def parkings() -> Iterator[Edge | None]:
        for source in sources:
            for inputs in every_input(claim):
                demands: tuple[Demand, ...] = ()
                if source != IDLE:
                    demands += (operands.parked_right,)
                if inputs.point or inputs.open:
                    demands += (operands.parked,)
                guard = window.in_time_at_point(source)
                yield edge(source, IDLE, inputs=inputs, guard=guard, at_point=demands)

    restless = Restless.NEVER if left.label_alone and right.label_alone else Restless.ALWAYS
    # Where the end of the mission excuses a claim, its target need never be seen.
    target = "" if vacuous_at_end else operands.target
    deadline = None
    if target and interval.upper is not None:
        deadline = Constraint(window.clock, Relation.AT_MOST, interval.upper)
    waiting_locations = (
        Location(location, window.up_to_bound(), target, deadline, restless, relief)
        for location, relief in window.reliefs()
    )
    return Transducer(
        name,
        (Location(IDLE), *waiting_locations),
        made(edges()),
        made(endings()),
        made(parkings()),
        acceptance=interval.upper is None,
    )


@dataclass(frozen=True, slots=True)
class Coverage:
    """Whether the claim remembered by a release covers the instant of a step and the time just after it."""

    guard: Guard
    point: bool
    open: bool


def release_repeated(
    name: str, claim: Claim, interval: Interval, operands: Operands, *, until_the_end: bool
) -> Transducer:
    """``left R_I right`` for an interval that begins at 0, claimed any number of times.

    In `going` the claim goes on; in the other locations it has ended and its age is measured. With
    `until_the_end` a release without an upper bound asks nothing after the end of the mission.
    """
    window = Window(f"age {claim.number}", interval)
    left, right = operands.left, operands.right
    measured = window.measured if window.bounded else ()
    sources = (IDLE, GOING, *measured)

    def coverages(source: str) -> Iterator[Coverage]:
        if source in (IDLE, GOING):
            covered = source == GOING
            yield Coverage((), covered, covered)
            return
        assert interval.upper is not None
        yield Coverage(window.before_bound(), point=True, open=True)
        if source == ATTAINED and not interval.upper_open:
            yield Coverage(exactly(window.clock, interval.upper), point=True, open=False)
            yield Coverage(beyond(window.clock, interval), point=False, open=False)
        else:
            at_least = Constraint(window.clock, Relation.AT_LEAST, interval.upper)
            yield Coverage((at_least,), point=False, open=False)

    def step(source: str, coverage: Coverage, inputs: Inputs, use: Use) -> Edge | None:
        at_point: tuple[Demand, ...] = ()
        if coverage.point or (inputs.point and window.from_now):
            at_point += (right,)
        still, resets = IDLE, NOTHING
        if use.point:
            at_point += (left,)
        elif inputs.point:
            still, resets = window.begin(ATTAINED)
        elif coverage.open and source == GOING:
            still, resets = window.begin(LIMIT)
        elif coverage.open:
            still = source
        in_open: tuple[Demand, ...] = ()
        if use.open:
            in_open += (left,)
            if inputs.open and window.from_now:
                in_open += (right,)
            target, resets = IDLE, NOTHING
        else:
            if still != IDLE or inputs.open:
                in_open += (right,)
            target = still
            if inputs.open or (still != IDLE and not window.bounded):
                target, resets = GOING, NOTHING
        return edge(
            source,
            target,
            inputs=inputs,
            guard=coverage.guard,
            resets=resets,
            at_point=at_point,
            in_open=in_open,
            excludes=use.excludes,
        )

    def edges() -> Iterator[Edge | None]:
        for source in sources:
            for coverage in coverages(source):
                for inputs in every_input(claim):
                    covered = coverage.open or inputs.point
                    for use in uses(left, covered, covered or inputs.open):
                        # Once released at the instant there is nothing left to release in the open phase.
                        needless = use.point and use.open and not inputs.open
                        if needless and not left.label_alone:
                            continue
                        yield step(source, coverage, inputs, Use(True, False) if needless else use)

    def endings() -> Iterator[Edge | None]:
        for source in sources:
            for coverage in coverages(source):
                for asked in (False, True):
                    demands: tuple[Demand, ...] = ()
                    if coverage.point or (asked and window.from_now):
                        demands += (right,)
                    if (coverage.open or asked) and not (until_the_end and not window.bounded):
                        demands += (left,)
                    inputs = Inputs(claim, asked, False)
                    yield edge(source, IDLE, inputs=inputs, guard=coverage.guard, at_point=demands)

    def parkings() -> Iterator[Edge | None]:
        for source in sources:
            for coverage in coverages(source):
                for inputs in every_input(claim):
                    demands: tuple[Demand, ...] = ()
                    if coverage.point:
                        demands += (operands.parked_right,)
                    if inputs.point or inputs.open:
                        demands += (operands.parked,)
                    yield edge(source, IDLE, inputs=inputs, guard=coverage.guard, at_point=demands)

    undecided = not (left.label_alone and right.label_alone)
    restless = Restless.ALWAYS if undecided and (window.bounded or not left.impossible) else Restless.NEVER
    return Transducer(
        name,
        (
            Location(IDLE),
            Location(GOING, restless=restless, relief=IDLE),
            *(
                Location(location, restless=restless, relief=relief)
                for location, relief in window.reliefs()
                if location in measured
            ),
        ),
        made(edges()),
        made(endings()),
        made(parkings()),
    )
