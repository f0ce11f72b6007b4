"""Random small missions, a seed each, on maps of every shape.

They are small enough for the tick oracles and mean enough for the engine: one-way moves, dead ends, ranges of
time, moves that take any positive time, corners that may not be cut, and robots without a choice, whose one
walk satisfies the mission or does not. All times are whole seconds; a `Case` tells the engine another unit.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Literal

from mitlplan.logic import formula as f
from mitlplan.workspace.graph import Move, graph
from mitlplan.workspace.grid import grid
from mitlplan.workspace.move_time import MoveTime
from mitlplan.workspace.workspace import Workspace
from mitlplan_fuzz.formulas import (
    Choices,
    SeededChoices,
    UntilKind,
    chance,
    draw_formula,
    one_of,
    parts,
    scaled,
    text_of,
)

Horizon = Literal["infinite", "finite"]
Stay = tuple[Fraction, Fraction | None]
"""The least and the most time in a cell before a move; without a most, 0 means any positive time."""


@dataclass(frozen=True)
class Squares:
    """A grid, as its own key of the mission file gives it."""

    rows: int
    columns: int
    blocked: tuple[tuple[int, int], ...]
    straight: Stay
    diagonal: Stay | None

    def cells(self) -> Iterator[tuple[int, int]]:
        """The free cells, row by row."""
        return (
            place for place in product(range(self.rows), range(self.columns)) if place not in self.blocked
        )

    def moves(self) -> Iterator[tuple[str, str, Fraction, Fraction | None]]:
        """The moves, found cell by cell: a second opinion on how grids are built."""
        free = set(self.cells())
        for (row, column), down, right in product(sorted(free), (-1, 0, 1), (-1, 0, 1)):
            steps = abs(down) + abs(right)
            beside = {(row + down, column), (row, column + right), (row + down, column + right)}
            stay = self.straight if steps == 1 else self.diagonal
            if steps and stay is not None and beside <= free:
                yield f"r{row}c{column}", f"r{row + down}c{column + right}", *stay


@dataclass(frozen=True)
class SmallMission:
    """A mission in plain values: what is printed when something fails.

    Parameters
    ----------
    cells, moves
        The map; of `squares`, if these are given, it is the same told otherwise.
    formula
        All requirements together: the operands of the outermost conjunction, if they are `apart`.
    """

    cells: tuple[tuple[str, tuple[str, ...]], ...]
    moves: tuple[tuple[str, str, Fraction, Fraction | None], ...]
    waiting: bool
    start: str
    formula: f.Formula
    horizon: Horizon = "infinite"
    until: UntilKind = "standard"
    squares: Squares | None = None
    apart: bool = False

    def workspace(self) -> Workspace:
        """The workspace as the product reads it."""
        if self.squares is None:
            moves = [Move(origin, target, _time(stay)) for origin, target, *stay in self.moves]
            return graph(dict(self.cells), moves, waiting=self.waiting)
        squares = self.squares
        return grid(
            squares.rows,
            squares.columns,
            blocked=squares.blocked,
            move_time=_time(squares.straight),
            waiting=self.waiting,
            regions=self._regions(),
            neighbours=4 if squares.diagonal is None else 8,
            diagonal_time=None if squares.diagonal is None else _time(squares.diagonal),
        )

    def _regions(self) -> dict[str, list[tuple[int, int]]]:
        assert self.squares is not None
        labelled = list(zip(self.squares.cells(), (holds for _, holds in self.cells), strict=True))
        names = sorted({name for _, holds in labelled for name in holds})
        return {name: [place for place, holds in labelled if name in holds] for name in names}

    @property
    def start_index(self) -> int:
        """The number of the cell in which the robot starts."""
        return [name for name, _ in self.cells].index(self.start)

    @property
    def requirements(self) -> tuple[tuple[str, f.Formula], ...]:
        """The requirements, by name."""
        if self.apart and isinstance(self.formula, f.And):
            return tuple((f"requirement {number}", part) for number, part in enumerate(self.formula.operands))
        return (("spec", self.formula),)

    @property
    def tick_timed(self) -> bool:
        """Whether every plan changes cells at whole times: then the tick oracles are exact."""
        return not self.waiting and all(least == most for _, _, least, most in self.moves)

    @property
    def forced(self) -> bool:
        """Whether the robot has no choice: there is one walk, at exact times, for ever."""
        ways = [sum(origin == name for origin, *_ in self.moves) for name, _ in self.cells]
        return self.tick_timed and all(count == 1 for count in ways)

    def yaml(self) -> str:
        """The mission file, to reproduce a failure by hand."""
        atoms = sorted({part.name for part in parts(self.formula) if isinstance(part, f.Atom)})
        lines = ["mitlplan: 1", "workspace:", *(self._graph() if self.squares is None else self._grid())]
        lines += [
            f"    propositions: [{', '.join(atoms)}]",
            f"    waiting: {str(self.waiting).lower()}",
            f"robot: {{start: {self.start}}}",
        ]
        if len(self.requirements) == 1:
            lines.append(f'spec: "{text_of(self.formula)}"')
        else:
            lines += ["spec:", *(f'  {name}: "{text_of(part)}"' for name, part in self.requirements)]
        lines += [f"horizon: {self.horizon}", f"until: {self.until}"]
        return "\n".join(lines) + "\n"

    def _graph(self) -> Iterator[str]:
        cells = ", ".join(f"{name}: [{', '.join(holds)}]" for name, holds in self.cells)
        yield from ("  graph:", f"    cells: {{{cells}}}", "    moves:" + ("" if self.moves else " []"))
        for origin, target, *stay in self.moves:
            yield f"      - {{from: {origin}, to: {target}, time: {_shown(stay)}}}"

    def _grid(self) -> Iterator[str]:
        assert self.squares is not None
        squares = self.squares
        yield "  grid:"
        yield f"    rows: {squares.rows}"
        yield f"    columns: {squares.columns}"
        yield f"    blocked: {[list(place) for place in squares.blocked]}"
        yield f"    move_time: {_shown(squares.straight)}"
        if squares.diagonal is not None:
            yield "    neighbours: 8"
            yield f"    diagonal_time: {_shown(squares.diagonal)}"
        regions = (f"{name}: {[list(place) for place in places]}" for name, places in self._regions().items())
        yield f"    regions: {{{', '.join(regions)}}}"

    def scaled(self, factor: Fraction) -> SmallMission:
        """The same mission with every time multiplied."""
        moves = tuple((origin, target, *_scaled(stay, factor)) for origin, target, *stay in self.moves)
        squares = self.squares and replace(
            self.squares,
            straight=_scaled(self.squares.straight, factor),
            diagonal=self.squares.diagonal and _scaled(self.squares.diagonal, factor),
        )
        return replace(self, moves=moves, formula=scaled(self.formula, factor), squares=squares)


def _time(stay: Sequence[Fraction | None]) -> MoveTime:
    least, most = stay
    assert least is not None
    return least if most is None else [least, most]


def _shown(stay: Sequence[Fraction | None]) -> str:
    least, most = stay
    return f'"{least}"' if most is None or least == most else f'["{least}", "{most}"]'


def _scaled(stay: Sequence[Fraction | None], factor: Fraction) -> Stay:
    least, most = stay
    assert least is not None
    return least * factor, None if most is None else most * factor


# --- Missions on any graph ---------------------------------------------------------------------------------


def draw_mission(choices: Choices) -> SmallMission:
    """A small mission on a graph."""
    names = ("A", "B", "C")[: choices.number(1, 3)]
    waiting = chance(choices, 35)
    ranges = chance(choices, 25)
    # Freedom in time multiplies the plans to look through, so such maps are smaller.
    count = choices.number(2, 3 if waiting and ranges else 4 if waiting or ranges else 5)
    cells = tuple((f"c{index}", _draw_label(choices, names)) for index in range(count))
    until: UntilKind = "closed" if chance(choices, 20) else "standard"
    formula = draw_formula(choices, names, open_ends=chance(choices, 50), until=until)
    return SmallMission(
        cells=cells,
        moves=tuple(_draw_moves(choices, [name for name, _ in cells], ranges)),
        waiting=waiting,
        start="c0",
        formula=formula,
        horizon="finite" if chance(choices, 20) else "infinite",
        until=until,
    )


def _draw_label(choices: Choices, names: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in names if chance(choices, 40))


def _draw_moves(
    choices: Choices, names: Sequence[str], ranges: bool
) -> Iterator[tuple[str, str, Fraction, Fraction]]:
    unit = chance(choices, 40)
    dead_ends = chance(choices, 10)
    for origin in names:
        others = [name for name in names if name != origin]
        targets = [target for target in others if chance(choices, 45)]
        if not targets and not dead_ends:
            targets = [one_of(choices, others)]
        for target in targets:
            least = 1 if unit else choices.number(1, 3)
            most = choices.number(least, 3) if ranges else least
            yield origin, target, Fraction(least), Fraction(most)


def random_mission(seed: int) -> SmallMission:
    """The mission on a graph of that number."""
    return draw_mission(SeededChoices(random.Random(seed)))


# --- Cases of every kind -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class MissionCase:
    """A mission, and what the engine takes for a second: it must not matter."""

    mission: SmallMission
    factor: Fraction = Fraction(1)

    def __str__(self) -> str:
        return self.mission.scaled(self.factor).yaml()


@dataclass(frozen=True)
class FormulaCase:
    """A formula alone: is it satisfiable, is it valid, does it mean what it is rewritten as."""

    formula: f.Formula
    rewritten: f.Formula
    names: tuple[str, ...]
    until: UntilKind

    def __str__(self) -> str:
        return (
            f"formula: {text_of(self.formula)}\nrewritten: {text_of(self.rewritten)}\nuntil: {self.until}\n"
        )


Case = MissionCase | FormulaCase


def random_case(seed: int) -> Case:
    """The case of that number."""
    choices = SeededChoices(random.Random(seed))
    kind = choices.number(0, 99)
    if kind < 10:
        return _draw_formula_case(choices)
    if kind < 45:
        mission = draw_mission(choices)
    elif kind < 65:
        mission = _draw_on_squares(choices)
    elif kind < 80:
        mission = _draw_forced(choices)
    else:
        mission = _draw_shaped(choices)
    if chance(choices, 30):
        mission = replace(mission, apart=True)
    factor = Fraction(choices.number(1, 7), choices.number(1, 7)) if chance(choices, 30) else Fraction(1)
    return MissionCase(mission, factor)


def _draw_formula_case(choices: Choices) -> FormulaCase:
    from mitlplan_fuzz.rewriting import draw_rewritten

    names = ("A", "B")[: choices.number(1, 2)]
    until: UntilKind = "closed" if chance(choices, 20) else "standard"
    formula = draw_formula(choices, names, depth=2, open_ends=chance(choices, 50), until=until)
    return FormulaCase(formula, draw_rewritten(choices, formula), names, until)


def _draw_task(choices: Choices, mission: SmallMission, names: Sequence[str]) -> SmallMission:
    """The mission with something to do."""
    until: UntilKind = "closed" if chance(choices, 20) else "standard"
    return replace(
        mission,
        formula=draw_formula(choices, names, open_ends=chance(choices, 50), until=until),
        horizon="finite" if chance(choices, 20) else "infinite",
        until=until,
    )


def _draw_stay(choices: Choices) -> Stay:
    """Exact for the most part; else a range, or any positive time, or that up to a most."""
    kind = choices.number(0, 9)
    least, most = Fraction(choices.number(1, 2)), Fraction(choices.number(2, 3))
    return (
        (least, least)
        if kind < 6
        else (least, most)
        if kind < 8
        else (Fraction(0), most if kind == 8 else None)
    )


def _draw_on_squares(choices: Choices) -> SmallMission:
    rows, columns = one_of(choices, ((1, 3), (2, 2), (3, 1), (2, 3), (3, 2), (1, 4)))
    blocked = tuple(place for place in product(range(rows), range(columns)) if chance(choices, 15))
    if len(blocked) >= rows * columns - 1:
        blocked = blocked[: rows * columns - 2]
    diagonal = _draw_stay(choices) if chance(choices, 30) else None
    squares = Squares(rows, columns, blocked, _draw_stay(choices), diagonal)
    free = list(squares.cells())
    names = ("A", "B", "C")[: choices.number(1, 3)]
    cells = tuple((f"r{row}c{column}", _draw_label(choices, names)) for row, column in free)
    mission = SmallMission(
        cells=cells,
        moves=tuple(squares.moves()),
        waiting=chance(choices, 30) and len(free) < 5,
        start=one_of(choices, cells)[0],
        formula=f.Constant(value=True),
        squares=squares,
    )
    return _draw_task(choices, mission, names)


def _draw_forced(choices: Choices) -> SmallMission:
    """One way only, which comes back to one of its cells."""
    count = choices.number(1, 6)
    names = ("A", "B", "C")[: choices.number(1, 3)]
    cells = tuple((f"c{index}", _draw_label(choices, names)) for index in range(count + 1))
    follows = [*range(1, count + 1), choices.number(0, count - 1)]
    stays = [Fraction(choices.number(1, 3)) for _ in follows]
    mission = SmallMission(
        cells=cells,
        moves=tuple(
            (f"c{index}", f"c{after}", stay, stay)
            for index, (after, stay) in enumerate(zip(follows, stays, strict=True))
        ),
        waiting=False,
        start="c0",
        formula=f.Constant(value=True),
    )
    return _draw_task(choices, mission, names)


def _draw_shaped(choices: Choices) -> SmallMission:
    """A corridor, a ring or a star, with moves of every kind."""
    count = choices.number(2, 4)
    shape = choices.number(0, 2)
    ways = {
        0: [(index, index + 1) for index in range(count - 1)],
        1: [(index, (index + 1) % count) for index in range(count)],
        2: [(0, index) for index in range(1, count)],
    }[shape]
    one_way = shape == 1 and chance(choices, 40)
    names = ("A", "B", "C")[: choices.number(1, 3)]
    both = ways if one_way else sorted({*ways, *((target, origin) for origin, target in ways)})
    mission = SmallMission(
        cells=tuple((f"c{index}", _draw_label(choices, names)) for index in range(count)),
        moves=tuple((f"c{origin}", f"c{target}", *_draw_stay(choices)) for origin, target in both),
        waiting=chance(choices, 25) and count < 4,
        start="c0",
        formula=f.Constant(value=True),
    )
    return _draw_task(choices, mission, names)
