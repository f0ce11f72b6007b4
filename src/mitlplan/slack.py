"""How much later each way point of a plan may be reached.

The path is made a map of its own, a line: up to the way point every stay is as planned, from there on free.
A delay is possible exactly if the formula's automata have a run on that line, and the run that found the
plan does not bind what comes later. Where no label changes the robot cannot be seen, so a line needs a cell
only for each stretch with the same label. Delays are tried by doubling and halving, in halves of the common
denominator of all times: the answer is the end of a stretch of possible delays, and a gap before it may be
overlooked. It is less than it might be where the questions are used up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from math import floor, lcm
from typing import Literal as Choice

import numpy as np

from mitlplan.automata.transducer import NEVER, MapAutomaton, Network
from mitlplan.logic.core import (
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Disjunction,
    Literal,
    conjunction,
    eventually,
    holds,
)
from mitlplan.plan import Plan
from mitlplan.search.fastest import Found, Limits, fastest_run
from mitlplan.search.lasso import lassos
from mitlplan.search.tables import tabulate
from mitlplan.translation.compact.translate import Obligations, translate
from mitlplan.workspace.workspace import Workspace

MOST_QUESTIONS = 200
"""How many delays are tried for one plan; way points left over keep the slack that is known of them."""

MOST_MEGABYTES = 4
"""For one of these searches."""

_ARRIVED = "has arrived at the last way point"
"""A proposition of the last cell of a line; no formula can name it."""

Slack = Fraction | None


@dataclass(frozen=True, slots=True)
class _Stay:
    """A planned stay, and how long it may be."""

    label: frozenset[str]
    enter: Fraction
    least: Fraction
    most: Fraction | None


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Stays with the same label, one after the other: the first of them and all of them together."""

    first: int
    label: frozenset[str]
    enter: Fraction
    least: Fraction
    most: Fraction | None


def slack_of(
    workspace: Workspace, core: Core, horizon: Choice["infinite", "finite"], plan: Plan, limits: Limits
) -> tuple[Slack, ...]:
    """For each step of a plan how much later it may be entered, in seconds; ``None`` is without limit.

    Parameters
    ----------
    core
        The mission's formula, in normal form.
    plan
        What is known of the slack of its steps is taken for granted; it becomes no less.

    Examples
    --------
    >>> from mitlplan.mission import mission_from_mapping
    >>> from mitlplan.planner import plan
    >>> found = plan(mission_from_mapping({
    ...     "mitlplan": 1,
    ...     "workspace": {
    ...         "grid": {"rows": 1, "columns": 2, "waiting": True, "regions": {"A": [[0, 0]], "B": [[0, 1]]}}
    ...     },
    ...     "robot": {"start": "r0c0"},
    ...     "spec": "G F[0,3] A & G F[0,3] B",
    ... }))
    >>> print(found, [str(step.slack) for step in found.steps])
    0 r0c0 -> 1 r0c1 -> 2 r0c0, and so on ['0', '2']
    """
    line = _Line(workspace, core, horizon, plan, limits)
    return tuple(line.slack(place) for place in range(len(plan.steps)))


