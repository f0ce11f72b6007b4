"""What an IOTA makes of a signal, by trying every run on a grid of instants.

Signals are right-continuous and change at multiples of 1/n; a signal is a list of letters, one for each cell
of the grid, that goes on at `repeat` after its end. A configuration is a cell, a location and the ages of the
clocks (those that are past every constant count as one). Runs change location at the border of two cells
only, which loses nothing as long as the constants are on the grid and the outputs change on it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from mitlplan.automata.iota import Iota, Letter
from mitlplan.automata.transducer import Guard, Relation

Ages = tuple[int, ...]
Configuration = tuple[int, int, Ages]


@dataclass(frozen=True)
class Transduction:
    """The configurations on some accepting run, by cell."""

    outputs: tuple[frozenset[bool | None], ...]

    @property
    def accepted(self) -> bool:
        return bool(self.outputs[0])


def transduce(iota: Iota, letters: list[Letter], repeat: int, resolution: int) -> Transduction:
    """Every output value that occurs in each cell on a run that never ends and visits all Buechi sets."""
    reached, successors = _explore(_Grid(iota, letters, repeat, resolution))
    live = _live(reached, successors, iota)
    outputs: list[set[bool | None]] = [set() for _ in letters]
    for cell, location, _ in live:
        outputs[cell].add(iota.locations[location].writes)
    return Transduction(tuple(frozenset(values) for values in outputs))


class _Grid:
    def __init__(self, iota: Iota, letters: list[Letter], repeat: int, resolution: int) -> None:
        self.iota = iota
        self.letters = letters
        self.repeat = repeat
        self.resolution = resolution
        guards = [location.invariant for location in iota.locations] + [edge.guard for edge in iota.edges]
        bounds = [constraint.bound for guard in guards for constraint in guard]
        self.oldest = int(max(bounds, default=Fraction(0)) * resolution) + 1
        self.clock = {name: index for index, name in enumerate(iota.clocks)}

    def reads(self, cell: int, location: int) -> bool:
        return self.letters[cell] in self.iota.locations[location].reads

    def satisfied(self, guard: Guard, ages: Ages) -> bool:
        return all(self._holds(ages[self.clock[each.clock]], each.relation, each.bound) for each in guard)

    def _holds(self, age: int, relation: Relation, bound: Fraction) -> bool:
        other = bound * self.resolution
        match relation:
            case Relation.LESS:
                return age < other
            case Relation.AT_MOST:
                return age <= other
            case Relation.AT_LEAST:
                return age >= other
            case Relation.GREATER:
                return age > other

    def older(self, ages: Ages) -> Ages:
        return tuple(min(age + 1, self.oldest) for age in ages)

    def begin(self) -> Iterable[Configuration]:
        ages = (0,) * len(self.iota.clocks)
        return [(0, location, ages) for location in self.iota.initial if self.reads(0, location)]

    def follow(self, configuration: Configuration) -> Iterable[Configuration]:
        cell, location, ages = configuration
        older = self.older(ages)
        if not self.satisfied(self.iota.locations[location].invariant, older):
            return
        following = cell + 1 if cell + 1 < len(self.letters) else self.repeat
        if self.reads(following, location):
            yield following, location, older
        for edge in self.iota.edges:
            if edge.source != location or not self.satisfied(edge.guard, older):
                continue
            if self.reads(following, edge.target):
                after = tuple(0 if name in edge.resets else older[at] for name, at in self.clock.items())
                yield following, edge.target, after


def _explore(grid: _Grid) -> tuple[set[Configuration], dict[Configuration, list[Configuration]]]:
    waiting = list(grid.begin())
    reached = set(waiting)
    successors: dict[Configuration, list[Configuration]] = {}
    while waiting:
        configuration = waiting.pop()
        successors[configuration] = list(grid.follow(configuration))
        fresh = [each for each in successors[configuration] if each not in reached]
        reached.update(fresh)
        waiting.extend(fresh)
    return reached, successors


def _live(
    reached: set[Configuration], successors: dict[Configuration, list[Configuration]], iota: Iota
) -> set[Configuration]:
    """Those from which every Buechi set can be visited again and again (all cells take time)."""
    targets = iota.buechi or (frozenset(range(len(iota.locations))),)
    live = set(reached)
    while True:
        before = len(live)
        for buechi in targets:
            marked = {each for each in live if each[1] in buechi}
            live = _can_reach_by_a_step(live, marked, successors)
        if len(live) == before:
            return live


def _can_reach_by_a_step(
    live: set[Configuration], marked: set[Configuration], successors: dict[Configuration, list[Configuration]]
) -> set[Configuration]:
    sources: dict[Configuration, list[Configuration]] = defaultdict(list)
    for source in live:
        for target in successors[source]:
            if target in live:
                sources[target].append(source)
    waiting = [source for target in marked for source in sources[target]]
    found = set(waiting)
    while waiting:
        for source in sources[waiting.pop()]:
            if source not in found:
                found.add(source)
                waiting.append(source)
    return found
