"""Looping plans: the least prefix and cycle that satisfy the mission for ever.

The makespan of a loop is that of the robot's signal, not of the automata that watch it: they may need
several rounds to settle. So three things are put together. A *lower bound*: whatever the loop ever shows it
has shown once when its first round ends, hence a relaxed mission, without bounds and without "again", is
accomplished by then. *Lassos* of the zone graph, timed exactly and folded to the shortest prefix and cycle
with the same signal: they prove that there is a loop, or that there is none. *Walks* of the robot in order
of duration, each closed wherever it comes back to a cell and put to the judge: the first that passes is the
fastest. Walks stop at the best lasso, or when their number does; the answer then carries the bound that was
reached.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from heapq import heappop, heappush
from itertools import islice, pairwise
from math import ceil
from typing import Any, TypeAlias
from typing import Literal as Choice

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from mitlplan.automata.transducer import Constraint, Edge, Location, Relation, Transducer
from mitlplan.compose import Construction, compose
from mitlplan.errors import OutOfTime
from mitlplan.logic.core import Core
from mitlplan.logic.formula import And, Formula, Not
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.search.fastest import Exhausted, Found, Limits, Stopped, fastest_run
from mitlplan.search.lasso import Lasso, Timetable, lassos, timetable
from mitlplan.search.schedule import STANDS_STILL
from mitlplan.search.tables import Tables, tabulate, ticks_per_second
from mitlplan.tour import shortest_tour
from mitlplan.translation.compact.relax import relax
from mitlplan.workspace.compress import Compressed, compress, look_alike
from mitlplan.workspace.workspace import UNLIMITED, Workspace

LASSOS = 200
"""How many lassos of the zone graph are timed and put to the judge."""

FEW_CELLS = 64
"""On maps of up to so many cells walks are tried before the zone graph is explored."""

WALKS = 4_000
"""How many walks are looked at before the best loop known is taken."""

EFFORTS = ((300, 20_000), (WALKS, None))
"""Where no loop is known: how many walks, then how many states of the zone graph; then more of both."""

HOPELESSLY_MANY = 300_000
"""If so many walks end before any loop can, none is looked at."""


Rival: TypeAlias = tuple[Fraction, int]
"""What a loop has to beat: a makespan, in seconds, and a number of moves."""


@dataclass(frozen=True, slots=True)
class Stay:
    """A stay in a cell, for a time in seconds."""

    cell: int
    duration: Fraction


@dataclass(frozen=True, slots=True)
class Round:
    """The stays before a loop, and those of one round of it."""

    prefix: tuple[Stay, ...]
    cycle: tuple[Stay, ...]

    @property
    def makespan(self) -> Fraction:
        """The duration of the prefix and one round, in seconds."""
        return sum((stay.duration for stay in (*self.prefix, *self.cycle)), Fraction(0))

    @property
    def rival(self) -> Rival:
        """What another loop has to beat."""
        return self.makespan, self.moves

    @property
    def moves(self) -> int:
        """The number of moves in the prefix and one round."""
        return len(self.prefix) + len(self.cycle)


def fold(prefix: Sequence[Stay], cycle: Sequence[Stay]) -> Round:
    """The shortest prefix and cycle that go on for ever in the same way.

    Examples
    --------
    >>> a, b = Stay(0, Fraction(1)), Stay(1, Fraction(1))
    >>> fold([a, b, a], [b, a, b, a]) == Round((), (a, b))
    True
    """
    shortest = next(
        length
        for length in range(1, len(cycle) + 1)
        if len(cycle) % length == 0 and all(cycle[k] == cycle[k - length] for k in range(length, len(cycle)))
    )
    before, again = list(prefix), list(cycle[:shortest])
    while before and before[-1] == again[-1]:
        again.insert(0, again.pop())
        before.pop()
    return Round(tuple(before), tuple(again))


def signal_of_round(workspace: Workspace, loop: Round) -> Signal:
    """What the robot shows for ever."""
    segments = []
    now = Fraction(0)
    repeat_from = Fraction(0)
    for place, stay in enumerate((*loop.prefix, *loop.cycle)):
        if place == len(loop.prefix):
            repeat_from = now
        segments.append(Segment(now, workspace.holds(stay.cell)))
        now += stay.duration
    return Signal(tuple(segments), now, repeat_from)


@dataclass(frozen=True, slots=True)
class Walks:
    """The outcome of looking at walks.

    Parameters
    ----------
    loop
        The fastest loop among the walks looked at, if there is one.
    complete_up_to
        Every walk shorter than this was looked at, in seconds; ``None`` means every walk there is.
    """

    loop: Round | None
    complete_up_to: Fraction | None


@dataclass(frozen=True, slots=True, order=True)
class _Arrival:
    time: Fraction
    moves: int
    number: int
    cell: int = field(compare=False)
    before: _Arrival | None = field(compare=False)
    walk_on: tuple[int, Fraction] | None = field(compare=False, default=None)


def fastest_walk(
    workspace: Workspace,
    start: int,
    formulas: Sequence[Formula],
    *,
    until: Choice["standard", "closed"],
    tick: Fraction,
    above: Fraction,
    below: Rival | None,
    limits: Limits,
    most: int = WALKS,
) -> Walks:
    """The fastest loop by trying walks in order of their duration, then of their moves.

    Parameters
    ----------
    tick
        Where the length of a stay is free, it is tried in steps of this, in seconds.
    above, below
        Of no interest are loops whose first round ends before `above`, in seconds, or that do not beat
        `below`.
    most
        How many walks are looked at.
    """
    if _many_walks(workspace, start, tick, above):
        return Walks(None, above)
    violated: Formula = Not(And(tuple(formulas))) if len(formulas) > 1 else Not(formulas[0])
    queue = [_Arrival(Fraction(0), 0, 0, start, None)]
    numbers = 0
    looked_at = 0
    while queue:
        at = heappop(queue)
        if below is not None and (at.time, at.moves) >= below:
            return Walks(None, below[0])
        if at.walk_on is not None:
            # The same move after a stay one tick longer.
            assert at.before is not None
            move, stay = at.walk_on
            numbers += 1
            longer = _move(workspace, at.before, move, stay + tick, tick, numbers)
            if longer is not None:
                heappush(queue, longer)
        looked_at += 1
        if looked_at > most or limits.over():
            return Walks(None, at.time)
        if at.time >= above:
            for loop in _closings(at):
                signal = signal_of_round(workspace, loop)
                looked_at += 1
                if all(satisfies(formula, signal, until=until) for formula in formulas):
                    return Walks(loop, at.time)
        if satisfies(violated, _seen(workspace, at), until=until):
            continue
        for move in workspace.moves_from(at.cell):
            numbers += 1
            stay = max(workspace.least_time(move), tick if workspace.least_time(move) == 0 else Fraction(0))
            following = _move(workspace, at, move, stay, tick, numbers)
            if following is not None:
                heappush(queue, following)
    return Walks(None, None)


def _move(
    workspace: Workspace, at: _Arrival, move: int, stay: Fraction, tick: Fraction, number: int
) -> _Arrival | None:
    most = None if workspace.waiting else workspace.most_time(move)
    if most is not None and stay > most:
        return None
    walk_on = (move, stay) if most is None or stay + tick <= most else None
    return _Arrival(at.time + stay, at.moves + 1, number, int(workspace.target[move]), at, walk_on)


def _many_walks(workspace: Workspace, start: int, tick: Fraction, before: Fraction) -> bool:
    """Whether hopelessly many walks end before a time; free stays are counted in steps of a tick."""
    if workspace.move_count == 0:
        return False
    least = [max(workspace.durations[index], tick) for index in range(len(workspace.durations))]
    groups = [
        (least[index], np.flatnonzero(workspace.least == index)) for index in np.unique(workspace.least)
    ]
    free = workspace.waiting | (workspace.most == UNLIMITED)
    none = np.zeros(workspace.move_count)
    # How often each move is made, by the time when.
    made: dict[Fraction, NDArray[np.float64]] = {}
    arrivals: NDArray[np.float64] = np.zeros(workspace.cell_count)
    arrivals[start] = 1
    now, count = Fraction(0), 1.0
    while count < HOPELESSLY_MANY:
        for time, moves in groups:
            onward = arrivals[workspace.source[moves]]
            if onward.any():
                made.setdefault(now + time, none.copy())[moves] += onward
        now = min(made, default=before)
        if now >= before:
            return False
        moved = made.pop(now)
        if (moved * free).any():
            made.setdefault(now + tick, none.copy())[:] += moved * free
        arrivals = np.bincount(workspace.target, moved, workspace.cell_count).astype(np.float64)
        count += float(arrivals.sum())
    return True


def _way_to(at: _Arrival) -> list[_Arrival]:
    way = [at]
    while way[-1].before is not None:
        way.append(way[-1].before)
    return way[::-1]


def _closings(at: _Arrival) -> Iterator[Round]:
    way = _way_to(at)
    stays = [Stay(one.cell, after.time - one.time) for one, after in pairwise(way)]
    for place, stay in enumerate(stays):
        if stay.cell == at.cell:
            yield Round(tuple(stays[:place]), tuple(stays[place:]))


def _seen(workspace: Workspace, at: _Arrival) -> Signal:
    segments = tuple(Segment(one.time, workspace.holds(one.cell)) for one in _way_to(at))
    return Signal(segments, at.time)


# ------------------------------------------------------------------------------------------------ together


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked of a loop: the world, the requirements, and how they are read."""

    workspace: Workspace
    starts: tuple[int, ...]
    formulas: tuple[Formula, ...]
    core: Core
    until: Choice["standard", "closed"]
    epsilon: Fraction
    construction: Construction = "compact"

    def satisfied_by(self, loop: Round) -> bool:
        """Whether the judge passes the loop."""
        signal = signal_of_round(self.workspace, loop)
        return all(satisfies(formula, signal, until=self.until) for formula in self.formulas)


