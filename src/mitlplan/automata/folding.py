"""Grids with fewer locations: a location a row, and the column in a bounded integer.

Some tools need time that grows with the cube of the number of locations just to load a model. Moves that do
the same in neighbouring columns become one edge with a range of columns, so an n x n grid has about n
locations and 4n edges.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

from mitlplan.automata.timed_automaton import (
    Arithmetic,
    Assignment,
    Automaton,
    BoundedInteger,
    Edge,
    Expression,
    Location,
    Number,
    Test,
    Variable,
)

Coordinates: TypeAlias = tuple[int, int]
"""Row and column."""


def fold_columns(
    automaton: Automaton, coordinates: Sequence[Coordinates | None], variable: str
) -> tuple[Automaton, BoundedInteger]:
    """The same automaton with a location for each row, and the variable that holds the column.

    Parameters
    ----------
    coordinates
        For each location its row and column, or ``None`` if it stands for no cell.
    variable
        The name of the variable.

    Examples
    --------
    >>> cells = tuple(Location(f"c{column}") for column in range(4))
    >>> corridor = Automaton("map", cells, tuple(Edge(column, column + 1) for column in range(3)))
    >>> folded, column = fold_columns(corridor, [(0, column) for column in range(4)], "column")
    >>> len(folded.locations), len(folded.edges), column.most
    (1, 1, 3)
    """
    return _Folding(automaton, coordinates, variable).build()


_Kind: TypeAlias = tuple[Location, int | None]
"""What locations folded into one have in common: all but the name, and the row."""


class _Folding:
    def __init__(
        self, automaton: Automaton, coordinates: Sequence[Coordinates | None], variable: str
    ) -> None:
        self._automaton = automaton
        self._variable = variable
        self._columns = [None if place is None else place[1] for place in coordinates]
        self._kinds: list[_Kind] = []
        occupied: dict[tuple[_Kind, int], int] = defaultdict(int)
        self._keys: list[tuple[_Kind, int]] = []
        for location, place in zip(automaton.locations, coordinates, strict=True):
            kind = (replace(location, name=location.name if place is None else ""), place and place[0])
            column = 0 if place is None else place[1]
            # A second location for the same cell, such as one to pass through, is folded apart.
            self._keys.append((kind, occupied[kind, column]))
            occupied[kind, column] += 1
        self._number = {key: index for index, key in enumerate(dict.fromkeys(self._keys))}
        columns: dict[int, list[int]] = defaultdict(list)
        for key, own in zip(self._keys, self._columns, strict=True):
            if own is not None:
                columns[self._number[key]].append(own)
        self._ranges = {number: (min(here), max(here)) for number, here in columns.items()}

    def build(self) -> tuple[Automaton, BoundedInteger]:
        names = [
            location.name or (f"row{row}" if layer == 0 else f"row{row}_{layer}")
            for (location, row), layer in self._number
        ]
        taken: set[str] = set()
        locations = []
        for name, ((location, _), _) in zip(names, self._number, strict=True):
            fresh = name
            while fresh in taken:
                fresh += "_"
            taken.add(fresh)
            locations.append(replace(location, name=fresh))
        start = self._automaton.initial
        most = max((column for column in self._columns if column is not None), default=0)
        column = BoundedInteger(self._variable, 0, most, self._columns[start] or 0)
        folded = Automaton(
            self._automaton.name, tuple(locations), tuple(self._edges()), self._number[self._keys[start]]
        )
        return folded, column

    def _edges(self) -> Iterator[Edge]:
        groups: dict[tuple[Edge, int], list[int]] = defaultdict(list)
        for edge in self._automaton.edges:
            source, target = self._columns[edge.source], self._columns[edge.target]
            plain = replace(
                edge,
                source=self._number[self._keys[edge.source]],
                target=self._number[self._keys[edge.target]],
            )
            if source is None:
                begins = () if target is None else (Assignment(self._variable, Number(target)),)
                yield replace(plain, assignments=(*plain.assignments, *begins))
            else:
                groups[plain, 0 if target is None else target - source].append(source)
        for (edge, shift), columns in groups.items():
            for first, last in _runs(columns):
                yield replace(
                    edge,
                    tests=(*edge.tests, *self._within(edge.source, first, last)),
                    assignments=(*edge.assignments, *self._shifted(shift)),
                )

    def _within(self, source: int, first: int, last: int) -> Iterator[Test]:
        """The test for a range of columns, as far as it is needed."""
        column = Variable(self._variable)
        least, most = self._ranges[source]
        if least < first == last < most:
            yield Test(column, "==", Number(first))
            return
        if first > least:
            yield Test(column, ">=", Number(first))
        if last < most:
            yield Test(column, "<=", Number(last))

    def _shifted(self, shift: int) -> Iterator[Assignment]:
        if shift:
            operator = "+" if shift > 0 else "-"
            moved: Expression = Arithmetic(operator, Variable(self._variable), Number(abs(shift)))
            yield Assignment(self._variable, moved)


def _runs(columns: Sequence[int]) -> Iterator[tuple[int, int]]:
    """The runs of neighbouring columns: first and last."""
    ordered = sorted(columns)
    first = ordered[0]
    for this, following in zip(ordered, [*ordered[1:], None], strict=True):
        if following is None or following > this + 1:
            yield first, this
            if following is not None:
                first = following
