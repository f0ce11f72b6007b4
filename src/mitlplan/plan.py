"""What the planner answers: a plan, a proof that there is none, or the limit that stopped the search.

The three are different types, so that a search that was cut short can never be read as a proof.
Times are exact, in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias, Union


@dataclass(frozen=True, slots=True)
class Step:
    """A stay in a cell, during ``[enter, leave)``.

    Parameters
    ----------
    cell
        The name of the cell.
    enter, leave
        When the robot enters and leaves; a `leave` of ``None`` means never (parking).
    holds
        The propositions of the cell, sorted.
    slack
        How much later the cell may be entered, the earlier ones as planned and the later ones free to
        shift, with the formula still satisfied; ``None`` means without limit.
    """

    cell: str
    enter: Fraction
    leave: Fraction | None
    holds: tuple[str, ...] = ()
    slack: Fraction | None = None


@dataclass(frozen=True, slots=True)
class Loop:
    """What the robot does after the last step: it goes on at ``steps[start]``.

    A `period` of ``None`` means that it stays in the last cell for ever (parking).
    """

    start: int
    period: Fraction | None


@dataclass(frozen=True, slots=True)
class Statistics:
    """How an answer was found: sizes of the automata, zones explored, seconds by stage, and what searched."""

    construction: str = "compact"
    locations: int = 0
    edges: int = 0
    zones: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    engine: str = "zones"


@dataclass(frozen=True, slots=True)
class Plan:
    """A timed run that satisfies the mission.

    Parameters
    ----------
    steps
        The stays in order; the first begins at time 0.
    makespan
        The least makespan (docs: semantics, section 3), attained or as an infimum.
    loop
        ``None`` for a finite plan.
    attained
        ``False`` if no plan attains the least makespan; this one is then within `epsilon` of it.
    checked
        Whether the independent judge has confirmed the plan.
    bound
        A proven lower bound on the makespan of every plan; equal to `makespan` when the plan is
        proved fastest.
    fault
        What the judge has against it: only the published construction, which is unsound, lets such through.
    """

    steps: tuple[Step, ...]
    makespan: Fraction
    loop: Loop | None = None
    attained: bool = True
    epsilon: Fraction | None = None
    checked: bool = False
    bound: Fraction | None = None
    statistics: Statistics = field(default_factory=Statistics)
    fault: str | None = None

    def __str__(self) -> str:
        stops = " -> ".join(f"{step.enter} {step.cell}" for step in self.steps)
        if self.loop is None:
            last = self.steps[-1]
            return stops if last.leave == last.enter else f"{stops} until {last.leave}"
        if self.loop.period is None:
            return f"{stops}, and stay"
        return f"{stops} -> {self.makespan} {self.steps[self.loop.start].cell}, and so on"


@dataclass(frozen=True, slots=True)
class Infeasible:
    """A proof that no plan exists: the search was exhausted.

    Parameters
    ----------
    reason
        A sentence for the user.
    conflict
        The names of requirements that already exclude each other on this map, minimal.
    """

    reason: str
    conflict: tuple[str, ...] = ()
    statistics: Statistics = field(default_factory=Statistics)

    def __str__(self) -> str:
        return self.reason


@dataclass(frozen=True, slots=True)
class LimitReached:
    """The search was stopped: nothing is known beyond `bound`.

    Parameters
    ----------
    reason
        Which limit, and how far the search got.
    bound
        No plan is faster than this.
    """

    reason: str
    bound: Fraction | None = None
    statistics: Statistics = field(default_factory=Statistics)

    def __str__(self) -> str:
        return self.reason


Outcome: TypeAlias = Union[Plan, Infeasible, LimitReached]
