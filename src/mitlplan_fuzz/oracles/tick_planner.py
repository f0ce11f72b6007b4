"""The least makespan of a small mission, by brute force over whole ticks.

Two planners that share nothing with the translation, the automata and the engine:

* :func:`least_by_progression` walks the ticks in order. A state is a cell, the time spent in it and the
  residual of the formula; finite plans end where the residual is paid, parking plans where staying for ever
  pays it, looping plans where one of the map's own cycles, repeated for ever, pays it.
* :func:`least_by_enumeration` lists every tick-timed plan in order of makespan and asks the judge.

Both know only plans whose times are whole ticks of ``1/resolution``. Without waiting and with fixed times
there are no others, except that a finite plan may end between two ticks: all those ends are alike, so
resolution 2 is exact there, an answer of n + 1/2 meaning an infimum n that is not attained. Elsewhere the
answer is an upper bound.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from mitlplan.logic.formula import Formula
from mitlplan.logic.signal import Segment, Signal
from mitlplan.workspace.workspace import Workspace
from mitlplan_fuzz.oracles.progression import (
    OPEN,
    POINT,
    Cycle,
    Progression,
    co_safe,
    holds_at_the_end,
    need_of,
)

Stays = tuple[tuple[int, int], ...]
"""Cells and their times of entry, in order."""


@dataclass(frozen=True)
class Least:
    """The least makespan found, with a plan that has it.

    ``stays`` gives each cell and when it is entered, in seconds; ``loop_start`` is the stay at which a
    looping plan goes on after the makespan. ``moves`` counts the moves made up to the makespan.
    """

    makespan: Fraction
    kind: str
    stays: tuple[tuple[int, Fraction], ...]
    loop_start: int | None = None

    @property
    def moves(self) -> int:
        """The moves up to the makespan, the one that closes a loop included."""
        return len(self.stays) - (self.kind != "looping")


@dataclass(frozen=True)
class NoneUpTo:
    """No tick-timed plan has a makespan up to `bound`; `exhausted` if none of any makespan can exist."""

    bound: Fraction
    exhausted: bool = False


Answer = Least | NoneUpTo


class TickMap:
    """The workspace with its times in whole ticks."""

    def __init__(self, workspace: Workspace, resolution: int) -> None:
        self.waiting = workspace.waiting
        self.labels = [workspace.holds(cell) for cell in range(workspace.cell_count)]
        self.moves: list[list[tuple[int, int, int | None]]] = []
        for cell in range(workspace.cell_count):
            self.moves.append([])
            for move in workspace.moves_from(cell):
                least = workspace.least_time(move) * resolution
                most = workspace.most_time(move)
                longest = None if most is None else most * resolution
                if least.denominator != 1 or (longest is not None and longest.denominator != 1):
                    raise ValueError("the tick planner needs times that are whole numbers of ticks")
                # Any positive stay is a tick at least.
                shortest = max(int(least), 1)
                self.moves[cell].append(
                    (int(workspace.target[move]), shortest, None if longest is None else int(longest))
                )

    def exits(self, cell: int, stayed: int) -> Iterator[int]:
        """The cells that may be entered after that many ticks in `cell`."""
        for target, least, longest in self.moves[cell]:
            if least <= stayed and (self.waiting or longest is None or stayed <= longest):
                yield target

    def may_stay(self, cell: int, stayed: int) -> bool:
        """Whether the robot may still be in `cell` after that many ticks, not leaving at this one."""
        if self.waiting:
            return True
        return any(longest is None or stayed < longest for _, _, longest in self.moves[cell])

    def settled(self, cell: int) -> int:
        """The number of ticks from which a longer stay changes nothing."""
        times = [1]
        for _, least, longest in self.moves[cell]:
            times.append(least)
            if longest is not None and not self.waiting:
                times.append(longest + 1)
        return max(times)


# --- By progression ----------------------------------------------------------------------------------------

State = tuple[int, int, int]
"""A cell, the ticks spent in it (0 on entry), and the number of the residual owed before this point."""


def least_by_progression(
    workspace: Workspace,
    start: int,
    formula: Formula,
    *,
    bound: int,
    until: str = "standard",
    horizon: str = "infinite",
    resolution: int = 1,
) -> Answer:
    """The least makespan up to `bound` seconds among the plans on ticks of ``1/resolution`` seconds."""
    return _TickSearch(workspace, start, formula, until, horizon, resolution).run(bound * resolution)


class _TickSearch:
    """A sweep over the ticks; of the plans of least makespan, one with the fewest moves."""

    def __init__(
        self,
        workspace: Workspace,
        start: int,
        formula: Formula,
        until: str,
        horizon: str,
        resolution: int,
    ) -> None:
        self.map = TickMap(workspace, resolution)
        self.resolution = resolution
        need = need_of(formula, until=until, scale=Fraction(resolution))
        self.loops = horizon == "infinite" and not co_safe(formula)
        self.ends_anywhere = horizon == "finite"
        self.progression = Progression(need)
        self.start: State = (start, 0, self.progression.initial)
        self.parents: dict[State, State | None] = {self.start: None}
        # Where a cycle may begin: states on entry, by the tick of their first visit.
        self.entries: list[list[tuple[State, int]]] = []
        self.cycles = [_Cycles(self.map, cell) for cell in range(len(self.map.labels))]

    def run(self, last_tick: int) -> Answer:
        layer = {self.start: 0}
        for tick in range(last_tick + 1):
            found = self._ending(layer, tick)
            if self.loops:
                self.entries.append([item for item in layer.items() if item[0][1] == 0])
                found = min(
                    (plan for plan in (found, self._parking(tick), self._looping(tick)) if plan),
                    key=lambda plan: plan.moves,
                    default=None,
                )
            if found:
                return found
            layer = self._advance(layer)
        bound = Fraction(last_tick, self.resolution)
        return NoneUpTo(bound, exhausted=not layer and not self.loops)

    def _advance(self, layer: dict[State, int]) -> dict[State, int]:
        """The new states a tick later, with the fewest moves that lead to each."""
        later: dict[State, int] = {}
        for state, moves in sorted(layer.items(), key=lambda item: item[1]):
            cell, stayed, owed = state
            label = self.map.labels[cell]
            owed = self.progression.step(self.progression.step(owed, label, POINT), label, OPEN)
            if not owed:
                continue
            stayed += 1
            successors = [((target, 0, owed), moves + 1) for target in self.map.exits(cell, stayed)]
            if self.map.may_stay(cell, stayed):
                successors.append(((cell, min(stayed, self.map.settled(cell)), owed), moves))
            for successor, cost in successors:
                if successor not in self.parents or cost < later.get(successor, cost):
                    self.parents[successor] = state
                    later[successor] = cost
        return later

    def _ending(self, layer: dict[State, int], tick: int) -> Least | None:
        """A finite plan that ends at this very point."""
        for state in sorted(layer, key=lambda state: layer[state]):
            cell, _, owed = state
            after = self.progression.step(owed, self.map.labels[cell], POINT)
            if after == 1 or (self.ends_anywhere and holds_at_the_end(self.progression.residual(after))):
                return self._plan("finite", tick, self._stays(state, tick))
        return None

    def _parking(self, tick: int) -> Least | None:
        if not self.map.waiting:
            return None
        for state, _ in sorted(self.entries[tick], key=lambda item: item[1]):
            cell, _, owed = state
            if Cycle([self.map.labels[cell]]).pays(self.progression, owed):
                return self._plan("parking", tick, self._stays(state, tick))
        return None

    def _looping(self, tick: int) -> Least | None:
        best: Least | None = None
        for entered in range(tick):
            for state, _ in self.entries[entered]:
                cell, _, owed = state
                for cycle, stays in self.cycles[cell].of_length(tick - entered):
                    if cycle.pays(self.progression, owed):
                        prefix = self._stays(state, entered)
                        around = tuple((place, entered + since) for place, since in stays)
                        plan = self._plan("looping", tick, prefix[:-1] + around, len(prefix) - 1)
                        if best is None or plan.moves < best.moves:
                            best = plan
        return best

    def _stays(self, state: State, tick: int) -> Stays:
        backwards: list[tuple[int, int]] = []
        at: State | None = state
        while at is not None:
            if at[1] == 0:
                backwards.append((at[0], tick))
            at, tick = self.parents[at], tick - 1
        return tuple(reversed(backwards))

    def _plan(self, kind: str, tick: int, stays: Stays, loop_start: int | None = None) -> Least:
        seconds = tuple((cell, Fraction(entered, self.resolution)) for cell, entered in stays)
        return Least(Fraction(tick, self.resolution), kind, seconds, loop_start)


class _Cycles:
    """The ways round from a cell to itself, by length: one for each sequence of labels."""

    def __init__(self, tick_map: TickMap, home: int) -> None:
        self._map = tick_map
        self._home = home
        # By length: for each cell now entered, the label words so far and their stays.
        self._walks: list[dict[int, dict[tuple[frozenset[str], ...], Stays]]] = [{home: {(): ()}}]
        self._found: dict[int, list[tuple[Cycle, Stays]]] = {}

    def of_length(self, ticks: int) -> list[tuple[Cycle, Stays]]:
        if ticks not in self._found:
            while len(self._walks) <= ticks:
                self._walks.append(self._extend(len(self._walks)))
            words = self._walks[ticks].get(self._home, {})
            self._found[ticks] = [(Cycle(word), stays) for word, stays in words.items()]
        return self._found[ticks]

    def _extend(self, ticks: int) -> dict[int, dict[tuple[frozenset[str], ...], Stays]]:
        reached: dict[int, dict[tuple[frozenset[str], ...], Stays]] = {}
        for entered in range(ticks):
            for cell, walks in self._walks[entered].items():
                spent = ticks - entered
                stretch = (self._map.labels[cell],) * spent
                for target in self._map.exits(cell, spent):
                    words = reached.setdefault(target, {})
                    for word, stays in walks.items():
                        longer = word + stretch
                        if longer not in words or len(words[longer]) > len(stays) + 1:
                            words[longer] = (*stays, (cell, entered))
        return reached


# --- By enumeration ----------------------------------------------------------------------------------------


def tick_plans(
    workspace: Workspace, start: int, *, bound: int, resolution: int, endless: bool
) -> Iterator[Least]:
    """Every plan on ticks of ``1/resolution`` seconds up to `bound` seconds, in order of makespan.

    Finite plans always; parking and looping plans too if `endless`.
    """
    tick_map = TickMap(workspace, resolution)
    # Plans as (tick, number, stays, left): left tells whether the robot enters the last cell at `tick`.
    queue: list[tuple[int, Stays]] = [(0, ((start, 0),))]
    while queue:
        tick, stays = heapq.heappop(queue)
        cell, entered = stays[-1]

        def plan(kind: str, stays: Stays, loop_start: int | None = None, tick: int = tick) -> Least:
            seconds = tuple((place, Fraction(since, resolution)) for place, since in stays)
            return Least(Fraction(tick, resolution), kind, seconds, loop_start)

        yield plan("finite", stays)
        if endless and entered == tick:
            if workspace.waiting:
                yield plan("parking", stays)
            for index, (earlier, _) in enumerate(stays[:-1]):
                if earlier == cell:
                    yield plan("looping", stays[:-1], index)
        if tick == bound * resolution:
            continue
        stayed = tick + 1 - entered
        for target in tick_map.exits(cell, stayed):
            heapq.heappush(queue, (tick + 1, (*stays, (target, tick + 1))))
        if tick_map.may_stay(cell, stayed):
            heapq.heappush(queue, (tick + 1, stays))


def signal_of(workspace: Workspace, plan: Least) -> Signal:
    """What the judge is shown of a plan."""
    segments = tuple(Segment(entered, workspace.holds(cell)) for cell, entered in plan.stays)
    match plan.kind:
        case "finite":
            return Signal(segments, plan.makespan)
        case "parking":
            return Signal(segments, plan.makespan + 1, repeat_from=plan.makespan)
        case _:
            assert plan.loop_start is not None
            return Signal(segments, plan.makespan, repeat_from=plan.stays[plan.loop_start][1])


def least_by_enumeration(
    workspace: Workspace,
    start: int,
    formula: Formula,
    *,
    bound: int,
    until: Literal["standard", "closed"] = "standard",
    horizon: Literal["infinite", "finite"] = "infinite",
    resolution: int = 1,
) -> Answer:
    """As :func:`least_by_progression`, the plans listed one by one and each shown to the judge."""
    from mitlplan.logic.semantics import satisfies

    endless = horizon == "infinite" and not co_safe(formula)
    for plan in tick_plans(workspace, start, bound=bound, resolution=resolution, endless=endless):
        if satisfies(formula, signal_of(workspace, plan), until=until, horizon=horizon):
            return plan
    return NoneUpTo(Fraction(bound))
