"""Robots without a choice: one walk, at exact times, so that what they show is one signal.

On such a map the network of a formula has a run exactly if the formula holds of that signal, and the judge
can say whether it does: nothing but the translation and the search is left to be wrong.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from mitlplan.automata.transducer import NEVER, Network
from mitlplan.compose import Construction, compose
from mitlplan.logic.core import Core
from mitlplan.logic.formula import Formula
from mitlplan.logic.normalize import normalize
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.search.fastest import Exhausted, Found, Limits, Stopped, fastest_run
from mitlplan.search.lasso import lassos
from mitlplan.search.tables import Tables, tabulate
from mitlplan.workspace.graph import Move, graph
from mitlplan.workspace.workspace import Workspace

NAMES = ("p", "q", "r")
STAYS = tuple(map(Fraction, ("1", "1", "1", "1/2", "3/2", "2")))
FINEST = Fraction(1, 2)
"""Every change of a signal and every bound of a formula is a multiple of this."""

MEMORY = 6
"""Megabytes for one search: a limit that, unlike one of time, is the same on every machine."""

FARTHEST = 8
"""Up to when, in seconds, an end is looked for that the engine does not find."""

UntilKind = Literal["standard", "closed"]
Horizon = Literal["infinite", "finite"]


class TooManyStatesError(Exception):
    """The search was not completed: nothing can be compared."""


@dataclass(frozen=True)
class Forced:
    """The stays of a robot, each a label and a time in seconds; after the last it goes on at stay `back`."""

    stays: tuple[tuple[frozenset[str], Fraction], ...]
    back: int

    def workspace(self, *, comes_back: bool = True) -> Workspace:
        """A map on which nothing else can be done; unless it comes back, the last cell has no way out."""
        cells = {f"c{index}": sorted(label) for index, (label, _) in enumerate(self.stays)}
        follows = [*range(1, len(self.stays)), *([self.back] if comes_back else [])]
        moves = [Move(f"c{index}", f"c{after}", self.stays[index][1]) for index, after in enumerate(follows)]
        return graph(cells, moves, waiting=False)

    def signal(self, back: int | None = None) -> Signal:
        """What the robot shows for ever; with `back` as the stay at which it goes on instead."""
        now = Fraction(0)
        segments = []
        for label, duration in self.stays:
            segments.append(Segment(now, label))
            now += duration
        return Signal(tuple(segments), now, segments[self.back if back is None else back].start)

    def up_to(self, end: Fraction) -> Signal:
        """What the robot shows up to a time."""
        now, place = Fraction(0), 0
        segments = []
        while now <= end:
            label, duration = self.stays[place]
            segments.append(Segment(now, label))
            now += duration
            place = place + 1 if place + 1 < len(self.stays) else self.back
        return Signal(tuple(segments), end)

    def __str__(self) -> str:
        shown = ", ".join(f"{''.join(sorted(label)) or '-'} for {time}" for label, time in self.stays)
        return f"[{shown}; back to {self.back}]"


def random_forced(stream: random.Random) -> Forced:
    """A robot with two to six stays."""
    stays = tuple(
        (frozenset(name for name in NAMES if stream.random() < 0.5), stream.choice(STAYS))
        for _ in range(stream.randrange(2, 7))
    )
    return Forced(stays, stream.randrange(len(stays) - 1))


def wrong_for_ever(
    formula: Formula,
    robot: Forced,
    until: UntilKind = "standard",
    *,
    construction: Construction = "compact",
) -> str | None:
    """Whether the network has an infinite run exactly if the judge accepts the infinite signal."""
    core = normalize(formula, until, horizon="infinite")
    network = compose(robot.workspace(), (0,), core, construction=construction)
    found = lassos(tabulate(network, objective=False), Limits(megabytes=MEMORY).begin())
    if isinstance(found, Stopped):
        raise TooManyStatesError
    engine, judge = not isinstance(found, Exhausted), satisfies(formula, robot.signal(), until=until)
    return None if engine == judge else f"for ever: the engine says {engine}, the judge {judge}"


def wrong_parked(
    formula: Formula,
    robot: Forced,
    until: UntilKind = "standard",
    *,
    construction: Construction = "compact",
) -> str | None:
    """Whether the robot may stay in its last cell exactly if the judge lets it."""
    core = normalize(formula, until, horizon="infinite")
    last = len(robot.stays) - 1
    network = compose(robot.workspace(comes_back=False), (0,), core, construction=construction)
    tables = tabulate(_with_rest(network, last))
    arrays: dict[str, Any] = dict(tables.arrays)
    arrays["parkable"] = (np.arange(len(arrays["parkable"])) == last).astype(np.uint8)
    result = _fastest(Tables(arrays, tables.scale, tables.acceptance, tables.cells), endings=False)
    engine, judge = result is not None, satisfies(formula, robot.signal(back=last), until=until)
    return None if engine == judge else f"parked: the engine says {engine}, the judge {judge}"


def _with_rest(network: Network, cell: int) -> Network:
    invariant = network.map.invariant.copy()
    invariant[cell] = NEVER
    return replace(network, map=replace(network.map, invariant=invariant, may_park=True))


def wrong_end(
    formula: Formula,
    robot: Forced,
    until: UntilKind = "standard",
    horizon: Horizon = "infinite",
    *,
    construction: Construction = "compact",
) -> str | None:
    """Whether the first end the engine finds is the first after which the judge knows that the formula holds.

    What is known changes at multiples of half a second only: quarters show every instant and every stretch.
    """

    def known(end: Fraction) -> bool:
        return satisfies(formula, robot.up_to(end), until=until, horizon=horizon)

    core: Core = normalize(formula, until, horizon=horizon)
    network = compose(robot.workspace(), (0,), core, horizon=horizon, construction=construction)
    found = _fastest(tabulate(network), parkings=False)
    ends = (k * FINEST / 2 for k in range(4 * FARTHEST + 1))
    first = next((end for end in ends if known(end)), None)
    if found is None:
        return None if first is None else f"the engine finds no end, the judge {first}"
    if found.time > FARTHEST:
        return None if first is None else f"the engine ends at {found.time}, the judge at {first}"
    expected = found.time if found.attained else found.time + FINEST / 2
    return None if first == expected else f"the engine ends at {expected}, the judge at {first}"


def _fastest(tables: Tables, *, endings: bool = True, parkings: bool = True) -> Found | None:
    limits = Limits(megabytes=MEMORY).begin()
    match fastest_run(tables, limits, endings=endings, parkings=parkings):
        case Found() as found:
            return found
        case Exhausted():
            return None
        case Stopped():
            raise TooManyStatesError
