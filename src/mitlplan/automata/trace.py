"""Traces of a network: exact times for a sequence of moves, and the check that they are a run.

Another tool, or a search over zones, says which edges are taken one after the other. The earliest times at
which they can be taken are a linear program in the delays: a clock is the sum of the delays since its reset
during which it was not stopped. Its solution is made exact and then executed step by step, with the same
rules for everybody (:func:`execute`); what cannot be executed is no trace. Where a strict bound keeps the
least time from being attained, the times are within an epsilon of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from mitlplan.automata.timed_automaton import (
    Automaton,
    Edge,
    Location,
    Network,
    Target,
    Urgency,
    holds,
    ticks_per_second,
    value_of,
)
from mitlplan.automata.transducer import Guard, Relation

Move: TypeAlias = tuple[tuple[int, int], ...]
"""The edges taken at once, as pairs of automaton and edge; the sender is the first."""

MOST_HALVINGS = 20
LARGEST_DENOMINATOR = 1_000_000


@dataclass(frozen=True, slots=True)
class Trace:
    """Moves and when they are made.

    Parameters
    ----------
    moves, times
        As many of one as of the other; times in seconds, not decreasing.
    attained
        Whether no other times for the same moves end earlier; otherwise their infimum is `least`.
    least
        The infimum of the time of the end.
    end
        When all is done: not before the last move, but later where the target asks for a delay.
    """

    moves: tuple[Move, ...]
    times: tuple[Fraction, ...]
    attained: bool = True
    least: Fraction = Fraction(0)
    end: Fraction = Fraction(0)


@dataclass(slots=True)
class _State:
    locations: list[int]
    clocks: dict[str, Fraction]
    values: dict[str, int]


def located(network: Network, moves: Sequence[Move]) -> Iterator[tuple[Location, ...]]:
    """The locations before each move, and after the last."""
    at = [automaton.initial for automaton in network.automata]
    yield _locations(network, at)
    for move in moves:
        for place, index in move:
            at[place] = network.automata[place].edges[index].target
        yield _locations(network, at)


def _locations(network: Network, at: Sequence[int]) -> tuple[Location, ...]:
    return tuple(each.locations[index] for each, index in zip(network.automata, at, strict=True))


def stays(
    network: Network, trace: Trace, place: int, cells: Sequence[int | None]
) -> tuple[tuple[int, Fraction], ...]:
    """The cells through which an automaton goes, and when it enters them.

    Parameters
    ----------
    place
        The index of the automaton that stands for the robot.
    cells
        For each of its locations the cell, or ``None``.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Automaton, Edge, Location
    >>> robot = Automaton("robot", (Location("a"), Location("b")), (Edge(0, 1),))
    >>> stays(Network((robot,)), Trace((((0, 0),),), (Fraction(2),)), 0, (4, 7))
    ((4, Fraction(0, 1)), (7, Fraction(2, 1)))
    """
    entered: list[tuple[int, Fraction]] = []
    automaton = network.automata[place]
    first = cells[automaton.initial]
    if first is not None:
        entered.append((first, Fraction(0)))
    for move, time in zip(trace.moves, trace.times, strict=True):
        for mover, index in move:
            cell = cells[automaton.edges[index].target] if mover == place else None
            if cell is not None and (not entered or entered[-1][0] != cell):
                entered.append((cell, time))
    return tuple(entered)


# -- execution -----------------------------------------------------------------------------------------


def execute(network: Network, trace: Trace, target: Target | None = None) -> str | None:
    """Make the moves at their times, and say what is wrong with the first that cannot be made.

    Parameters
    ----------
    target
        What must hold at the end, if anything.

    Returns
    -------
    str or None
        ``None`` if the trace is a run of the network.
    """
    state = _started(network)
    now = Fraction(0)
    if problem := _broken_invariant(network, state):
        return f"at 0: {problem}"
    for move, time in zip(trace.moves, trace.times, strict=True):
        if problem := _delayed(network, state, time - now) or _moved(network, state, move):
            return f"at {time}: {problem}"
        now = time
    if target is None:
        return None
    if problem := _delayed(network, state, trace.end - now) or _missed(network, state, target):
        return f"at {trace.end}: {problem}"
    return None


def _started(network: Network) -> _State:
    return _State(
        [automaton.initial for automaton in network.automata],
        dict.fromkeys(network.clocks, Fraction(0)),
        {variable.name: variable.initial for variable in network.variables},
    )


def _missed(network: Network, state: _State, target: Target) -> str:
    """What `target` asks for and the state has not."""
    for automaton, at in zip(network.automata, _locations(network, state.locations), strict=True):
        wanted = target.locations.get(automaton.name, at.name)
        if wanted != at.name:
            return f"{automaton.name} is in {at.name}, not in {wanted}"
    for constraint in target.guard:
        if not _compared(state.clocks[constraint.clock], constraint.relation, constraint.bound):
            return f"{constraint} does not hold"
    if not all(holds(test, state.values) for test in target.tests):
        return "a test of the target does not hold"
    return ""


def _delayed(network: Network, state: _State, delay: Fraction) -> str:
    if delay < 0:
        return "time runs backwards"
    if delay == 0:
        return ""
    here = _locations(network, state.locations)
    for location in here:
        if location.urgency is not Urgency.NORMAL:
            return f"no time may pass in {location.name}"
    stopped = frozenset[str]().union(*(location.stopped for location in here))
    for clock in state.clocks:
        if clock not in stopped:
            state.clocks[clock] += delay
    return _broken_invariant(network, state)


def _broken_invariant(network: Network, state: _State) -> str:
    for location in _locations(network, state.locations):
        for constraint in location.invariant:
            if not _compared(state.clocks[constraint.clock], constraint.relation, constraint.bound):
                return f"the invariant {constraint} of {location.name} does not hold"
    return ""


def _compared(value: Fraction, relation: Relation, bound: Fraction) -> bool:
    match relation:
        case Relation.LESS:
            return value < bound
        case Relation.AT_MOST:
            return value <= bound
        case Relation.AT_LEAST:
            return value >= bound
        case Relation.GREATER:
            return value > bound


def _moved(network: Network, state: _State, move: Move) -> str:
    edges = [(place, network.automata[place].edges[index]) for place, index in move]
    for place, edge in edges:
        if state.locations[place] != edge.source:
            return f"{network.automata[place].name} is somewhere else"
        if not _enabled(state.clocks, state.values, edge):
            return f"a guard of {network.automata[place].name} does not hold"
    if problem := _unfit(network, state, edges):
        return problem
    for place, edge in edges:
        state.locations[place] = edge.target
        state.clocks.update(dict.fromkeys(edge.resets, Fraction(0)))
        for assignment in edge.assignments:
            state.values[assignment.variable] = value_of(assignment.value, state.values)
            if problem := _out_of_range(network, state, assignment.variable):
                return problem
    return _broken_invariant(network, state)


def _out_of_range(network: Network, state: _State, name: str) -> str:
    variable = next(each for each in network.variables if each.name == name)
    inside = variable.least <= state.values[name] <= variable.most
    return "" if inside else f"{name} leaves its range"


def _enabled(clocks: Mapping[str, Fraction], values: Mapping[str, int], edge: Edge) -> bool:
    fits = all(_compared(clocks[each.clock], each.relation, each.bound) for each in edge.guard)
    return fits and all(holds(test, values) for test in edge.tests)


def _unfit(network: Network, state: _State, edges: Sequence[tuple[int, Edge]]) -> str:
    """Whether the edges go together, and whether a committed location has to be left first."""
    here = _locations(network, state.locations)
    committed = {place for place, at in enumerate(here) if at.urgency is Urgency.COMMITTED}
    if committed and not committed & {place for place, _ in edges}:
        return "a committed location has to be left first"
    (_, first), rest = edges[0], edges[1:]
    if first.synchronisation is None:
        return "" if not rest else "edges that do not communicate are taken at once"
    channel = first.synchronisation.channel
    if not first.synchronisation.sends:
        return f"nobody sends on {channel}"
    for _, edge in rest:
        heard = edge.synchronisation
        if heard is None or heard.sends or heard.channel != channel:
            return f"an edge does not receive on {channel}"
    broadcast = any(each.broadcast for each in network.channels if each.name == channel)
    if not broadcast:
        return "" if len(rest) == 1 else f"{channel} joins two"
    left_out = _left_out(network, state, channel, {place for place, _ in edges})
    return "" if left_out is None else f"{left_out[0].name} would have to receive {channel}"


def _left_out(
    network: Network, state: _State, channel: str, taking_part: AbstractSet[int]
) -> tuple[Automaton, Edge] | None:
    """Who is not taken along by a broadcast though it could receive it, and by which edge."""
    for place, automaton in enumerate(network.automata):
        for edge in automaton.edges:
            heard = edge.synchronisation
            could = heard is not None and not heard.sends and heard.channel == channel
            if place in taking_part or not could or edge.source != state.locations[place]:
                continue
            if _enabled(state.clocks, state.values, edge):
                return automaton, edge
    return None


# -- times ---------------------------------------------------------------------------------------------


Declined: TypeAlias = Mapping[int, Guard]
"""What else has to hold at a move, by its number, so that nobody hears it who has no part in it."""


def soonest(
    network: Network, solve: Callable[[Declined], Trace | None], target: Target | None
) -> Trace | None:
    """The earliest trace that `solve` can make, where broadcasts are heard by those who take part alone.

    Who could hear a broadcast must: at least one constraint of its guard is broken, and which one is tried.

    Parameters
    ----------
    solve
        The earliest times that satisfy the guards of the moves and the constraints it is given.

    Returns
    -------
    Trace or None
        One that has been executed.
    """

    def best(declined: Declined) -> Trace | None:
        found = solve(declined)
        if found is None or execute(network, found, target) is None:
            return found
        number, guard = _overheard(network, found)
        known = declined.get(number, ())
        others = [constraint.negated for constraint in guard]
        if not others or set(others) & set(known):
            return None
        ways = (best({**declined, number: (*known, each)}) for each in others)
        return min((way for way in ways if way is not None), key=rank, default=None)

    return best({})


def rank(trace: Trace) -> tuple[Fraction, bool]:
    """Sooner traces have less; a least time that is attained is better than the same one approached."""
    return trace.least, not trace.attained


def _overheard(network: Network, trace: Trace) -> tuple[int, Guard]:
    """The first move that somebody else would have to receive, and by what guard; ``()`` if there is none."""
    state = _started(network)
    now = Fraction(0)
    for number, (move, time) in enumerate(zip(trace.moves, trace.times, strict=True)):
        if _delayed(network, state, time - now):
            break
        if _moved(network, state, move):
            place, index = move[0]
            sent = network.automata[place].edges[index].synchronisation
            channel = "" if sent is None else sent.channel
            broadcast = any(each.broadcast and each.name == channel for each in network.channels)
            left_out = _left_out(network, state, channel, {place for place, _ in move}) if broadcast else None
            return number, () if left_out is None else left_out[1].guard
        now = time
    return 0, ()


def earliest(
    network: Network,
    moves: Sequence[Move],
    target: Target | None = None,
    *,
    epsilon: Fraction = Fraction(1, 1000),
) -> Trace | None:
    """The earliest times at which `moves` can be made one after the other; ``None`` if they cannot.

    By a linear program, for clocks that may stand still. :func:`mitlplan.search.timing.earliest` solves what
    needs none.

    Parameters
    ----------
    target
        What must hold at the end.
    epsilon
        How far above the infimum the last move may be made if the infimum is not attained, in seconds.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Automaton, Edge, Location
    >>> from mitlplan.automata.transducer import Constraint
    >>> late = (Constraint("z", Relation.AT_LEAST, Fraction(3, 2)),)
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1, guard=late),))
    >>> earliest(Network((walk,), clocks=("z",)), [((0, 0),)]).times
    (Fraction(3, 2),)
    """

    def solve(declined: Declined) -> Trace | None:
        program = _Program(network, moves, () if target is None else target.guard, declined)
        bottom = program.least(Fraction(0))
        if bottom is None:
            return None
        *times, least = bottom
        found = Trace(tuple(moves), tuple(times), attained=True, least=least, end=least)
        if execute(network, found, target) is None:
            return found
        margin = epsilon / (len(moves) + 1)
        last: Trace | None = None
        for _ in range(MOST_HALVINGS):
            later = program.least(margin)
            if later is not None:
                *times, end = later
                last = Trace(tuple(moves), tuple(times), attained=False, least=least, end=end)
                if execute(network, last, target) is None:
                    return last
            margin /= 2
        return last

    return soonest(network, solve, target)


_Row: TypeAlias = tuple[dict[int, int], Fraction, bool]
"""Coefficients of the delays, an upper bound on their sum, and whether it is strict."""


class _Program:
    """The linear program in the delays before each move, and before the end."""

    def __init__(self, network: Network, moves: Sequence[Move], goal: Guard, declined: Declined) -> None:
        self._count = len(moves) + 1
        self._scale = ticks_per_second(network)
        self._rows: list[_Row] = []
        self._still: set[int] = set()
        running: dict[str, list[int]] = {clock: [] for clock in network.clocks}
        for step, here in enumerate(located(network, moves)):
            self._invariants(here, running)
            if any(location.urgency is not Urgency.NORMAL for location in here):
                self._still.add(step)
            stopped = frozenset[str]().union(*(location.stopped for location in here))
            for clock, delays in running.items():
                if clock not in stopped:
                    delays.append(step)
            self._invariants(here, running)
            if step == len(moves):
                self._bounds(goal, running)
                break
            for place, index in moves[step]:
                self._bounds(network.automata[place].edges[index].guard, running)
            self._bounds(declined.get(step, ()), running)
            for place, index in moves[step]:
                for clock in network.automata[place].edges[index].resets:
                    running[clock] = []

    def _invariants(self, here: Sequence[Location], running: Mapping[str, Sequence[int]]) -> None:
        for location in here:
            self._bounds(location.invariant, running)

    def _bounds(self, guard: Guard, running: Mapping[str, Sequence[int]]) -> None:
        for each in guard:
            strict = each.relation in (Relation.LESS, Relation.GREATER)
            sign = 1 if each.relation in (Relation.LESS, Relation.AT_MOST) else -1
            self._rows.append((dict.fromkeys(running[each.clock], sign), sign * each.bound, strict))

    def least(self, margin: Fraction) -> tuple[Fraction, ...] | None:
        """The times of the moves and of the end, with the least end; strict bounds keep `margin` away."""
        import numpy as np
        from scipy import optimize
        from scipy.sparse import lil_matrix

        linprog: Any = optimize.linprog

        matrix = lil_matrix((len(self._rows), self._count))
        limits = np.zeros(len(self._rows))
        for number, (coefficients, bound, strict) in enumerate(self._rows):
            for step, sign in coefficients.items():
                matrix[number, step] = sign
            limits[number] = float((bound - margin if strict else bound) * self._scale)
        ranges = [(0, 0 if step in self._still else None) for step in range(self._count)]
        # The end counts most; among equals, every move is made as early as may be.
        weights = self._count**2 + np.arange(self._count, 0, -1.0)
        solved = linprog(weights, A_ub=matrix.tocsr(), b_ub=limits, bounds=ranges)
        if solved.status != 0:
            return None
        times: list[Fraction] = []
        now = Fraction(0)
        for ticks in solved.x:
            now += Fraction(max(float(ticks), 0.0)).limit_denominator(LARGEST_DENOMINATOR) / self._scale
            times.append(now)
        return tuple(times)
