"""How a motion is run through in time: evenly, or from rest to rest.

By the paper's lemma a motion with controls u(t), taken at s(t) instead, has the controls u(s) s'. Motions
here have a constant rate of cost, so the cost grows by the integral of s'^2 over one second: by nothing for
the even profile, which is the cheapest, by 6/5 for the cubic and 10/7 for the quintic one.
"""

from __future__ import annotations

from enum import Enum

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Profile(Enum):
    """What share of a motion is done after what share of its time.

    Examples
    --------
    >>> round(Profile.CUBIC.cost_factor, 12), round(Profile.QUINTIC.cost_factor, 12)
    (1.2, 1.428571428571)
    """

    EVEN = (0.0, 1.0)
    """The least cost; the controls jump."""
    CUBIC = (0.0, 0.0, 3.0, -2.0)
    """From rest to rest with continuous controls."""
    QUINTIC = (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)
    """From rest to rest with continuous accelerations."""

    @property
    def cost_factor(self) -> float:
        """By how much it multiplies the cost of a motion."""
        square = Polynomial(self.value).deriv() ** 2
        return float(square.integ()(1.0))

    def progress(self, share: Array) -> tuple[Array, Array, Array]:
        """The share that is done, and its first and second derivatives."""
        done = Polynomial(self.value)
        first, second = done.deriv(), done.deriv(2)
        return np.asarray(done(share)), np.asarray(first(share)), np.asarray(second(share))