@dataclass(frozen=True, slots=True)
class Loops:
    """What is known of the looping plans.

    Parameters
    ----------
    loop
        The fastest one found that is faster than what was to beat.
    bound
        No loop ends its first round before this, in seconds.
    exists
        Whether there is any loop: ``False`` is a proof, ``None`` says that it was not settled, for this
        `reason`.
    """

    loop: Round | None = None
    bound: Fraction = Fraction(0)
    exists: bool | None = None
    reason: str = ""
    states: int = 0


def fastest_loop(question: Question, to_beat: Rival | None, limits: Limits) -> Loops:
    """The fastest looping plan, if it beats the best plan of another kind."""
    shown = _shown_by(question, limits)
    match shown:
        case Exhausted(states):
            return Loops(exists=False, states=states)
        case Stopped(reason, bound, states):
            return Loops(bound=bound or Fraction(0), reason=reason, states=states)
        case Found(_, bound, _, states):
            # The robot has still to stay in the cell in which it has shown everything.
            bound += _shortest_stay(question.workspace, question.starts)
    if to_beat is not None and bound > to_beat[0]:
        return Loops(bound=bound, states=states)
    known = _loop_of_tour(question, limits)
    known = replace(known, bound=max(bound, known.bound), states=known.states + states)
    if known.exists is False:
        return known
    if known.loop is not None and (to_beat is None or known.loop.rival < to_beat):
        to_beat = known.loop.rival
    else:
        known = replace(known, loop=None)
    given = _stays_are_given(question.workspace)
    for most_walks, most_states in EFFORTS:
        if to_beat is not None:
            break
        tried = Walks(None, known.bound)
        if question.workspace.cell_count <= FEW_CELLS:
            # On a small map the first loop that passes the judge is found before the zone graph is complete.
            tried = _walks(question, known.bound, None, limits, most_walks)
        if tried.loop is not None:
            reached = tried.loop.makespan if given else known.bound
            return replace(known, loop=tried.loop, bound=reached, exists=True)
        if tried.complete_up_to is None and given:
            return replace(known, exists=False)
        found = _loop_of_zone_graph(question, limits, most_states)
        known = replace(found, bound=max(known.bound, found.bound), states=known.states + found.states)
        if known.exists is False:
            return known
        if known.loop is not None:
            to_beat = known.loop.rival
    if to_beat is None or _least_rival(question.workspace, known.bound) >= to_beat:
        return known
    try:
        walks = _walks(question, known.bound, to_beat, limits)
    except OutOfTime:
        return known
    reached = to_beat[0] if walks.complete_up_to is None else walks.complete_up_to
    if not given:
        reached = known.bound
    return replace(known, loop=walks.loop or known.loop, bound=max(known.bound, min(reached, to_beat[0])))


