"""Tours: the shortest loops through all that a mission asks to see again and again.

A mission for ever mostly asks to come back: ``G F_I q``. Every round of a loop then shows each of these
labels, so it takes no less than the shortest closed walk through them, with the way to it: a bound, and often
a good loop.

There is a proof in it, too. If no label may be away for longer than its deadline, look at any instant: of the
label that takes longest to come, the absence began before and ends after, and all the others are seen in it.
So if none can be away for so short a time that all the others are seen, there is no loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from math import lcm

import numpy as np
from numpy.typing import NDArray

from mitlplan.compose import compose
from mitlplan.logic.core import (
    FALSE,
    TRUE,
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Literal,
    always,
    conjunction,
    eventually,
    holds,
    negate,
)
from mitlplan.search.fastest import Exhausted, Found, Limits, Stopped, fastest_run
from mitlplan.search.schedule import STANDS_STILL, schedule
from mitlplan.search.tables import FARTHEST, nearest, tabulate
from mitlplan.translation.compact.translate import necessary_label
from mitlplan.workspace.compress import PlannedStay, compress, look_alike
from mitlplan.workspace.names import GridNames
from mitlplan.workspace.workspace import UNLIMITED, Workspace

MOST_HOMES = 8
"""A round may begin in any cell of one of its labels: for so many cells each is tried."""

MOST_VISITS = 6
"""The walk through n labels is sought among 2^n times as many states as there are cells."""

MOST_STATES = 4_000_000
"""So many states are searched to find the quickest loop rather than the shortest round."""

_HOME = Literal("home of the round")
_EPSILON = Fraction(1, 1000)


@dataclass(frozen=True, slots=True)
class Visit:
    """A label that is shown again and again, and, if a time is given, never away for longer, in seconds."""

    label: Core
    within: Fraction | None


@dataclass(frozen=True, slots=True)
class Recurring:
    """What a loop shows for ever.

    Parameters
    ----------
    visits
        Again and again.
    throughout
        A label that holds always, from some time on.
    from_start
        A label that holds always.
    """

    visits: tuple[Visit, ...]
    throughout: Core
    from_start: Core


PlannedLoop = tuple[tuple[PlannedStay, ...], tuple[PlannedStay, ...]]
"""A prefix and a cycle."""


@dataclass(frozen=True, slots=True)
class Tour:
    """What is known of loops from the order of their visits alone.

    Parameters
    ----------
    bound
        No loop ends its first round before, in seconds.
    loops
        Quick loops that make all visits, the quickest first. Whether they satisfy the mission is another
        question.
    possible
        ``False`` is a proof that there is no loop.
    states
        How many were stored to find out.
    """

    bound: Fraction = Fraction(0)
    loops: tuple[PlannedLoop, ...] = ()
    possible: bool = True
    states: int = 0


def recurring(core: Core) -> Recurring:
    """What every loop that satisfies `core` shows for ever.

    Examples
    --------
    >>> from mitlplan.logic.normalize import normalize
    >>> from mitlplan.logic.parse import parse
    >>> shown = recurring(normalize(parse("F B & G (!C & F[0,5] A)"), "standard", horizon="infinite"))
    >>> shown.visits
    (Visit(label=Literal(name='A', positive=True), within=Fraction(5, 1)),)
    >>> shown.throughout
    Literal(name='C', positive=False)
    """
    parts = list(_in_the_long_run(core))
    visits = tuple(dict.fromkeys(part for part in parts if isinstance(part, Visit)))
    throughout = conjunction(*(part for part in parts if not isinstance(part, Visit)))
    from_start = conjunction(
        *(
            necessary_label(part.right)
            for part in _conjuncts(core)
            if isinstance(part, CoreRelease) and part.left == FALSE and part.interval.unrestricted
        )
    )
    return Recurring(visits, throughout, from_start)


def _conjuncts(core: Core) -> tuple[Core, ...]:
    return core.operands if isinstance(core, Conjunction) else (core,)


def _in_the_long_run(core: Core) -> Iterator[Visit | Core]:
    """Visits and labels for ever that follow from `core` at some time."""
    match core:
        case Conjunction(operands):
            for operand in operands:
                yield from _in_the_long_run(operand)
        case CoreRelease(left, right, interval) if left == FALSE and interval.upper is None:
            yield from _for_ever(right)
        case CoreUntil(_, right, _):
            yield from _in_the_long_run(right)


def _for_ever(core: Core) -> Iterator[Visit | Core]:
    """Visits and labels for ever that follow if `core` holds at every late time."""
    yield necessary_label(core)
    match core:
        case Conjunction(operands):
            for operand in operands:
                yield from _for_ever(operand)
        case CoreUntil(_, right, interval):
            yield from _again(right, interval.upper)
        case CoreRelease(left, right, interval) if 0 in interval or left == FALSE:
            yield from _for_ever(right)


def _again(core: Core, within: Fraction | None) -> Iterator[Visit]:
    """Visits that follow if `core` holds at least once in any time as long as `within`."""
    label = necessary_label(core)
    if label != TRUE:
        yield Visit(label, within)
    for part in _conjuncts(core):
        if isinstance(part, CoreUntil):
            upper = part.interval.upper
            later = None if within is None or upper is None else within + upper
            yield from _again(part.right, later)


# ------------------------------------------------------------------------------------------------- the walks


@dataclass(frozen=True, slots=True)
class _Walk:
    """A least time, and the stays that take it; the last cell is entered then."""

    time: Fraction
    stays: tuple[PlannedStay, ...]


class _Seeker:
    """Looks for the fastest walks through labels, and keeps account."""

    def __init__(self, throughout: Core, limits: Limits) -> None:
        self.throughout = throughout
        self.limits = limits
        self.states = 0
        self.stopped = False

    def walk(
        self, workspace: Workspace, starts: Sequence[int], visits: Iterable[Core], goal: Core
    ) -> _Walk | None:
        """The fastest walk from a start that ends where `goal` holds, when all `visits` have been made."""
        if self.limits.over():
            self.stopped = True
            return None
        come = eventually(goal)
        parts = [eventually(conjunction(visit, come)) for visit in visits]
        core = conjunction(always(self.throughout), *(parts or [come]))
        # Where the robot must not wait it is still none the faster for waiting.
        classes = look_alike(workspace, compose(workspace, (0,), core).predicates.values())
        small = compress(replace(workspace, waiting=True), classes, starts)
        if small is None:
            network = compose(workspace, tuple(starts), core, horizon="finite")
        else:
            network = compose(small.workspace, small.starts, core, horizon="finite")
        tables = tabulate(network)
        result = fastest_run(tables, self.limits, parkings=False)
        self.states += result.states
        match result:
            case Exhausted():
                return None
            case Stopped():
                self.stopped = True
                return None
            case Found(path, time):
                moves = [step for step, row in enumerate(path.steps) if row[0] != STANDS_STILL]
                times = schedule(tables, path, _EPSILON, moves[:1]).times
                cells = tables.arrays["move_target"][path.steps[moves, 0]].tolist()
                stays = [
                    (cell, times[after] - times[step])
                    for cell, step, after in zip(cells, moves, [*moves[1:], moves[-1]], strict=True)
                ]
                return _Walk(time, tuple(stays if small is None else small.expand(stays)))


# ------------------------------------------------------------------------------------------------- the tours


def shortest_tour(workspace: Workspace, starts: Sequence[int], core: Core, limits: Limits) -> Tour:
    """The quickest loops that show what every loop must show again and again.

    Parameters
    ----------
    starts
        The cells in which the robot may start.
    core
        The mission, in normal form.

    Examples
    --------
    >>> from mitlplan.logic.normalize import normalize
    >>> from mitlplan.logic.parse import parse
    >>> from mitlplan.workspace import grid
    >>> hall = grid(1, 4, regions={"A": [(0, 0)], "B": [(0, 3)]})
    >>> patrol = normalize(parse("G F[0,5] A & G F[0,5] B"), "standard", horizon="infinite")
    >>> shortest_tour(hall, [1], patrol, Limits()).bound
    Fraction(6, 1)
    """
    shown = recurring(core)
    if not shown.visits or min(workspace.durations, default=0) == 0:
        return Tour()
    ways = _ways_from(workspace, starts, shown.from_start)
    if (ways.ticks == FARTHEST).any():
        return Tour()
    places = _places(workspace, shown, np.isfinite(ways.ticks))
    if any(len(cells) == 0 for _, cells in places):
        return Tour(possible=False)
    seeker = _Seeker(shown.throughout, limits)
    if _none_is_quick_enough(workspace, places, seeker):
        return Tour(possible=False, states=seeker.states)
    _, homes = places[0]
    if len(homes) > MOST_HOMES:
        return Tour(states=seeker.states)
    return _tour(workspace, ways, places, homes.tolist(), seeker)


def _tour(
    workspace: Workspace, ways: _Ways, places: Sequence[_Place], homes: Sequence[int], seeker: _Seeker
) -> Tour:
    rounds = {home: _round_from(workspace, home, places, seeker) for home in homes}
    found = {home: walk for home, walk in rounds.items() if walk is not None}
    if seeker.stopped or not found:
        return Tour(possible=seeker.stopped, states=seeker.states)
    loops = {home: ways.into(walk.stays[:-1]) for home, walk in found.items()}
    bounds = {home: walk.time for home, walk in found.items()}
    if workspace.cell_count << len(places) <= MOST_STATES:
        # The shortest round need not be the one that is entered first.
        for home in sorted(found, key=bounds.__getitem__):
            if bounds[home] < min(map(_makespan, loops.values())):
                joint = _joint(workspace, ways, home, places, seeker)
                if joint is not None:
                    bounds[home] = _makespan(joint)
                    loops[home] = min(loops[home], joint, key=_makespan)
    quickest = sorted(loops.values(), key=_makespan)
    return Tour(min(bounds.values()), tuple(quickest), states=seeker.states)


def _makespan(loop: PlannedLoop) -> Fraction:
    prefix, cycle = loop
    return sum((duration for _, duration in (*prefix, *cycle)), Fraction(0))


@dataclass(frozen=True, eq=False)
class _Ways:
    """The fastest ways from the starts: the ticks to each cell, as floats, the cell before, and ticks a
    second.
    """

    ticks: NDArray[np.float64]
    before: NDArray[np.int32]
    scale: int

    def to(self, cell: int) -> tuple[PlannedStay, ...]:
        """The stays on the way to a cell."""
        way = [cell]
        while self.before[way[-1]] >= 0:
            way.append(int(self.before[way[-1]]))
        return tuple(
            (at, Fraction(int(self.ticks[after] - self.ticks[at]), self.scale))
            for at, after in pairwise(way[::-1])
        )

    def into(self, stays: Sequence[PlannedStay]) -> PlannedLoop:
        """The loop that enters a round where it can first be entered."""
        entry = int(np.argmin(self.ticks[[cell for cell, _ in stays]]))
        return self.to(stays[entry][0]), (*stays[entry:], *stays[:entry])


def _ways_from(workspace: Workspace, starts: Sequence[int], through: Core) -> _Ways:
    count = workspace.cell_count
    scale = lcm(*(duration.denominator for duration in workspace.durations))
    ticks = np.array([int(duration * scale) for duration in workspace.durations], dtype=np.int64)
    where = _where(workspace, through)
    allowed = where[workspace.target]
    source, target, least = (
        column if allowed.all() else column[allowed]
        for column in (workspace.source, workspace.target, workspace.least)
    )
    begins = np.array([start for start in starts if where[start]], dtype=np.int32)
    reached = nearest(count, target, source, least, ticks, [begins])[0]
    before = np.full(count, -1, dtype=np.int32)
    # Every move takes time, so what comes last on a fastest way comes from a place that is nearer.
    last = (reached[source] >= 0) & (reached[source] + ticks[least] == reached[target])
    before[target[last]] = source[last]
    return _Ways(np.where(reached < 0, np.inf, reached), before, scale)


_Place = tuple[Visit, NDArray[np.intp]]


def _places(workspace: Workspace, shown: Recurring, reached: NDArray[np.bool_]) -> list[_Place]:
    """The visits and the cells to make them in, the fewest cells first; without those that others include."""
    allowed = reached & _where(workspace, shown.throughout)
    places = [(visit, _where(workspace, visit.label) & allowed) for visit in shown.visits]
    # Of visits in the same cells the most urgent comes first, and stands for all.
    places.sort(key=lambda place: (int(place[1].sum()), place[0].within is None, place[0].within or 0))
    kept: list[tuple[Visit, NDArray[np.bool_]]] = []
    for visit, where in places:
        if not any((other <= where).all() for _, other in kept):
            kept.append((visit, where))
    return [(visit, np.flatnonzero(where)) for visit, where in kept[:MOST_VISITS]]


def _where(workspace: Workspace, label: Core) -> NDArray[np.bool_]:
    """The cells in which a propositional formula holds."""
    return np.array([holds(label, shown) for shown in workspace.label_sets])[workspace.label_of]


def _none_is_quick_enough(workspace: Workspace, places: Sequence[_Place], seeker: _Seeker) -> bool:
    """Whether each label would have to stay away for too long to see all the others meanwhile."""
    urgent = [place for place in places if place[0].within is not None]
    if len(urgent) < 2:
        return False
    if len(reduce(np.intersect1d, [cells for _, cells in urgent])):
        return False
    for visit, cells in urgent:
        inside = np.zeros(workspace.cell_count, dtype=bool)
        inside[cells] = True
        leaves = inside[workspace.source] & ~inside[workspace.target]
        starts = np.unique(workspace.target[leaves]).tolist()
        others = [other.label for other, _ in urgent if other != visit]
        walk = seeker.walk(workspace, starts, others, visit.label) if starts else None
        if seeker.stopped or (walk is not None and visit.within is not None and walk.time <= visit.within):
            return False
    return True


def _round_from(workspace: Workspace, home: int, places: Sequence[_Place], seeker: _Seeker) -> _Walk | None:
    """The shortest closed walk from a cell through all labels."""
    others = [visit.label for visit, cells in places if home not in cells]
    walk = seeker.walk(_with_home(workspace, home), (home,), others or (negate(_HOME),), _HOME)
    to_itself = [
        workspace.least_time(move)
        for move in workspace.moves_from(home)
        if int(workspace.target[move]) == home
    ]
    if others or not to_itself or (walk is not None and walk.time <= min(to_itself)):
        return walk
    return _Walk(min(to_itself), ((home, min(to_itself)), (home, Fraction(0))))


def _joint(
    workspace: Workspace, ways: _Ways, home: int, places: Sequence[_Place], seeker: _Seeker
) -> PlannedLoop | None:
    """The quickest loop through a cell and all labels, the way to it included.

    The round is walked from `home` to `home`. Somewhere on it the loop is entered: there the robot changes to
    a copy of the map, with a move that takes as much longer as the way from the start to that cell, and only
    there is it home.
    """
    count = workspace.cell_count
    twice = _with_copy(workspace, ways)
    others = [visit.label for visit, cells in places if home not in cells]
    walk = seeker.walk(_with_home(twice, home + count), (home,), others, _HOME)
    if walk is None:
        return None
    entry = next(place for place, (cell, _) in enumerate(walk.stays[1:]) if cell >= count)
    stays = [(cell % count, duration) for cell, duration in walk.stays[:-1]]
    before, duration = stays[entry]
    stays[entry] = before, duration - Fraction(int(ways.ticks[before]), ways.scale)
    return ways.to(before), (*stays[entry:], *stays[:entry])


def _with_copy(workspace: Workspace, ways: _Ways) -> Workspace:
    """The map and a copy: every move leads there as well, and takes longer by the way to where it begins."""
    count = workspace.cell_count
    durations = [int(duration * ways.scale) for duration in workspace.durations]
    times = np.array(durations, dtype=np.int64)[workspace.least]
    enters = np.isfinite(ways.ticks[workspace.source])
    extra = ways.ticks[workspace.source[enters]].astype(np.int64)
    source = np.concatenate([workspace.source, workspace.source[enters], workspace.source + count])
    target = np.concatenate([workspace.target, workspace.target[enters] + count, workspace.target + count])
    ticks = np.concatenate([times, times[enters] + extra, times])
    # The moves of each copy are in order, and the first copy comes first: only sources have to be merged.
    order = np.argsort(source, kind="stable")
    distinct, least = _distinct(ticks[order])
    return Workspace(
        names=GridNames((1, 2 * count), np.arange(2 * count)),
        label_sets=workspace.label_sets,
        label_of=np.tile(workspace.label_of, 2),
        source=source[order],
        target=target[order],
        durations=tuple(Fraction(tick, ways.scale) for tick in distinct.tolist()),
        least=least,
        most=np.full(len(order), UNLIMITED, dtype=np.int32),
        waiting=True,
    )


def _distinct(ticks: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """The distinct times in order, and the number of each among them."""
    largest = int(ticks.max(initial=0))
    if largest > len(ticks):
        distinct, which = np.unique(ticks, return_inverse=True)
        return distinct, which.reshape(-1).astype(np.int32)
    occurs = np.zeros(largest + 1, dtype=np.bool_)
    occurs[ticks] = True
    return np.flatnonzero(occurs), (np.cumsum(occurs, dtype=np.int32) - 1)[ticks]


def _with_home(workspace: Workspace, home: int) -> Workspace:
    """The workspace with one more proposition, that holds in this cell alone."""
    label_of = workspace.label_of.copy()
    label_of[home] = len(workspace.label_sets)
    label_sets = (*workspace.label_sets, workspace.holds(home) | {_HOME.name})
    return replace(workspace, label_sets=label_sets, label_of=label_of)
