"""Two protocols that networks of timed automata are measured with, for any number of processes.

Fischer's mutual exclusion (Lamport 1987, "A fast mutual exclusion algorithm"; Abadi and Lamport 1994, "An
old-fashioned recipe for real time"): who finds the lock free writes its name within `delay`, waits for longer
than that, and enters if the name is still its own. The medium access of CSMA/CD (Yovine 1997, "Kronos: a
verification tool for real-time systems", 5): stations begin to send on a bus that sounds idle, learn of a
collision within twice the time that a signal needs, and try again.

    python -m benchmarks.protocols fischer 4 --to uppaal|tchecker

prints a model.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from mitlplan.automata.timed_automaton import (
    Assignment,
    Automaton,
    BoundedInteger,
    Channel,
    Edge,
    Location,
    Network,
    Number,
    Query,
    Synchronisation,
    Target,
    Test,
    Urgency,
    Variable,
    exactly,
)
from mitlplan.automata.transducer import Constraint, Guard, Relation
from mitlplan.formats.tchecker import write_tchecker
from mitlplan.formats.uppaal import write_uppaal

DELAY = Fraction(10)
"""Within which Fischer's processes write, and after which they may enter."""

FRAME = Fraction(808)
"""Microseconds that a station of CSMA/CD sends."""

SIGNAL = Fraction(26)
"""Microseconds after which every station hears that one has begun."""


@dataclass(frozen=True, slots=True)
class Protocol:
    """A network with two questions whose answers are known.

    Parameters
    ----------
    forbidden
        What the protocol is there to prevent: unreachable.
    usual
        Something that happens.
    least, attained
        When that is, at the earliest; if not `attained`, any time after.
    """

    name: str
    size: int
    network: Network
    forbidden: Query
    usual: Query
    least: Fraction
    attained: bool


# -- mutual exclusion ----------------------------------------------------------------------------------


def fischer(count: int, *, patient: bool = True) -> Protocol:
    """Fischer's protocol for `count` processes, which share an integer and nothing else.

    Parameters
    ----------
    patient
        Whether a process waits for more than the delay before it enters. If it waits for the delay alone,
        two can be inside, and `usual` asks for that.

    Examples
    --------
    >>> [location.name for location in fischer(4).network.automata[0].locations]
    ['idle', 'writing', 'waiting', 'inside']
    """
    names = [f"process{number}" for number in range(1, count + 1)]
    lock = BoundedInteger("lock", 0, count)
    clocks = tuple(f"x{number}" for number in range(1, count + 1))
    automata = tuple(
        _process(name, clock, number, lock.name, patient=patient)
        for number, (name, clock) in enumerate(zip(names, clocks, strict=True), start=1)
    )
    network = Network(automata, clocks, variables=(lock,))
    together = Query((Target(dict.fromkeys(names[:2], "inside")),))
    if patient:
        alone = Query((Target({names[0]: "inside"}),))
        return Protocol("Fischer", count, network, together, alone, DELAY, attained=False)
    # The second writes at the last instant, when the first enters, and waits in its turn.
    nowhere = Query((Target({names[0]: "inside", names[1]: "writing"}, _bound(clocks[1], ">", DELAY)),))
    return Protocol("Fischer, impatient", count, network, nowhere, together, 2 * DELAY, attained=True)


def _process(name: str, clock: str, number: int, lock: str, *, patient: bool) -> Automaton:
    free, own = (Test(Variable(lock), "==", Number(value)) for value in (0, number))
    reset = frozenset({clock})
    idle, writing, waiting, inside = range(4)
    return Automaton(
        name,
        (
            Location("idle"),
            Location("writing", _bound(clock, "<=", DELAY)),
            Location("waiting"),
            Location("inside"),
        ),
        (
            Edge(idle, writing, resets=reset, tests=(free,)),
            Edge(
                writing,
                waiting,
                _bound(clock, "<=", DELAY),
                reset,
                assignments=(Assignment(lock, Number(number)),),
            ),
            Edge(waiting, writing, resets=reset, tests=(free,)),
            Edge(waiting, inside, _bound(clock, ">" if patient else ">=", DELAY), tests=(own,)),
            Edge(inside, idle, assignments=(Assignment(lock, Number(0)),)),
        ),
    )


# -- medium access -------------------------------------------------------------------------------------