class _Line:
    """The path of one plan, and the questions put to it."""

    def __init__(
        self,
        workspace: Workspace,
        core: Core,
        horizon: Choice["infinite", "finite"],
        plan: Plan,
        limits: Limits,
    ) -> None:
        self.workspace = workspace
        self.core = core
        self.horizon = horizon
        self.plan = plan
        self.limits = limits
        self.loop_start = plan.loop.start if plan.loop is not None and plan.loop.period is not None else None
        self.parks = plan.loop is not None and plan.loop.period is None
        self.stays = list(self._stays())
        self.stretches = list(self._stretches())
        self.questions = 0
        self.known: dict[tuple[int, bool], Slack] = {}

    def slack(self, place: int) -> Slack:
        """The slack of one step."""
        known = self.plan.steps[place].slack
        if place == 0 or known is None:
            return known
        room = self.room(place)
        if room == 0:
            return room
        # The next change that can be seen: this step's own, or one that some time is left to reach.
        behind = next(
            (index for index, one in enumerate(self.stretches) if one.first >= place), len(self.stretches)
        )
        hidden = behind == len(self.stretches) or self.stretches[behind].first > place
        # Who waits unseen may wait on: the change may come later than the delay makes it.
        seen = self.delay_of(behind, or_later=hidden and self.workspace.waiting)
        if seen is not None:
            seen += self.spare(place, behind)
        limits = [limit for limit in (room, seen) if limit is not None]
        return max(known, min(limits)) if limits else None

    def room(self, place: int) -> Slack:
        """How much longer the stay before a step may be, by the map."""
        before = self.stays[place - 1]
        if before.most is None:
            return None
        return before.most - (self.stays[place].enter - before.enter)

    def spare(self, place: int, stretch: int) -> Fraction:
        """The time between a step and a later change that the moves do not need."""
        last = self.stretches[stretch].first if stretch < len(self.stretches) else len(self.stays)
        needed = self.needed[last] - self.needed[place]
        return self.entered(stretch) - self.stays[place].enter - needed

    def entered(self, stretch: int) -> Fraction:
        """When a stretch begins; behind the last one of a loop, when the next round does."""
        if stretch < len(self.stretches):
            return self.stretches[stretch].enter
        return self.plan.steps[-1].leave or self.stays[-1].enter

    def delay_of(self, stretch: int, *, or_later: bool) -> Slack:
        """How much later a stretch may begin, those before it as planned."""
        key = stretch, or_later
        if key not in self.known:
            known: Slack = Fraction(0)
            if stretch < len(self.stretches):
                known = self.plan.steps[self.stretches[stretch].first].slack

            def possible(delay: Fraction) -> bool:
                return self.possible(stretch, delay, or_later=or_later)

            self.known[key] = _largest(possible, known, self.tick, self.farthest)
        return self.known[key]

    def possible(self, stretch: int, delay: Fraction, *, or_later: bool) -> bool:
        """Whether the formula can still be satisfied; ``False`` also if that takes too long to find out."""
        self.questions += 1
        if self.questions > MOST_QUESTIONS or self.limits.over():
            return False
        limits = Limits(self.limits.remaining(), MOST_MEGABYTES).begin()
        try:
            network = Network(
                self.map(stretch, delay, or_later=or_later), self.obligations.transducers, self.predicates
            )
            if self.loop_start is not None:
                return isinstance(lassos(tabulate(network, objective=False), limits), Iterator)
            tables = tabulate(network)
            return isinstance(fastest_run(tables, limits, endings=not self.parks, parkings=self.parks), Found)
        except OverflowError:
            return False

    # -- the path ------------------------------------------------------------------------------------------

    def _stays(self) -> Iterator[_Stay]:
        workspace, steps = self.workspace, self.plan.steps
        cells = [index for index in (workspace.index_of(step.cell) for step in steps) if index is not None]
        labels = [workspace.label_sets[index] for index in workspace.label_of[cells].tolist()]
        ways = workspace.moves_along(
            [*cells, *(() if self.loop_start is None else (cells[self.loop_start],))]
        )
        for step, label, moves in zip(steps, labels, ways, strict=False):
            stay = (step.leave or step.enter) - step.enter
            least, most = next(times for times in map(self._times, moves) if _within(stay, *times))
            yield _Stay(label, step.enter, least, most)
        if self.loop_start is None:
            longest = self._longest_stay(workspace.moves_from(cells[-1]))
            yield _Stay(labels[-1] | {_ARRIVED}, steps[-1].enter, Fraction(0), longest)

    def _times(self, move: int) -> tuple[Fraction, Slack]:
        """The least and the longest stay before a move."""
        most = None if self.workspace.waiting else self.workspace.most_time(move)
        return self.workspace.least_time(move), most

    def _longest_stay(self, moves: Sequence[int]) -> Slack:
        longest = [self.workspace.most_time(move) for move in moves]
        limits = [most for most in longest if most is not None]
        if self.workspace.waiting or len(limits) < len(longest):
            return None
        return max(limits, default=Fraction(0))

    def _stretches(self) -> Iterator[_Stretch]:
        begins = [
            place
            for place, stay in enumerate(self.stays)
            if place in (0, self.loop_start) or stay.label != self.stays[place - 1].label
        ]
        for first, behind in zip(begins, [*begins[1:], len(self.stays)], strict=True):
            stays = self.stays[first:behind]
            longest = [stay.most for stay in stays]
            yield _Stretch(
                first,
                stays[0].label,
                stays[0].enter,
                _sum(stay.least for stay in stays),
                None if None in longest else _sum(longest),
            )

    # -- the line and its automata -------------------------------------------------------------------------

    def map(self, stretch: int, delay: Fraction, *, or_later: bool) -> MapAutomaton:
        """The path as a map: as planned up to a stretch, which begins later, and free from there on."""
        line = list(self.stretches)
        back = []
        if self.loop_start is not None:
            back = [one for one in line if one.first >= self.loop_start]
        spans: list[tuple[Fraction, Slack]] = []
        for index, one in enumerate((*line, *back)):
            if index < stretch:
                late = delay if index == stretch - 1 else Fraction(0)
                length = self.entered(index + 1) - one.enter + late
                spans.append((length, None if or_later and index == stretch - 1 else length))
            else:
                spans.append((one.least, one.most))
        durations = tuple(sorted({time for span in spans for time in span if time is not None}))
        number: dict[Slack, int] = {time: index for index, time in enumerate(durations)}
        number[None] = NEVER
        count = len(spans)
        targets = [*range(1, count), *([len(line)] if back else [])]
        moves = len(targets)
        return MapAutomaton(
            initial=(0,),
            label_sets=self.label_sets,
            label_of=np.array([self.label_sets.index(one.label) for one in (*line, *back)], dtype=np.int32),
            source=np.arange(moves, dtype=np.int32),
            target=np.array(targets, dtype=np.int32),
            durations=durations,
            least=np.array([number[least] for least, _ in spans[:moves]], dtype=np.int32),
            most=np.array([number[most] for _, most in spans[:moves]], dtype=np.int32),
            invariant=np.array([number[most] for _, most in spans], dtype=np.int32),
            may_park=self.parks,
        )

    @cached_property
    def needed(self) -> list[Fraction]:
        """The least time from the start to each stay, and to the end."""
        return list(accumulate((stay.least for stay in self.stays), initial=Fraction(0)))

    @cached_property
    def label_sets(self) -> tuple[frozenset[str], ...]:
        return tuple(dict.fromkeys(one.label for one in self.stretches))

    @cached_property
    def obligations(self) -> Obligations:
        arrives = () if self.loop_start is not None else (eventually(Literal(_ARRIVED)),)
        return translate(conjunction(self.core, *arrives), until_the_end=self.horizon == "finite")

    @cached_property
    def predicates(self) -> dict[str, frozenset[int]]:
        return {
            name: frozenset(index for index, label in enumerate(self.label_sets) if holds(predicate, label))
            for name, predicate in self.obligations.predicates.items()
        }

    @cached_property
    def tick(self) -> Fraction:
        """What all times are multiples of, in seconds."""
        times = [*_bounds(self.core), *self.workspace.durations, *(stay.enter for stay in self.stays)]
        times.append(self.entered(len(self.stretches)))
        return Fraction(1, lcm(*(time.denominator for time in times)))

    @cached_property
    def farthest(self) -> Fraction:
        """A delay so long that a longer one makes no difference, in seconds."""
        return sum(_bounds(self.core), self.entered(len(self.stretches))) + 1


