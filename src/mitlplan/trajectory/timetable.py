"""The crossings at which the sum of cost / duration along a chain is least.

Every crossing has a window and every duration between two crossings its bounds: a convex problem whose
Newton steps are tridiagonal. Bounds that leave no choice are removed first, in exact arithmetic, so that a
point strictly between all others exists. From there a logarithmic barrier is followed; with m bounds and
barrier weight v the sum is within m v of the least one, and that tells when to stop. (S. Boyd and L.
Vandenberghe, Convex Optimization, 2004, section 11.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

Array: TypeAlias = NDArray[np.float64]
Window: TypeAlias = tuple[Fraction, Fraction]

_TICKS = 10**6
_GAP = 1e-9
_EASING = 0.2
_MOST_STEPS = 60


@dataclass(frozen=True, slots=True)
class Span:
    """What is done between two crossings.

    Parameters
    ----------
    cost
        In one second; in d seconds a d-th of it.
    least, most
        Seconds; a `most` of ``None`` is no bound.
    """

    cost: float
    least: Fraction
    most: Fraction | None = None


def cheapest_times(spans: Sequence[Span], windows: Sequence[Window]) -> list[Fraction]:
    """The crossings, a window each, with a span between each two; exact numbers that keep every bound.

    Parameters
    ----------
    spans
        In order.
    windows
        One more than `spans`; some choice of the crossings must keep all bounds.

    Examples
    --------
    >>> start, end = Fraction(0), Fraction(6)
    >>> spans = [Span(1.0, Fraction(1)), Span(4.0, Fraction(1))]
    >>> [str(time) for time in cheapest_times(spans, [(start, start), (start, end), (end, end)])]
    ['0', '2', '6']
    """
    windows = _narrowed(spans, windows)
    chain = _Chain.of(spans, windows)
    moments = chain.settle() if len(chain.low) > 1 else chain.low
    times = [moments[group] + float(offset) for group, offset in chain.place]
    return _exact(times, spans, windows)


def _narrowed(spans: Sequence[Span], windows: Sequence[Window]) -> list[Window]:
    """The windows without the instants that no choice of the other crossings allows."""
    low, high = [window[0] for window in windows], [window[1] for window in windows]
    for place, span in enumerate(spans):
        low[place + 1] = max(low[place + 1], low[place] + span.least)
        if span.most is not None:
            high[place + 1] = min(high[place + 1], high[place] + span.most)
    for place in range(len(spans) - 1, -1, -1):
        high[place] = min(high[place], high[place + 1] - spans[place].least)
        most = spans[place].most
        if most is not None:
            low[place] = max(low[place], low[place + 1] - most)
    return list(zip(low, high, strict=True))


def _exact(times: Sequence[float], spans: Sequence[Span], windows: Sequence[Window]) -> list[Fraction]:
    found = [windows[0][0]]
    for time, span, (low, high) in zip(times[1:], spans, windows[1:], strict=True):
        earliest = max(low, found[-1] + span.least)
        latest = high if span.most is None else min(high, found[-1] + span.most)
        found.append(min(max(Fraction(round(time * _TICKS), _TICKS), earliest), latest))
    return found


@dataclass(frozen=True, slots=True)
class _Chain:
    """What is left to choose: a moment for each group of crossings that only move together.

    `place` is the group and the offset of each crossing; between group k and the next lies a span of duration
    ``moment[k + 1] - moment[k] - behind[k]``, within `least` and `most`.
    """

    place: list[tuple[int, Fraction]]
    low: Array
    high: Array
    cost: Array
    behind: Array
    least: Array
    most: Array

    @classmethod
    def of(cls, spans: Sequence[Span], windows: Sequence[Window]) -> _Chain:
        place = [(0, Fraction(0))]
        groups = [windows[0]]
        rows: list[tuple[float, Fraction, Fraction, Fraction | None]] = []
        for number, span in enumerate(spans):
            (low, high), (next_low, next_high) = windows[number], windows[number + 1]
            shortest = max(span.least, next_low - high)
            longest = next_high - low if span.most is None else min(span.most, next_high - low)
            group, offset = place[-1]
            if shortest == longest:
                place.append((group, offset + shortest))
            else:
                place.append((group + 1, Fraction(0)))
                groups.append(windows[number + 1])
                rows.append((span.cost, offset, span.least, span.most))
        return cls(
            place,
            low=np.array([float(first) for first, _ in groups]),
            high=np.array([float(last) for _, last in groups]),
            cost=np.array([cost for cost, _, _, _ in rows]),
            behind=np.array([float(behind) for _, behind, _, _ in rows]),
            least=np.array([float(least) for _, _, least, _ in rows]),
            most=np.array([np.inf if most is None else float(most) for _, _, _, most in rows]),
        )

    def settle(self) -> Array:
        """The best moments, within a relative gap."""
        moments = self._inside()
        bounds = 2 * len(moments) + 2 * len(self.cost)
        weight = self._sum(moments) / bounds
        while bounds * weight > _GAP * self._sum(moments):
            moments = self._centred(moments, weight)
            weight *= _EASING
        return self._centred(moments, weight)

    def _inside(self) -> Array:
        """A point strictly between all bounds: each moment takes its part of what is left to those behind."""
        moments: list[float] = []
        count = len(self.low)
        earliest, latest = float(self.low[0]), float(self.high[0])
        for group in range(count):
            moments.append(earliest + (latest - earliest) / (count + 1 - group))
            if group < count - 1:
                begin = moments[-1] + self.behind[group]
                earliest = max(self.low[group + 1], begin + self.least[group])
                latest = min(self.high[group + 1], begin + self.most[group])
        return np.array(moments)

    def _durations(self, moments: Array) -> Array:
        return np.asarray(np.diff(moments) - self.behind)

    def _sum(self, moments: Array) -> float:
        return float((self.cost / self._durations(moments)).sum())

    def _centred(self, moments: Array, weight: float) -> Array:
        """Newton's method on the sum and `weight` times the barrier."""
        value = self._barrier(moments, weight)
        for _ in range(_MOST_STEPS):
            step, slope = self._newton(moments, weight)
            if slope < _GAP * weight:
                break
            size = 1.0
            while not (found := self._barrier(moments + size * step, weight)) <= value - 0.1 * size * slope:
                size /= 2
                if size < 1e-9:
                    return moments
            moments, value = moments + size * step, found
        return moments

    def _margins(self, moments: Array) -> tuple[Array, Array, Array, Array]:
        """How far the moments and the durations are from their bounds."""
        durations = self._durations(moments)
        return moments - self.low, self.high - moments, durations - self.least, self.most - durations

    def _barrier(self, moments: Array, weight: float) -> float:
        after, before, more, less = self._margins(moments)
        free = self.low < self.high
        margins = np.concatenate([after[free], before[free], more, less[np.isfinite(less)]])
        if (margins <= 0).any():
            return np.inf
        return self._sum(moments) - weight * float(np.log(margins).sum())

    def _newton(self, moments: Array, weight: float) -> tuple[Array, float]:
        """The step, and the decrease that it promises."""
        free = self.low < self.high
        after, before, more, less = self._margins(moments)
        durations = self._durations(moments)
        pull = -self.cost / durations**2 - weight / more + weight / less
        stiffness = 2 * self.cost / durations**3 + weight / more**2 + weight / less**2
        after, before = np.where(free, after, 1.0), np.where(free, before, 1.0)
        gradient = weight / before - weight / after
        diagonal = weight / before**2 + weight / after**2
        gradient[1:] += pull
        gradient[:-1] -= pull
        diagonal[1:] += stiffness
        diagonal[:-1] += stiffness
        beside = np.where(free[1:] & free[:-1], -stiffness, 0.0)
        gradient, diagonal = np.where(free, gradient, 0.0), np.where(free, diagonal, 1.0)
        step = solveh_banded(np.vstack([np.append(0.0, beside), diagonal]), -gradient)
        return step, float(-gradient @ step)