def csma_cd(count: int) -> Protocol:
    """CSMA/CD for `count` stations; a bus in a collision tells one station after the other, in no time.

    Examples
    --------
    >>> [automaton.name for automaton in csma_cd(2).network.automata]
    ['bus', 'station1', 'station2']
    """
    names = [f"station{number}" for number in range(1, count + 1)]
    clocks = tuple(f"x{number}" for number in range(1, count + 1))
    told = [Channel(f"collision{number}") for number in range(1, count + 1)]
    stations = (
        _station(name, clock, each.name) for name, clock, each in zip(names, clocks, told, strict=True)
    )
    network = Network(
        (_bus([each.name for each in told]), *stations),
        ("y", *clocks),
        (Channel("begin"), Channel("busy"), Channel("end"), *told),
    )
    both = dict.fromkeys(names[:2], "sending")
    deaf = Query((Target(both, _bound(clocks[0], ">=", 2 * SIGNAL)),))
    sent = Query((Target({names[0]: "sending"}, exactly(clocks[0], FRAME)),))
    return Protocol("CSMA/CD", count, network, deaf, sent, FRAME, attained=True)


def _bus(told: list[str]) -> Automaton:
    idle, active, collision, *telling = range(len(told) + 2)
    y = frozenset({"y"})
    early = _bound("y", "<", SIGNAL)
    stops = [collision, *telling, idle]
    edges = [
        Edge(idle, active, resets=y, synchronisation=_hears("begin")),
        Edge(active, collision, early, y, _hears("begin")),
        Edge(active, active, _bound("y", ">=", SIGNAL), synchronisation=_tells("busy")),
        Edge(active, idle, resets=y, synchronisation=_hears("end")),
        *(
            Edge(
                source,
                target,
                early if source == collision else (),
                y if target == idle else frozenset(),
                _tells(channel),
            )
            for source, target, channel in zip(stops[:-1], stops[1:], told, strict=True)
        ),
    ]
    locations = (
        Location("idle"),
        Location("active"),
        Location("collision", early),
        *(Location(f"telling{at + 1}", urgency=Urgency.COMMITTED) for at in range(1, len(told))),
    )
    return Automaton("bus", locations, tuple(edges))


def _station(name: str, clock: str, collision: str) -> Automaton:
    idle, sending, retrying = range(3)
    x = frozenset({clock})
    soon = _bound(clock, "<", 2 * SIGNAL)
    return Automaton(
        name,
        (
            Location("idle"),
            Location("sending", _bound(clock, "<=", FRAME)),
            Location("retrying", soon),
        ),
        (
            Edge(idle, sending, resets=x, synchronisation=_tells("begin")),
            Edge(idle, retrying, resets=x, synchronisation=_hears("busy")),
            Edge(idle, idle, resets=x, synchronisation=_hears(collision)),
            Edge(idle, retrying, resets=x, synchronisation=_hears(collision)),
            Edge(sending, idle, exactly(clock, FRAME), x, _tells("end")),
            Edge(sending, retrying, soon, x, _hears(collision)),
            Edge(retrying, sending, soon, x, _tells("begin")),
            Edge(retrying, retrying, soon, x, _hears("busy")),
            Edge(retrying, retrying, soon, x, _hears(collision)),
        ),
    )


def _bound(clock: str, relation: str, bound: Fraction) -> Guard:
    return (Constraint(clock, Relation(relation), bound),)


def _tells(channel: str) -> Synchronisation:
    return Synchronisation(channel, sends=True)


def _hears(channel: str) -> Synchronisation:
    return Synchronisation(channel, sends=False)


# -- as files ------------------------------------------------------------------------------------------

PROTOCOLS = {"fischer": fischer, "csma_cd": csma_cd}


def as_uppaal(protocol: Protocol, query: Query) -> str:
    """The UPPAAL model that asks `query`."""
    return write_uppaal(protocol.network, query, notes=_notes(protocol))


def as_tchecker(protocol: Protocol, query: Query) -> str:
    """The TChecker model that asks for the locations of `query`; bounds on clocks are no labels there."""
    places = Query(tuple(Target(target.locations) for target in query.targets))
    return write_tchecker(protocol.network, places, notes=_notes(protocol))


def _notes(protocol: Protocol) -> Iterator[str]:
    yield f"{protocol.name}, {protocol.size} processes."


def main(arguments: list[str]) -> None:
    """Prints a model."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.protocols", description="Write a model.")
    parser.add_argument("protocol", choices=PROTOCOLS)
    parser.add_argument("size", type=int, help="processes or stations")
    parser.add_argument("--to", choices=("uppaal", "tchecker"), default="uppaal")
    chosen = parser.parse_args(arguments)
    protocol = PROTOCOLS[chosen.protocol](chosen.size)
    write = as_uppaal if chosen.to == "uppaal" else as_tchecker
    print(write(protocol, protocol.forbidden), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
