"""Intervals of time: the subscripts of the temporal operators.

An interval has exact ends, each open or closed; an upper end of ``None`` is infinity. It is never
empty: the constructor refuses what no time satisfies, so later stages need not ask.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True, order=True)
class Interval:
    """A non-empty interval of non-negative times, in seconds.

    Parameters
    ----------
    lower, upper
        The ends; an ``upper`` of ``None`` stands for infinity, and is open.
    lower_open, upper_open
        Whether the end itself is left out.

    Raises
    ------
    ValueError
        If no time lies in the interval, or its lower end is negative.

    Examples
    --------
    >>> print(Interval(Fraction(0), Fraction(7, 2)))
    [0,7/2]
    >>> Fraction(4) in Interval(Fraction(0), None)
    True
    """

    lower: Fraction = Fraction(0)
    upper: Fraction | None = None
    lower_open: bool = False
    upper_open: bool = False

    def __post_init__(self) -> None:
        if self.upper is None:
            object.__setattr__(self, "upper_open", True)
        if self.lower < 0:
            raise ValueError(f"the interval {self} begins before time 0")
        if self.upper is not None and (
            self.upper < self.lower or (self.upper == self.lower and (self.lower_open or self.upper_open))
        ):
            raise ValueError(f"the interval {self} contains no time")

    @property
    def punctual(self) -> bool:
        """Whether the interval is a single instant."""
        return self.lower == self.upper

    @property
    def unrestricted(self) -> bool:
        """Whether the interval is ``[0,inf)``, the one that is left out when written."""
        return self.lower == 0 and not self.lower_open and self.upper is None

    def __contains__(self, time: Fraction | int) -> bool:
        above = time > self.lower if self.lower_open else time >= self.lower
        if self.upper is None:
            return above
        return above and (time < self.upper if self.upper_open else time <= self.upper)

    def __str__(self) -> str:
        opening = "(" if self.lower_open else "["
        closing = ")" if self.upper_open else "]"
        upper = "inf" if self.upper is None else str(self.upper)
        return f"{opening}{self.lower},{upper}{closing}"


ALWAYS = Interval()
"""The interval ``[0,inf)`` that an operator without a subscript has."""
