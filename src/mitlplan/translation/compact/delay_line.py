"""A delay of exactly a: what is claimed now is claimed of the next transducer a later.

``F_[a,b] = F_[a,a] F_[0,b-a]``, and the same for G. The claim is first smoothed: where it ends, the gap up
to the next claim may be filled. That leaves so few stretches that a fixed number of recorders can hold
those not yet replayed: the truth of ``F_[a,b] f`` has no true stretch shorter than b - a unless it begins
at 0, and gaps inside a true stretch can be filled; that of ``G_[a,b] f`` has no false stretch shorter than
b - a, and shorter gaps can be filled (docs: translation, section 3). Each recorder remembers one stretch: the
ages of its two ends, and whether the ends belong to it. Recorders stand in a row, and the first free one
takes the next stretch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import floor

from mitlplan.automata.transducer import Constraint, Edge, Guard, Location, Relation, Restless, Transducer
from mitlplan.translation.compact.ages import exactly
from mitlplan.translation.compact.claims import Claim, Demand, Inputs, edge, every_input, made

LOW, HIGH, FILLING = "low", "high", "filling"
EMPTY, SPOT, REPLAYING = "empty", "spot", "replaying"


@dataclass(frozen=True, slots=True)
class Line:
    """The signals between the smoother and its recorders.

    ``begin_attained`` and ``begin_limit`` start a stretch with or without the instant, ``spot`` is a
    stretch of one instant; each of them is handed on from recorder to recorder. ``end_attained`` and
    ``end_limit`` close the stretch being recorded.
    """

    number: int

    def begin(self, kind: str, recorder: int) -> str:
        """The signal by which `recorder` is asked to begin a stretch: attained, limit, or spot."""
        return f"{self.number}.begin {kind} {recorder}"

    def end(self, kind: str) -> str:
        """The signal that ends the stretch: attained or limit."""
        return f"{self.number}.end {kind}"


KINDS = ("attained", "limit")
BEGINNINGS = (*KINDS, "spot")


def recorder_count(delay: Fraction, width: Fraction) -> int:
    """How many stretches may have to be remembered at once, for a delay a and a width b - a, in seconds.

    Of the stretches that end within a, only the first and the last, or their gaps, may be shorter than b - a.
    """
    return floor(delay / width) + 2


def smoother(name: str, claim: Claim, parked: Demand) -> Transducer:
    """Turns claims into stretches, each beginning and ending with a claim."""
    line = Line(claim.number)

    def begin(kind: str) -> frozenset[str]:
        return frozenset((line.begin(kind, 0),))

    def end(kind: str) -> frozenset[str]:
        return frozenset((line.end(kind),))

    def edges() -> Iterator[Edge | None]:
        for inputs in every_input(claim):
            match inputs.point, inputs.open:
                case False, False:
                    yield edge(LOW, LOW, inputs=inputs)
                    yield edge(HIGH, LOW, inputs=inputs, emits=end("limit"))
                    yield edge(HIGH, FILLING, inputs=inputs)
                    yield edge(FILLING, FILLING, inputs=inputs)
                case True, False:
                    yield edge(LOW, LOW, inputs=inputs, emits=begin("spot"))
                    yield edge(LOW, FILLING, inputs=inputs, emits=begin("attained"))
                    for source in (HIGH, FILLING):
                        yield edge(source, LOW, inputs=inputs, emits=end("attained"))
                        yield edge(source, FILLING, inputs=inputs)
                case False, True:
                    yield edge(LOW, HIGH, inputs=inputs, emits=begin("limit"))
                    yield edge(HIGH, HIGH, inputs=inputs, emits=end("limit") | begin("limit"))
                    yield edge(HIGH, HIGH, inputs=inputs)
                    yield edge(FILLING, HIGH, inputs=inputs)
                case _:
                    yield edge(LOW, HIGH, inputs=inputs, emits=begin("attained"))
                    yield edge(HIGH, HIGH, inputs=inputs)
                    yield edge(FILLING, HIGH, inputs=inputs)

    def endings() -> Iterator[Edge | None]:
        yield edge(LOW, LOW, inputs=Inputs(claim, False, False))

    def parkings() -> Iterator[Edge | None]:
        for source in (LOW, HIGH, FILLING):
            for inputs in every_input(claim):
                demands = (parked,) if inputs.point or inputs.open or source != LOW else ()
                yield edge(source, LOW, inputs=inputs, at_point=demands)

    return Transducer(
        name,
        (Location(LOW), Location(HIGH, relief=LOW), Location(FILLING, relief=LOW)),
        made(edges()),
        made(endings()),
        made(parkings()),
    )


def recorder(
    name: str, claim: Claim, index: int, last: bool, delay: Fraction, replay: Demand, parked: Demand
) -> Transducer:
    """Remembers one stretch and replays it, as demands of `replay`, when it is `delay` old."""
    line = Line(claim.number)
    first, second = f"begun {claim.number}.{index}", f"ended {claim.number}.{index}"
    begins = {kind: line.begin(kind, index) for kind in BEGINNINGS}
    ends = {kind: line.end(kind) for kind in KINDS}
    young: dict[str, Guard] = {clock: (Constraint(clock, Relation.LESS, delay),) for clock in (first, second)}
    ripe = {clock: exactly(clock, delay) for clock in (first, second)}
    no_begin = frozenset(begins.values())
    no_end = frozenset(ends.values())
    on_point, on_open = replay.at_point() | replay.requires(), replay.in_open()
    requires = replay.requires()

    def takes(source: str, guard: Guard, emits: frozenset[str], needs: frozenset[str]) -> Iterator[Edge]:
        """From empty, or from a stretch whose last instant is replayed now."""
        yield Edge(source, EMPTY, guard, requires=needs, excludes=no_begin, emits=emits)
        for kind in BEGINNINGS:
            target = SPOT if kind == "spot" else f"recording {kind}"
            asked = frozenset((begins[kind],))
            yield Edge(source, target, guard, frozenset((first,)), needs | asked, emits=emits)

    def passes_on(
        source: str,
        target: str,
        guard: Guard,
        *,
        ended: str = "",
        resets: frozenset[str] = frozenset(),
        point: bool = False,
        open_phase: bool = False,
        watches_end: bool = True,
    ) -> Iterator[Edge]:
        """While it holds a stretch, what is asked of it goes to the next recorder."""
        needs = requires if point or open_phase else frozenset()
        emits = (on_point if point else frozenset()) | (on_open if open_phase else frozenset())
        excludes: frozenset[str] = frozenset()
        if ended:
            needs |= {ends[ended]}
        elif watches_end:
            excludes |= no_end
        yield Edge(source, target, guard, resets, needs, excludes | no_begin, emits)
        if last:
            return
        for kind in BEGINNINGS:
            yield Edge(
                source,
                target,
                guard,
                resets,
                needs | {begins[kind]},
                excludes,
                emits | {line.begin(kind, index + 1)},
            )

    def edges() -> Iterator[Edge]:
        yield from takes(EMPTY, (), frozenset(), frozenset())
        yield from passes_on(SPOT, SPOT, young[first], watches_end=False)
        yield from takes(SPOT, ripe[first], on_point, requires)
        for start in KINDS:
            recording = f"recording {start}"
            attained = start == "attained"
            yield from passes_on(recording, recording, young[first])
            yield from passes_on(recording, REPLAYING, ripe[first], point=attained, open_phase=True)
            for stop in KINDS:
                recorded, closing = f"recorded {start} {stop}", f"closing {stop}"
                ended = frozenset((second,))
                yield from passes_on(recording, recorded, young[first], ended=stop, resets=ended)
                yield from passes_on(
                    recording,
                    closing,
                    ripe[first],
                    ended=stop,
                    resets=ended,
                    point=attained,
                    open_phase=True,
                )
                yield from passes_on(recorded, recorded, young[first], watches_end=False)
                yield from passes_on(
                    recorded, closing, ripe[first], point=attained, open_phase=True, watches_end=False
                )
        yield from passes_on(REPLAYING, REPLAYING, (), point=True, open_phase=True)
        for stop in KINDS:
            closing = f"closing {stop}"
            yield from passes_on(
                REPLAYING,
                closing,
                (),
                ended=stop,
                resets=frozenset((second,)),
                point=True,
                open_phase=True,
            )
            yield from passes_on(
                closing, closing, young[second], point=True, open_phase=True, watches_end=False
            )
            if stop == "attained":
                yield from takes(closing, ripe[second], on_point, requires)
            else:
                yield from takes(closing, ripe[second], frozenset(), frozenset())

    def endings() -> Iterator[Edge]:
        yield Edge(EMPTY, EMPTY, excludes=no_begin)
        yield Edge(SPOT, EMPTY, ripe[first], requires=requires, excludes=no_begin, emits=on_point)
        yield Edge(
            "closing attained", EMPTY, ripe[second], requires=requires, excludes=no_begin, emits=on_point
        )
        yield Edge("closing limit", EMPTY, ripe[second], excludes=no_begin)

    locations = [Location(EMPTY)]
    for source in dict.fromkeys(one.target for one in edges()):
        if source == EMPTY:
            continue
        clock = second if source.startswith("closing") else first
        invariant: Guard = ()
        if source != REPLAYING:
            invariant = (Constraint(clock, Relation.AT_MOST, delay),)
        locations.append(Location(source, invariant, restless=Restless.ALWAYS, relief=EMPTY))

    def parkings() -> Iterator[Edge | None]:
        yield edge(EMPTY, EMPTY)
        # Its last claims were made just before the instant that is replayed now: their windows have begun.
        yield edge("closing limit", EMPTY, guard=ripe[second])
        for location in locations[1:]:
            yield edge(location.name, EMPTY, at_point=(parked,))

    return Transducer(name, tuple(locations), tuple(edges()), tuple(endings()), made(parkings()))