def _walks(
    question: Question, above: Fraction, below: Rival | None, limits: Limits, most: int = WALKS
) -> Walks:
    return fastest_walk(
        question.workspace,
        question.starts[0],
        question.formulas,
        until=question.until,
        tick=_tick(question),
        above=above,
        below=below,
        limits=limits,
        most=most,
    )


def any_loop(question: Question, limits: Limits) -> Loops:
    """A loop, or a proof that there is none."""
    known = _loop_of_tour(question, limits)
    if known.loop is not None or known.exists is False:
        return known
    workspace = question.workspace
    if workspace.cell_count <= FEW_CELLS and _stays_are_given(workspace):
        tried = _walks(question, known.bound, None, limits, EFFORTS[0][0])
        if tried.loop is not None or tried.complete_up_to is None:
            return replace(known, loop=tried.loop, exists=tried.loop is not None)
    found = _loop_of_zone_graph(question, limits)
    return replace(found, bound=max(known.bound, found.bound), states=known.states + found.states)


def _loop_of_tour(question: Question, limits: Limits) -> Loops:
    """The quickest loop along a tour that passes the judge."""
    tour = shortest_tour(question.workspace, question.starts, question.core, limits)
    loops = (
        fold([Stay(*stay) for stay in prefix], [Stay(*stay) for stay in cycle])
        for prefix, cycle in tour.loops
    )
    loop = next(filter(question.satisfied_by, loops), None)
    exists = tour.possible and (True if loop else None)
    return Loops(loop, tour.bound, exists, states=tour.states)


