"""A disjunction: whoever claims it claims one of its operands, anew at every step."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from mitlplan.automata.transducer import Edge, Location, Restless, Transducer
from mitlplan.translation.compact.claims import (
    NOTHING,
    Claim,
    Demand,
    Inputs,
    edge,
    every_input,
    made,
)

CHOOSING = "choosing"


def choice(name: str, claim: Claim, label: Demand, others: tuple[Demand, ...], parked: Demand) -> Transducer:
    """A transducer that meets claims by `label` where it can, and by one of `others` elsewhere."""

    def options(asked: bool) -> tuple[Demand | None, ...]:
        return others if asked else (None,)

    def edges() -> Iterator[Edge | None]:
        for inputs in every_input(claim):
            if not (inputs.point or inputs.open):
                yield edge(CHOOSING, CHOOSING, inputs=inputs)
                continue
            yield edge(CHOOSING, CHOOSING, inputs=inputs, at_point=(label,))
            excluded = NOTHING if label.impossible else label.predicates
            for point, open_phase in product(options(inputs.point), options(inputs.open)):
                yield edge(
                    CHOOSING,
                    CHOOSING,
                    inputs=inputs,
                    at_point=(point,) if point else (),
                    in_open=(open_phase,) if open_phase else (),
                    excludes=excluded,
                )

    def endings() -> Iterator[Edge | None]:
        yield edge(CHOOSING, CHOOSING, inputs=Inputs(claim, False, False))
        asked = Inputs(claim, True, False)
        yield edge(CHOOSING, CHOOSING, inputs=asked, at_point=(label,))
        for option in others:
            excluded = NOTHING if label.impossible else label.predicates
            yield edge(CHOOSING, CHOOSING, inputs=asked, at_point=(option,), excludes=excluded)

    def parkings() -> Iterator[Edge | None]:
        for inputs in every_input(claim):
            demands = (parked,) if inputs.point or inputs.open else ()
            yield edge(CHOOSING, CHOOSING, inputs=inputs, at_point=demands)

    # With one temporal operand the label decides, and another step would decide the same.
    location = Location(CHOOSING, restless=Restless.ALWAYS if len(others) > 1 else Restless.NEVER)
    return Transducer(name, (location,), made(edges()), made(endings()), made(parkings()))
