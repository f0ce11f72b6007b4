"""Claims: how the obligations of a formula ask for those of its parts.

The compact construction is one-sided: a transducer for psi guarantees that psi holds whenever psi is
*claimed*, and to do so it demands the arguments of psi, that is, sets their claims in turn. Formulas are in
negation normal form, hence monotone in the claims: demanding no more than what was claimed is sound, and
claiming exactly what is true makes it complete. A claim is made for the instant of a step, or for the open
phase behind it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

from mitlplan.automata.transducer import Edge, Guard

NOTHING: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Claim:
    """The pair of signals by which a transducer is asked."""

    number: int

    @property
    def point(self) -> str:
        """Claimed at the instant of the step."""
        return f"{self.number}.point"

    @property
    def open(self) -> str:
        """Claimed during the open phase after the step."""
        return f"{self.number}.open"


@dataclass(frozen=True, slots=True)
class Demand:
    """What must hold for a formula to hold: predicates of the label, and claims of temporal parts.

    An `impossible` demand is that of ``false``; one without predicates and claims is that of ``true``.
    """

    predicates: frozenset[str] = NOTHING
    claims: frozenset[Claim] = frozenset()
    impossible: bool = False

    @property
    def label_alone(self) -> bool:
        """Whether the label decides: no claim is involved."""
        return not self.claims

    def requires(self) -> frozenset[str]:
        """The predicates, as signals to read."""
        return self.predicates

    def at_point(self) -> frozenset[str]:
        """The signals that claim it at the instant of the step."""
        return frozenset(claim.point for claim in self.claims)

    def in_open(self) -> frozenset[str]:
        """The signals that claim it during the open phase."""
        return frozenset(claim.open for claim in self.claims)


@dataclass(frozen=True, slots=True)
class Operands:
    """The arguments of an until or a release, as demands.

    The parked ones speak of a label that never changes again: ``parked`` of the whole formula,
    ``parked_either`` of one argument or the other. A `target` is a predicate without which the right argument
    cannot hold; it may be the empty string.
    """

    left: Demand
    right: Demand
    parked_left: Demand
    parked_right: Demand
    parked_either: Demand
    parked: Demand
    target: str = ""


@dataclass(frozen=True, slots=True)
class Use:
    """Whether a transducer relies on a formula at the instant and in the open phase of a step.

    Where the label alone decides, relying on what is true costs nothing: there is one choice for the labels
    that satisfy the formula and one, marked by `excludes`, for those that do not.
    """

    point: bool
    open: bool
    excludes: frozenset[str] = NOTHING


def uses(demand: Demand, point_useful: bool, open_useful: bool) -> Iterator[Use]:
    """The choices worth trying when a formula helps at the instant, in the open phase, or in both."""
    if demand.impossible or not (point_useful or open_useful):
        yield Use(False, False)
    elif demand.label_alone:
        yield Use(point_useful, open_useful)
        if demand.predicates:
            yield Use(False, False, demand.predicates)
    else:
        points = (True, False) if point_useful else (False,)
        opens = (True, False) if open_useful else (False,)
        for point, open_phase in product(points, opens):
            yield Use(point, open_phase)


@dataclass(frozen=True, slots=True)
class Inputs:
    """The claims made of a transducer in one step."""

    claim: Claim
    point: bool
    open: bool

    def requires(self) -> frozenset[str]:
        """The claim signals that are set."""
        return frozenset(
            signal
            for signal, is_set in ((self.claim.point, self.point), (self.claim.open, self.open))
            if is_set
        )

    def excludes(self) -> frozenset[str]:
        """The claim signals that are not set."""
        return frozenset((self.claim.point, self.claim.open)) - self.requires()


def every_input(claim: Claim) -> Iterator[Inputs]:
    """The four ways in which a step can claim."""
    for point, open_phase in product((False, True), repeat=2):
        yield Inputs(claim, point, open_phase)


def edge(
    source: str,
    target: str,
    *,
    inputs: Inputs | None = None,
    guard: Guard = (),
    resets: frozenset[str] = NOTHING,
    at_point: tuple[Demand, ...] = (),
    in_open: tuple[Demand, ...] = (),
    excludes: frozenset[str] = NOTHING,
    emits: frozenset[str] = NOTHING,
    marked: bool = False,
) -> Edge | None:
    """An edge that makes the demands given, or ``None`` if one of them is impossible."""
    demands = (*at_point, *in_open)
    if any(demand.impossible for demand in demands):
        return None
    requires = frozenset().union(*(demand.requires() for demand in demands))
    if inputs is not None:
        requires |= inputs.requires()
        excludes |= inputs.excludes()
    if requires & excludes:
        return None
    emits = emits.union(
        *(demand.at_point() for demand in at_point), *(demand.in_open() for demand in in_open)
    )
    return Edge(source, target, guard, resets, requires, excludes, emits, marked)


def made(edges: Iterable[Edge | None]) -> tuple[Edge, ...]:
    """The edges whose demands are possible, each once."""
    return tuple(dict.fromkeys(candidate for candidate in edges if candidate is not None))
