"""The earliest times at which the moves of a trace can be made, exactly.

Where no clock is read that has stood still, each guard and invariant is a difference constraint between two
moves: the one that reads the clock and the one that reset it. The native half solves them by longest paths,
in ticks, with infinitesimals for strict bounds. Where a stopwatch is read its constraint is a sum of delays,
and the linear program of :mod:`mitlplan.automata.trace` takes over. Either way the result is executed step
by step before it is believed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from mitlplan import _core
from mitlplan.automata import trace
from mitlplan.automata.timed_automaton import Location, Network, Target, Urgency, ticks_per_second
from mitlplan.automata.trace import Declined, Move, Trace, located, soonest
from mitlplan.automata.transducer import Guard, Relation
from mitlplan.search.schedule import Difference, columns, infinitesimals_a_tick
from mitlplan.search.tables import ticks_of

ANYWHERE = Target()
"""No condition on where a trace ends."""


class _StopwatchRead(Exception):  # noqa: N818  (no error: the other way of solving is needed)
    """A clock is read that has stood still since its reset."""


def earliest(
    network: Network,
    moves: Sequence[Move],
    target: Target = ANYWHERE,
    *,
    epsilon: Fraction = Fraction(1, 1000),
) -> Trace | None:
    """The earliest times at which `moves` can be made and `target` then holds; ``None`` if there are none.

    Parameters
    ----------
    epsilon
        How far above the infimum the end may be if the infimum is not attained, in seconds.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Automaton, Edge, Location
    >>> from mitlplan.automata.transducer import Constraint
    >>> late = (Constraint("z", Relation.GREATER, Fraction(3, 2)),)
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1, guard=late),))
    >>> found = earliest(Network((walk,), clocks=("z",)), [((0, 0),)])
    >>> found.times, found.least, found.attained
    ((Fraction(1501, 1000),), Fraction(3, 2), False)
    """
    scale = ticks_per_second(network) * _denominator(target.guard)

    def solve(declined: Declined) -> Trace | None:
        constraints = list(dict.fromkeys(_differences(network, moves, target.guard, declined, scale)))
        try:
            times = _core.earliest_times(len(moves) + 2, *columns(constraints))
        except ValueError:
            return None
        parts = infinitesimals_a_tick(times, constraints, epsilon * scale)
        *made, end = [Fraction(ticks * parts + small, scale * parts) for ticks, small in times[1:]]
        least = Fraction(times[-1][0], scale)
        return Trace(tuple(moves), tuple(made), attained=times[-1][1] == 0, least=least, end=end)

    try:
        return soonest(network, solve, target)
    except _StopwatchRead:
        return trace.earliest(network, moves, target, epsilon=epsilon)


def _denominator(guard: Guard) -> int:
    scale = 1
    for constraint in guard:
        scale *= constraint.bound.denominator
    return scale


def _differences(
    network: Network, moves: Sequence[Move], goal: Guard, declined: Declined, scale: int
) -> Iterator[Difference]:
    """The constraints on the times of the moves; 0 is the start, and one behind the last move the end."""
    reset_at = dict.fromkeys(network.clocks, 0)
    stood_still: set[str] = set()
    last = len(moves) + 1

    def read(guard: Guard, step: int) -> Iterator[Difference]:
        for each in guard:
            if each.clock in stood_still:
                raise _StopwatchRead
            value, origin = ticks_of(each.bound, scale), reset_at[each.clock]
            strict = each.relation in (Relation.LESS, Relation.GREATER)
            if each.relation in (Relation.LESS, Relation.AT_MOST):
                yield Difference(step, origin, -value, strict)
            else:
                yield Difference(origin, step, value, strict)

    def invariants(here: Sequence[Location], step: int) -> Iterator[Difference]:
        for location in here:
            yield from read(location.invariant, step)

    for step, here in enumerate(located(network, moves)):
        yield from invariants(here, step)
        yield Difference(step, step + 1, 0, strict=False)
        if any(location.urgency is not Urgency.NORMAL for location in here):
            yield Difference(step + 1, step, 0, strict=False)
        else:
            stood_still |= frozenset[str]().union(*(location.stopped for location in here))
        yield from invariants(here, step + 1)
        if step + 1 == last:
            yield from read(goal, last)
            return
        edges = [network.automata[place].edges[index] for place, index in moves[step]]
        for edge in edges:
            yield from read(edge.guard, step + 1)
        yield from read(declined.get(step, ()), step + 1)
        for edge in edges:
            for clock in edge.resets:
                reset_at[clock] = step + 1
                stood_still.discard(clock)