def _loop_of_zone_graph(question: Question, limits: Limits, most_states: int | None = None) -> Loops:
    """The best of some loops of the zone graph, or a proof that it has none."""
    construction = question.construction
    network = compose(question.workspace, question.starts, question.core, construction=construction)
    classes = look_alike(question.workspace, network.predicates.values())
    small = compress(question.workspace, classes, question.starts)
    if small is not None:
        network = compose(small.workspace, small.starts, question.core, construction=construction)
    if not question.workspace.durations or min(question.workspace.durations) == 0:
        network = replace(network, transducers=(*network.transducers, _CLOCKWORK))
    tables = tabulate(network, objective=False)
    found = lassos(tables, limits, most_states)
    match found:
        case Exhausted(states):
            return Loops(exists=False, states=states)
        case Stopped(reason, _, states):
            return Loops(reason=reason, states=states)
        case _:
            pass
    best: Round | None = None
    try:
        for lasso in islice(found, LASSOS):
            limits.look()
            times = timetable(tables, lasso, question.epsilon)
            if times is None:
                continue
            loop = _round_of(tables, lasso, times)
            if small is not None:
                loop = _expanded(small, loop)
            if (best is None or loop.rival < best.rival) and (question.satisfied_by(loop)):
                best = loop
    except OutOfTime:
        if best is None:
            return Loops(reason=limits.out_of_time)
    if best is None:
        return Loops(
            reason="there are infinite runs, but no exactly periodic one was found among their loops"
        )
    return Loops(loop=best, exists=True)


