"""Zones the slow way: a conjunction of constraints x_i - x_j <= v or < v, in Python numbers.

One matrix, closed from scratch by Floyd and Warshall after whatever was done to it. The operations are
written from their definitions as sets, with an auxiliary variable where the definition says "there is": *some
time passes* moves the reference back by that time and forgets the old one. Nothing here is shared with the
native zones, and nothing is fast.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

Number: TypeAlias = int | Fraction
Bound: TypeAlias = "tuple[Number, bool] | None"
"""(value, strict); ``None`` is infinity."""

Matrix: TypeAlias = "tuple[tuple[Bound, ...], ...]"

ZERO: Bound = (0, False)


def tighter(a: Bound, b: Bound) -> Bound:
    """The stronger of two bounds on the same difference."""
    if a is None or b is None:
        return b if a is None else a
    return min(a, b, key=lambda bound: (bound[0], not bound[1]))


def chain(a: Bound, b: Bound) -> Bound:
    """The bound on x - z that follows from bounds on x - y and y - z."""
    if a is None or b is None:
        return None
    return a[0] + b[0], a[1] or b[1]


@dataclass(frozen=True)
class MatrixZone:
    """A closed matrix, or ``None`` for the empty zone."""

    dimension: int
    closed: Matrix | None

    @staticmethod
    def universe(dimension: int) -> MatrixZone:
        free: list[list[Bound]] = [[None] * dimension for _ in range(dimension)]
        return MatrixZone.of(free)

    @staticmethod
    def zero(dimension: int) -> MatrixZone:
        return MatrixZone.of([[ZERO] * dimension for _ in range(dimension)])

    @staticmethod
    def of(rows: Sequence[Sequence[Bound]]) -> MatrixZone:
        """The valuations of clocks >= 0 that satisfy every entry."""
        dimension = len(rows)
        least = [
            [tighter(bound, ZERO) if i in (0, j) else bound for j, bound in enumerate(row)]
            for i, row in enumerate(rows)
        ]
        return MatrixZone(dimension, close(least))

    @property
    def empty(self) -> bool:
        return self.closed is None

    def rows(self) -> list[list[Bound]]:
        assert self.closed is not None
        return [list(row) for row in self.closed]

    def constrain(self, i: int, j: int, bound: Bound) -> MatrixZone:
        if self.closed is None:
            return self
        rows = self.rows()
        rows[i][j] = tighter(rows[i][j], bound)
        return MatrixZone.of(rows)

    def contains(self, point: Sequence[Number]) -> bool:
        """Whether the clocks, in order, without the reference, may have these values."""
        values = [0, *point]
        return self.closed is not None and all(
            bound is None or difference < bound[0] or (difference == bound[0] and not bound[1])
            for i, row in enumerate(self.closed)
            for j, bound in enumerate(row)
            for difference in [values[i] - values[j]]
        )

    def later(self, *, strictly: bool) -> MatrixZone:
        """``{v + d}`` for some d >= 0, or d > 0.

        The reference moves back by d, which makes every clock larger by d; the old one is forgotten.
        """
        if self.closed is None:
            return self
        moved = [[ZERO, (0, strictly), *[None] * (self.dimension - 1)]]
        moved += [[None, *row] for row in self.rows()]
        closed = close(moved)
        assert closed is not None
        return MatrixZone.of(_taken(closed, [0, *range(2, self.dimension + 1)]))

    def free(self, i: int) -> MatrixZone:
        if self.closed is None:
            return self
        rows = self.rows()
        for j in range(self.dimension):
            rows[i][j] = rows[j][i] = None
        return MatrixZone.of(rows)

    def reset(self, i: int, value: Number) -> MatrixZone:
        return self.free(i).constrain(i, 0, (value, False)).constrain(0, i, (-value, False))

    def intersect(self, other: MatrixZone) -> MatrixZone:
        if self.closed is None or other.closed is None:
            return MatrixZone(self.dimension, None)
        pairs = zip(self.closed, other.closed, strict=True)
        return MatrixZone.of([[tighter(a, b) for a, b in zip(*rows, strict=True)] for rows in pairs])

    def includes(self, other: MatrixZone) -> bool:
        """No valuation of the other violates one of the constraints."""
        if self.closed is None:
            return other.empty
        return all(
            other.constrain(j, i, (-bound[0], not bound[1])).empty
            for i, row in enumerate(self.closed)
            for j, bound in enumerate(row)
            if bound is not None
        )

    def remap(self, source: Sequence[int]) -> MatrixZone:
        """Keep, copy and permute clocks; a source of -1 is a new clock that is 0."""
        if self.closed is None:
            return MatrixZone(len(source), None)
        return MatrixZone.of(_taken(self.closed, [max(i, 0) for i in source]))

    def extrapolate_lu_plus(
        self, lower: Sequence[Number | None], upper: Sequence[Number | None]
    ) -> MatrixZone:
        """Extra+_LU as its paper defines it, entry by entry; ``None`` is the constant minus infinity."""
        if self.closed is None:
            return self
        least = [-self._value(0, i) for i in range(self.dimension)]
        rows = self.rows()
        for i, row in enumerate(self.closed):
            for j, bound in enumerate(row):
                if bound is None or i == j:
                    continue
                if i > 0 and (exceeds(bound[0], lower[i]) or exceeds(least[i], lower[i])):
                    rows[i][j] = None
                elif j > 0 and exceeds(least[j], upper[j]):
                    constant = upper[j]
                    rows[i][j] = None if i > 0 or constant is None else (-constant, True)
        return MatrixZone.of(rows)

    def _value(self, i: int, j: int) -> Number:
        assert self.closed is not None
        bound = self.closed[i][j]
        assert bound is not None
        return bound[0]


def exceeds(number: Number, constant: Number | None) -> bool:
    """Whether a number is larger than a constant that may be minus infinity."""
    return constant is None or number > constant


def close(rows: Sequence[Sequence[Bound]]) -> Matrix | None:
    """Shortest paths between all pairs; ``None`` if there is a negative cycle."""
    nodes = range(len(rows))
    paths = [list(row) for row in rows]
    for k in nodes:
        for i in nodes:
            for j in nodes:
                paths[i][j] = tighter(paths[i][j], chain(paths[i][k], paths[k][j]))
    if any(tighter(paths[i][i], ZERO) != ZERO for i in nodes):
        return None
    return tuple(tuple(row) for row in paths)


def _taken(matrix: Matrix, source: Sequence[int]) -> list[list[Bound]]:
    return [[matrix[i][j] for j in source] for i in source]