def _within(stay: Fraction, least: Fraction, most: Slack) -> bool:
    return stay == least or (least < stay and (most is None or stay <= most))


def _sum(times: Iterable[Slack]) -> Fraction:
    """The sum of times of which few are different, none without limit."""
    return sum((time * count for time, count in Counter(times).items() if time is not None), Fraction(0))


def _largest(possible: Callable[[Fraction], bool], known: Slack, tick: Fraction, farthest: Fraction) -> Slack:
    """The end of the delays that are possible, from `known` on."""
    if known is None:
        return None

    def possible_behind(ticks: int) -> bool:
        return possible(ticks * tick + tick / 2)

    low = floor(known / tick)
    if not possible_behind(low):
        return known
    if possible(farthest):
        return None
    step = 1
    while possible_behind(low + step):
        low += step
        step *= 2
    while step > 1:
        step //= 2
        if possible_behind(low + step):
            low += step
    return (low + 1) * tick


def _bounds(core: Core) -> Sequence[Fraction]:
    """The finite ends of all intervals."""
    match core:
        case Conjunction(operands) | Disjunction(operands):
            return [bound for operand in operands for bound in _bounds(operand)]
        case CoreUntil(left, right, interval) | CoreRelease(left, right, interval):
            ends = [end for end in (interval.lower, interval.upper) if end is not None]
            return [*ends, *_bounds(left), *_bounds(right)]
        case _:
            return []