def _expanded(small: Compressed, loop: Round) -> Round:
    """A loop of the small map as one of the large map that shows the same."""

    def ways(stays: Sequence[Stay]) -> list[Stay]:
        pairs = [(stay.cell, stay.duration) for stay in stays]
        return [Stay(*pair) for pair in small.expand(pairs, then=loop.cycle[0].cell)]

    return fold(ways(loop.prefix), ways(loop.cycle))


_UNIT = Fraction(1)
_CLOCKWORK = Transducer(
    "time goes on",
    (Location("ticking"),),
    (
        Edge("ticking", "ticking", (Constraint("tick", Relation.LESS, _UNIT),)),
        Edge(
            "ticking",
            "ticking",
            (Constraint("tick", Relation.AT_LEAST, _UNIT),),
            frozenset(("tick",)),
            marked=True,
        ),
    ),
    (),
    (),
    acceptance=True,
)
"""Where moves may take no time, a loop must still not squeeze infinitely many of them into a bounded time."""


def _shown_by(question: Question, limits: Limits) -> Found | Exhausted | Stopped:
    network = compose(question.workspace, question.starts, relax(question.core), horizon="finite")
    return fastest_run(tabulate(network), limits, parkings=False)


def _tick(question: Question) -> Fraction:
    """The resolution at which stays of free length are tried, in seconds."""
    network = compose(question.workspace, question.starts, question.core)
    return Fraction(1, ticks_per_second(network))


def _shortest_stay(workspace: Workspace, starts: tuple[int, ...]) -> Fraction:
    """No stay that the robot can come to is shorter, in seconds."""
    count = workspace.cell_count
    if workspace.move_count and workspace.least.min() == workspace.least.max():
        return workspace.durations[int(workspace.least[0])]
    graph: Any = csr_array(
        (np.ones(workspace.move_count, dtype=np.int8), (workspace.source, workspace.target)), (count, count)
    )
    within = np.zeros(count, dtype=bool)
    for start in starts:
        if not within[start]:
            within[breadth_first_order(graph, start, return_predecessors=False)] = True
    least = np.unique(workspace.least[within[workspace.source]])
    return min((workspace.durations[index] for index in least), default=Fraction(0))


def _least_rival(workspace: Workspace, bound: Fraction) -> Rival:
    """No loop whose first round ends at `bound`, in seconds, or later is better than this."""
    if workspace.waiting or bool((workspace.most == UNLIMITED).any()):
        return bound, 0
    longest = max((workspace.durations[index] for index in np.unique(workspace.most)), default=Fraction(0))
    return bound, 0 if longest == 0 else ceil(bound / longest)


def _stays_are_given(workspace: Workspace) -> bool:
    """Whether every stay has the length that its move prescribes."""
    return not workspace.waiting and bool((workspace.least == workspace.most).all())


def _round_of(tables: Tables, lasso: Lasso, times: Timetable) -> Round:
    """The stays of a timed lasso of the zone graph, folded."""
    first = len(lasso.prefix) - 1
    length = len(lasso.round)

    def at(step: int) -> Fraction:
        rounds, place = divmod(max(0, step - first), length) if step > first else (0, 0)
        return times.times[first + place] + rounds * times.period if step > first else times.times[step]

    edges = [*lasso.prefix[:, 0].tolist(), *lasso.round[:, 0].tolist(), *lasso.round[:, 0].tolist()]
    moves = [(step, edge) for step, edge in enumerate(edges) if edge != STANDS_STILL]
    cells = tables.arrays["move_target"]
    stays = [Stay(int(cells[edge]), at(after) - at(step)) for (step, edge), (after, _) in pairwise(moves)]
    # A round begins with the first move in it.
    begin = next(index for index, (step, _) in enumerate(moves) if step > first)
    moves_a_round = sum(1 for edge in lasso.round[:, 0].tolist() if edge != STANDS_STILL)
    return fold(stays[:begin], stays[begin : begin + moves_a_round])
