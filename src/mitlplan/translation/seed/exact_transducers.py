"""The paper's transducers made right: two-sided, exact, and with few clocks.

Each reads right-continuous signals and writes the truth of its operator and nothing else: on every input
there is a run whose output is the truth, and none with another output. What differs from the published ones:
nothing stops the clocks; a clock is constrained only while the edge it measures is outstanding; several
Buechi sets are kept apart. A run changes location at most once at an instant, and everything that changes at
an instant changes in one edge; clocks that only ensured this (z>0) are gone.
F_[a,b] p at t is F_[0,b-a] p at t+a. The inner one has four locations and a single clock, because a stretch
without p longer than b-a is false first and true for the last b-a exactly (:func:`eventually_within`). The
outer one is a guess, replayed a later (:func:`delay`): a true stretch of the inner one is longer than b-a, so
at most k = ceil(a/(b-a)) rising and as many falling edges are outstanding.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from math import ceil

from mitlplan.automata.iota import Iota, IotaEdge, IotaLocation, Letter
from mitlplan.automata.timed_automaton import exactly
from mitlplan.automata.transducer import Constraint, Guard, Relation


def _letters(text: str) -> frozenset[Letter]:
    return frozenset(tuple(bit == "1" for bit in letter) for letter in text.split())


def negation() -> Iota:
    """``!p``."""
    locations = (IotaLocation("p", _letters("1"), False), IotaLocation("!p", _letters("0"), True))
    return Iota(("p",), locations, (IotaEdge(0, 1), IotaEdge(1, 0)), frozenset({0, 1}))


def conjunction() -> Iota:
    """``p & q``."""
    locations = (IotaLocation("and", _letters("11"), True), IotaLocation("!and", _letters("10 01 00"), False))
    return Iota(("p", "q"), locations, (IotaEdge(0, 1), IotaEdge(1, 0)), frozenset({0, 1}))


def until() -> Iota:
    """``p U q``, the standard one: p until q, not necessarily at the instant of q.

    Without q a run promises that q comes while p lasts (``p!q``, not for ever: the Buechi set), or that p
    fails first or q never comes (``!(p!q)``). The closed until is ``p U (p & q)``.
    """
    locations = (
        IotaLocation("!p!q", _letters("00"), False),
        IotaLocation("!(p!q)", _letters("10"), False),
        IotaLocation("p!q", _letters("10"), True),
        IotaLocation("q", _letters("01 11"), True),
    )
    pairs = [(0, 1), (0, 2), (0, 3), (1, 0), (2, 3), (3, 0), (3, 1), (3, 2)]
    edges = tuple(IotaEdge(source, target) for source, target in pairs)
    return Iota(("p", "q"), locations, edges, frozenset(range(4)), buechi=(frozenset({0, 1, 3}),))


def eventually_within(most: Fraction, clock: str) -> Iota:
    """``F_[0,most] p``, for most > 0, with a single clock.

    Where p is false the run says whether it will come in time (``soon``). If not, it is far off until the
    last `most` seconds before it comes (``due``): that stretch ends with p, exactly then.
    """
    in_time = (Constraint(clock, Relation.AT_MOST, most),)
    locations = (
        IotaLocation("now", _letters("1"), True),
        IotaLocation("soon", _letters("0"), True, in_time),
        IotaLocation("far", _letters("0"), False),
        IotaLocation("due", _letters("0"), True, in_time),
    )
    started = frozenset({clock})
    edges = (
        IotaEdge(0, 1, resets=started),
        IotaEdge(0, 2),
        IotaEdge(1, 0, in_time),
        IotaEdge(2, 3, resets=started),
        IotaEdge(3, 0, exactly(clock, most)),
    )
    return Iota(("p",), locations, edges, frozenset({0, 1, 2}), (clock,))


def outstanding_pairs(seconds: Fraction, spacing: Fraction) -> int:
    """How many rising edges, and falling ones, of a guess may wait for their replay at once."""
    return ceil(seconds / spacing)


def delay(seconds: Fraction, spacing: Fraction, start: str, clocks: tuple[str, ...]) -> Iota:
    """``F_[seconds,seconds] q`` for a signal q whose true stretches are longer than `spacing`.

    The guess of q is written at once and compared with q `seconds` later. Clock number i measures the age of
    an outstanding edge: a rising one if i is even, a falling one if i is odd, cyclically.

    Parameters
    ----------
    start
        The clock that measures the first `seconds`, in which q itself is of no interest.
    clocks
        Two for each of :func:`outstanding_pairs`.
    """
    automaton = _Delay(seconds, start, clocks)
    if len(clocks) != 2 * outstanding_pairs(seconds, spacing):
        raise ValueError(f"a delay of {seconds} needs {2 * outstanding_pairs(seconds, spacing)} clocks")
    return automaton.build()


class _Delay:
    """A location is (before, head, count): whether the start is over, the oldest edge, how many wait."""

    def __init__(self, seconds: Fraction, start: str, clocks: tuple[str, ...]) -> None:
        self._seconds = seconds
        self._start = start
        self._clocks = clocks
        self._states = [
            (before, head, waiting)
            for before, head in [(True, 0), (True, 1), *((False, head) for head in range(len(clocks)))]
            for waiting in range(len(clocks) + 1)
        ]
        self._number = {state: index for index, state in enumerate(self._states)}

    def build(self) -> Iota:
        started = frozenset(self._number[state] for state in self._states if state[0] and state[2] == 0)
        return Iota(
            inputs=("q",),
            locations=tuple(self._location(*state) for state in self._states),
            edges=tuple(self._edges()),
            initial=started,
            clocks=(self._start, *self._clocks),
        )

    def _location(self, before: bool, head: int, waiting: int) -> IotaLocation:
        value = head % 2 == 1
        guess = (head + waiting) % 2 == 1
        kind = "start" if before else "replay"
        oldest = self._start if before else self._clocks[head] if waiting else None
        invariant = () if oldest is None else (Constraint(oldest, Relation.AT_MOST, self._seconds),)
        reads = _letters("0 1") if before else frozenset({(value,)})
        return IotaLocation(f"{kind}{head}.{waiting}", reads, guess, invariant)

    def _edges(self) -> Iterator[IotaEdge]:
        """The guess may change, the oldest edge may be replayed (or the start end), or both at once."""
        size = len(self._clocks)
        for before, head, waiting in self._states:
            source = self._number[before, head, waiting]
            for replays, guesses in product((False, True), repeat=2):
                if not (replays or guesses) or (replays and not before and waiting == 0):
                    continue
                left = waiting - (replays and not before)
                if left + guesses > size:
                    continue
                following = (head + (replays and not before)) % size
                resets = frozenset({self._clocks[(following + left) % size]}) if guesses else frozenset[str]()
                target = self._number[before and not replays, following, left + guesses]
                yield IotaEdge(source, target, self._replayed(before, head) if replays else (), resets)

    def _replayed(self, before: bool, head: int) -> Guard:
        return exactly(self._start if before else self._clocks[head], self._seconds)
