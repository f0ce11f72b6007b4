"""Whether a network of timed automata reaches a target, and how soon: no other tool needed.

A first search, breadth first and without the time that has passed among the clocks, finds whether there is
any way at all; a proof that there is none is complete here. Only then a second one, ordered by that time,
looks for the fastest (``native/reachability.hpp``). What it finds is a sequence of moves: their exact times
are computed, and the trace is executed, by code that knows nothing of zones. Where clocks are read that have
stood still the search over-approximates, as UPPAAL's does (Cassez and Larsen 2000): a way without times is
dropped and the next one looked at, and if none is left nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias, Union

from mitlplan import _core
from mitlplan.automata.timed_automaton import Network, Query, Target
from mitlplan.automata.trace import Move, Trace, rank
from mitlplan.errors import OutOfTime
from mitlplan.search.fastest import (
    EXHAUSTED,
    FOUND,
    MEGABYTE,
    OUT_OF_MEMORY,
    Limits,
    Progress,
    Stopped,
    run,
)
from mitlplan.search.systems import SystemTables, tabulate_system
from mitlplan.search.timing import earliest


@dataclass(frozen=True, slots=True)
class Effort:
    """What a search has done.

    Parameters
    ----------
    visited
        States whose moves were tried.
    stored
        States that lie in no other.
    transitions
        Moves tried.
    bytes
        The memory that the search used for its states.
    """

    visited: int = 0
    stored: int = 0
    transitions: int = 0
    bytes: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Reached:
    """A trace to a target.

    Parameters
    ----------
    trace
        Checked by executing it; times in seconds.
    target
        The one that holds at its end.
    bound
        No trace to any target ends earlier, in seconds: `trace` is proved fastest where this is its `least`.
    """

    trace: Trace
    target: Target
    bound: Fraction
    effort: Effort


@dataclass(frozen=True, slots=True)
class Unreachable:
    """A proof: every state was looked at."""

    effort: Effort


@dataclass(frozen=True, slots=True)
class Unknown:
    """Every way found needs times that stopped clocks do not allow; there may be others."""

    spurious: int
    effort: Effort


Reachable: TypeAlias = Union[Reached, Unreachable, Unknown, Stopped]


def reach(
    network: Network,
    query: Query,
    limits: Limits | None = None,
    *,
    fastest: bool = True,
    epsilon: Fraction = Fraction(1, 1000),
) -> Reachable:
    """The fastest trace of `network` to a target of `query`, or a proof that there is none.

    Parameters
    ----------
    query
        The targets; any of them will do.
    limits
        None by default. If they stop the search after some trace was found, that is the answer, with what
        is then proved.
    fastest
        Whether to go on from some trace to the fastest.
    epsilon
        How near to come to a least time that no trace attains, in seconds.

    Raises
    ------
    OverflowError
        If a time needs more ticks than 64-bit arithmetic holds safely.

    Examples
    --------
    >>> from mitlplan.automata.timed_automaton import Automaton, Edge, Location
    >>> from mitlplan.automata.transducer import Constraint, Relation
    >>> late = (Constraint("z", Relation.AT_LEAST, Fraction(3, 2)),)
    >>> walk = Automaton("robot", (Location("here"), Location("there")), (Edge(0, 1, guard=late),))
    >>> found = reach(Network((walk,), clocks=("z",)), Query((Target({"robot": "there"}),)))
    >>> found.trace.end
    Fraction(3, 2)
    """
    begun = (Limits() if limits is None else limits).begin()
    any_way = _Ways(network, query, begun, epsilon, objective=False)
    found = any_way.first()
    if not fastest or not isinstance(found, Reached) or found.trace.least == 0:
        return found
    try:
        better = _Ways(network, query, begun, epsilon, objective=True).best()
    except OutOfTime:
        better = Stopped(begun.out_of_time, None, 0)
    match better:
        case Unknown():
            # Ways may be lost to the second search, which comes across others, but not this one.
            return found
        case Stopped(_, bound):
            least = found.trace.least
            proved = Fraction(0) if bound is None else min(bound, least)
            return Reached(found.trace, found.target, proved, found.effort)
        case _:
            return better


class _Ways:
    """One native search, and the ways to targets that it comes across."""

    def __init__(
        self, network: Network, query: Query, limits: Limits, epsilon: Fraction, *, objective: bool
    ) -> None:
        self.network = network
        self.limits = limits
        self.epsilon = epsilon
        self.tables: SystemTables = tabulate_system(network, query, objective=objective)
        memory = 0 if limits.megabytes is None else limits.megabytes * MEGABYTE
        self.search = _core.Reachability(self.tables.arrays, memory=memory)
        self.spurious = 0

    def first(self) -> Reachable:
        """Any way that has times."""
        while (end := self.next_goal()) is None:
            found = self.way()
            if found is not None:
                return found
        return end

    def best(self) -> Reachable:
        """The way that ends first."""
        best: Reached | None = None
        while (end := self.next_goal()) is None:
            if best is not None and self.bound() >= best.trace.least:
                return best
            found = self.way()
            if found is None:
                continue
            # A least time that is attained is better than the same one approached.
            if best is None or rank(found.trace) < rank(best.trace):
                best = found
            if best.trace.least <= self.bound():
                return best
        return end if best is None else self.proved(best, end)

    def proved(self, best: Reached, end: Reachable) -> Reached:
        """The best way known when the search ended, with what is known to bound it."""
        bound = best.trace.least
        if isinstance(end, Stopped) and end.lower_bound is not None:
            bound = min(bound, end.lower_bound)
        return Reached(best.trace, best.target, bound, self.effort())

    def bound(self) -> Fraction:
        """The time of the goal at hand; of a way without stopwatches the least there is."""
        return Fraction(self.search.goal[0], self.tables.scale)

    def next_goal(self) -> Reachable | None:
        """Search on to the next goal, or say why there is none."""
        while True:
            status = run(self.search, self.limits)
            if status == FOUND:
                return None
            if status == EXHAUSTED:
                return Unknown(self.spurious, self.effort()) if self.spurious else Unreachable(self.effort())
            stored = self.search.stored
            bound = Fraction(self.search.lower_bound, self.tables.scale)
            if status == OUT_OF_MEMORY:
                return Stopped(f"{self.limits.out_of_memory} after {stored} states", bound, stored)
            if self.limits.over():
                return Stopped(f"{self.limits.out_of_time} after {stored} states", bound, stored)
            if self.limits.progress is not None:
                self.limits.progress(Progress(stored, bound, self.limits.elapsed))

    def way(self) -> Reached | None:
        """The way to the goal at hand with its times, or ``None`` if it has none."""
        target = self.tables.targets[self.search.goal[2]]
        trace = earliest(self.network, list(self.moves()), target, epsilon=self.epsilon)
        if trace is not None:
            return Reached(trace, target, min(self.bound(), trace.least), self.effort())
        if not self.search.approximated:
            raise RuntimeError("the search found moves that cannot be timed")
        self.spurious += 1
        return None

    def moves(self) -> Iterator[Move]:
        """The moves up to the goal at hand."""
        starts, parts = self.search.path()
        pairs = parts.reshape(-1, 2).tolist()
        for begin, end in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
            yield tuple((place, self.tables.edges[edge][1]) for place, edge in pairs[begin:end])

    def effort(self) -> Effort:
        """What has been done so far."""
        search = self.search
        return Effort(search.visited, search.stored, search.transitions, search.bytes)
