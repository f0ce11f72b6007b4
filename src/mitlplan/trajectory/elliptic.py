"""Jacobi's functions and their integrals, accurate where the modulus is almost 1.

The controls of the cheapest motions are Jacobi functions, and long motions come close to the modulus 1,
where ``1 - m`` is all that matters and has long been lost to rounding. So the complement 1 - m is an
argument of its own. The integral of the first kind is Carlson's (Numerical Algorithms 10, 1995); the
amplitude and the integral of sn^2 come from the arithmetic-geometric mean (Abramowitz and Stegun, 16.4 and
17.6), the latter from the argument rather than the amplitude, on which it depends too steeply.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprf

Array = NDArray[np.float64]

_LEAST_COMPLEMENT = 1e-280


@dataclass(frozen=True, slots=True)
class Modulus:
    """The square root k of m together with 1 - m, each of which loses what the other keeps.

    Examples
    --------
    >>> Modulus(0.6, 0.64).quarter_period  # doctest: +ELLIPSIS
    1.75075380...
    """

    root: float
    complement: float

    @property
    def quarter_period(self) -> float:
        """K, the integral of the first kind up to a quarter turn."""
        return float(elliprf(0.0, max(self.complement, _LEAST_COMPLEMENT), 1.0))

    def argument(self, angle: float) -> float:
        """F, the integral of ``1 / sqrt(1 - m sin^2)`` from 0 to an `angle` of any size."""
        half_turns = round(angle / math.pi)
        rest = angle - half_turns * math.pi
        sine, square = math.sin(rest), math.cos(rest) ** 2
        second = square + max(self.complement, _LEAST_COMPLEMENT) * sine**2
        return 2 * half_turns * self.quarter_period + sine * float(elliprf(square, second, 1.0))

    def amplitude(self, argument: Array) -> tuple[Array, Array]:
        """The angle whose F is `argument`, and the integral of sn^2 from 0 to `argument`."""
        levels = self._levels()
        mean = levels[-1][0]
        angle = np.asarray(argument * (2.0 ** len(levels) * mean))
        periodic = np.zeros_like(angle)
        mean_value = 0.5
        for depth in range(len(levels), 0, -1):
            mean, other, half = levels[depth - 1]
            sine = np.sin(angle)
            periodic = periodic + half * sine
            mean_value += 2.0 ** (depth - 1) * (half / self.root) ** 2
            # The arcsine of half / mean * sine, written so that it keeps its digits near a right angle.
            descent = np.arctan2(half * sine, np.hypot(mean * np.cos(angle), other * sine))
            angle = (angle + descent) / 2
        return angle, np.asarray(argument * mean_value - periodic / self.root**2)

    def delta(self, angle: Array) -> Array:
        """dn, ``sqrt(1 - m sin^2 angle)``."""
        return np.asarray(np.hypot(np.cos(angle), math.sqrt(self.complement) * np.sin(angle)))

    def _levels(self) -> list[tuple[float, float, float]]:
        """The means a, b and c of each level; the gap c shrinks quadratically, so three digits decide."""
        mean, other, gap = 1.0, math.sqrt(max(self.complement, _LEAST_COMPLEMENT)), self.root
        levels: list[tuple[float, float, float]] = []
        while not levels or gap > 1e-9 * mean:
            mean, other = (mean + other) / 2, math.sqrt(mean * other)
            gap = gap**2 / (4 * mean)
            levels.append((mean, other, gap))
        return levels
