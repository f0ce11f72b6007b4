"""Timed transducers that move in lock step, and the map automaton that drives them.

A *step* happens at an instant: every component takes one edge, then all clocks run for a positive time, the
*open phase*, until the next step. Components talk through boolean signals. The driver (the map) emits the
predicates of the cell it is in; each transducer reads signals (``requires``, ``excludes``) and emits
others, which only components behind it in the order read. A signal of the form ``n.point`` is a claim about
the instant of the step, ``n.open`` one about the open phase after it: this is how open and closed bounds
are honoured exactly (Maler, Nickovic and Pnueli 2006 keep to one value a phase; single instants are then
lost). Every edge of a transducer is an input/output edge of an IOTA; the composition is never built.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

TIME = "t"
"""The clock that is never reset: the time of the mission. Only upper bounds may be asked of it."""

NEVER = -1
"""In ``MapAutomaton.invariant`` and ``most``: no bound."""


class Relation(Enum):
    """How a clock is compared with a constant."""

    LESS = "<"
    AT_MOST = "<="
    AT_LEAST = ">="
    GREATER = ">"


@dataclass(frozen=True, slots=True)
class Constraint:
    """A bound on one clock, in seconds."""

    clock: str
    relation: Relation
    bound: Fraction

    def __str__(self) -> str:
        return f"{self.clock}{self.relation.value}{self.bound}"

    @property
    def negated(self) -> Constraint:
        """What holds where this one does not."""
        opposite = {
            Relation.LESS: Relation.AT_LEAST,
            Relation.AT_MOST: Relation.GREATER,
            Relation.AT_LEAST: Relation.LESS,
            Relation.GREATER: Relation.AT_MOST,
        }
        return Constraint(self.clock, opposite[self.relation], self.bound)


Guard = tuple[Constraint, ...]


@dataclass(frozen=True, slots=True)
class Edge:
    """A move of one transducer.

    Parameters
    ----------
    requires, excludes
        Signals that must be set, and that must not be set, in this step.
    emits
        Signals that this move sets.
    marked
        Whether the move visits the transducer's Büchi set.
    """

    source: str
    target: str
    guard: Guard = ()
    resets: frozenset[str] = frozenset()
    requires: frozenset[str] = frozenset()
    excludes: frozenset[str] = frozenset()
    emits: frozenset[str] = frozenset()
    marked: bool = False


class Restless(Enum):
    """Whether a step without a move of the robot can be of use to a transducer in a location."""

    NEVER = "never"
    WHEN_TARGET = "when target"
    ALWAYS = "always"


@dataclass(frozen=True, slots=True)
class Location:
    """A location of a transducer.

    Parameters
    ----------
    invariant
        Holds during the open phase.
    target
        A predicate that must hold at some later step, or the empty string: a hint for the search.
    deadline
        The clock and its value by which `target` must hold, if there is one.
    restless
        When silent steps must be tried here; ``WHEN_TARGET`` means in cells where `target` holds.
    relief
        A location that owes less, if there is one: with the same values of the clocks that are active there,
        whatever can be done from here can be done from there.
    """

    name: str
    invariant: Guard = ()
    target: str = ""
    deadline: Constraint | None = None
    restless: Restless = Restless.NEVER
    relief: str = ""


@dataclass(frozen=True, slots=True)
class Transducer:
    """One component of a network.

    Parameters
    ----------
    name
        What it watches, for people.
    locations
        The first is the initial one, before the step at time 0.
    edges
        The moves of a step that is followed by an open phase.
    endings
        The moves of a last step, after which nothing is owed whatever follows; targets are not used.
    parkings
        The moves of a step after which nothing is owed if the label never changes again.
    acceptance
        Whether infinite runs must take marked edges infinitely often.
    """

    name: str
    locations: tuple[Location, ...]
    edges: tuple[Edge, ...]
    endings: tuple[Edge, ...]
    parkings: tuple[Edge, ...]
    acceptance: bool = False

    def __post_init__(self) -> None:
        known = {location.name for location in self.locations}
        for edge in self.edges:
            if edge.source not in known or edge.target not in known:
                raise ValueError(f"{self.name}: an edge joins unknown locations")


@dataclass(frozen=True, eq=False)
class MapAutomaton:
    """The paper's Fig. 1: a location a cell, one clock z, a move when z has reached its travel time.

    Parameters
    ----------
    initial
        The cells the robot may start in.
    label_sets, label_of
        ``label_sets[label_of[cell]]`` are the propositions of a cell.
    source, target
        int32, shape (moves,), sorted by source.
    durations
        The distinct constants of guards and invariants, in seconds.
    least, most
        int32, shape (moves,): guard ``durations[least] <= z <= durations[most]``; `most` may be ``NEVER``.
    invariant
        int32, shape (cells,): ``z <= durations[invariant]``, or ``NEVER``.
    may_park
        Whether the robot may stay in a cell for ever.
    """

    initial: tuple[int, ...]
    label_sets: tuple[frozenset[str], ...]
    label_of: NDArray[np.int32]
    source: NDArray[np.int32]
    target: NDArray[np.int32]
    durations: tuple[Fraction, ...]
    least: NDArray[np.int32]
    most: NDArray[np.int32]
    invariant: NDArray[np.int32]
    may_park: bool

    @property
    def location_count(self) -> int:
        """The number of cells."""
        return len(self.label_of)


@dataclass(frozen=True, eq=False)
class Network:
    """A map automaton and the transducers that watch it, emitters before readers.

    Parameters
    ----------
    predicates
        Where each predicate signal is set: indices into ``map.label_sets``.
    """

    map: MapAutomaton
    transducers: tuple[Transducer, ...]
    predicates: Mapping[str, frozenset[int]]
