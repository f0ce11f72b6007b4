"""Tables of small networks, against numbers worked out by hand."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from mitlplan.automata.transducer import (
    TIME,
    Constraint,
    Edge,
    Location,
    Network,
    Relation,
    Restless,
    Transducer,
)
from mitlplan.search.fastest import Exhausted, Found, Limits, fastest_run
from mitlplan.search.schedule import schedule
from mitlplan.search.tables import Tables, _pairs, tabulate
from mitlplan.workspace.abstract import abstract
from mitlplan.workspace.graph import Move, graph

UNBOUNDED = -1


def compare(clock: str, relation: str, bound: str) -> Constraint:
    """A constraint, as one writes it."""
    return Constraint(clock, Relation(relation), Fraction(bound))


def network(*transducers: Transducer, moves: tuple[Move, ...] = (Move("a", "b", 1, both=True),)) -> Network:
    """Two cells and these transducers; the predicate "at b" tells the cells apart."""
    workspace = graph({"a": [], "b": ["B"]}, moves, waiting=True)
    labels = [index for index, label in enumerate(workspace.label_sets) if "B" in label]
    return Network(abstract(workspace, 0), transducers, {"at b": frozenset(labels)})


def constants(tables: Tables, names: list[str]) -> list[dict[str, tuple[int, int]]]:
    """For each location of the first transducer its active clocks, with their constants in ticks."""
    arrays: Any = tables.arrays
    first = arrays["component_start"][1]
    result = []
    for row in arrays["location_bounds"][first:]:
        entries = range(arrays["bounds_start"][row], arrays["bounds_start"][row + 1])
        result.append(
            {
                names[arrays["bounds_clock"][entry]]: (
                    int(arrays["bounds_lower"][entry]),
                    int(arrays["bounds_upper"][entry]),
                )
                for entry in entries
            }
        )
    return result


ALARM = Transducer(
    "within 3 of b, at least half a second",
    (
        Location("idle"),
        Location("armed", (compare("x", "<=", "3"),)),
        Location("slow", (compare("y", "<", "5"),)),
        Location("done"),
    ),
    (
        Edge("idle", "idle", excludes=frozenset(("at b",))),
        Edge("idle", "armed", resets=frozenset(("x", "y")), requires=frozenset(("at b",))),
        Edge("armed", "armed", excludes=frozenset(("at b",))),
        Edge("armed", "slow", (compare("x", ">", "1/2"),)),
        Edge("slow", "done", (compare("y", ">=", "4/3"), compare("y", "<=", "2"))),
        Edge("done", "done"),
    ),
    (Edge("done", "done"),),
    (),
)


def test_active_clocks_and_constants() -> None:
    """A clock is active where it may be read before it is reset; constants come from all that is ahead."""
    tables = tabulate(network(ALARM))
    assert tables.scale == 6
    # Clocks are numbered as they are met: 0, the time, the map's, then as they are reset or read.
    names = {2: "z"}
    found = constants(tables, [names.get(clock, str(clock)) for clock in range(tables.arrays["clocks"])])
    assert len(found) == 4
    idle, armed, slow, done = found
    assert idle == {}
    assert done == {}
    x, y = sorted(armed)
    assert list(slow) in ([x], [y])
    if list(slow) == [x]:
        x, y = y, x
    # In `armed` x has its invariant above and an edge below; of y is known what comes later.
    assert armed == {x: (3, 18), y: (8, 30)}
    assert slow == {y: (8, 30)}


def test_the_time_is_no_clock_of_a_location_where_it_is_the_objective() -> None:
    deadline = Transducer(
        "b within 3",
        (Location("waiting", (compare(TIME, "<=", "3"),)), Location("done")),
        (
            Edge("waiting", "waiting", excludes=frozenset(("at b",))),
            Edge("waiting", "done", (compare(TIME, "<=", "3"),), requires=frozenset(("at b",))),
            Edge("done", "done"),
        ),
        (),
        (),
    )
    for objective, expected in ((True, {}), (False, {"t": (UNBOUNDED, 3)})):
        tables = tabulate(network(deadline), objective=objective)
        names = ["t"] * int(tables.arrays["clocks"])
        assert constants(tables, names) == [expected, {}]
        assert (tables.arrays["time_clock"] == UNBOUNDED) is not objective


def test_the_map() -> None:
    """A move is guarded by its least time and, where nobody may wait, the stay ends with its longest move."""
    workspace = graph({"a": [], "b": ["B"]}, [Move("a", "b", [1, 3]), Move("b", "a", 0)], waiting=False)
    tables = tabulate(Network(abstract(workspace, 0), (), {}))
    arrays: Any = tables.arrays
    assert (tables.cells, tables.components) == (2, 1)

    def guard(number: int) -> list[tuple[bool, bool, int]]:
        entries = range(arrays["guard_start"][number], arrays["guard_start"][number + 1])
        assert all(arrays["guard_clock"][entry] == arrays["driver_clock"] for entry in entries)
        return [
            (bool(arrays["guard_upper"][k]), bool(arrays["guard_strict"][k]), int(arrays["guard_value"][k]))
            for k in entries
        ]

    assert [guard(number) for number in arrays["move_guard"]] == [
        [(False, False, 1), (True, False, 3)],
        [],
        [],
    ]
    # The last location is where the robot is before it is anywhere.
    assert [guard(number) for number in arrays["location_invariant"]] == [[(True, False, 3)], [], []]
    assert [guard(number) for number in arrays["location_still"]] == [[(True, True, 3)], [], []]
    assert arrays["parkable"].tolist() == [0, 0, 0]
    assert arrays["move_target"].tolist() == [1, 0, 0]


def test_distances() -> None:
    """The least ticks to the cells of a target, through the fastest moves; from nowhere as from the start."""
    seeker = Transducer(
        "to b",
        (Location("seeking", target="at b", restless=Restless.NEVER),),
        (Edge("seeking", "seeking"),),
        (Edge("seeking", "seeking", requires=frozenset(("at b",))),),
        (),
    )
    workspace = graph(
        {"a": [], "c": [], "b": ["B"], "lost": []},
        [Move("a", "c", "1/2"), Move("c", "b", ["1/3", 2]), Move("a", "b", 3), Move("b", "lost", 1)],
        waiting=True,
    )
    labels = frozenset(index for index, label in enumerate(workspace.label_sets) if "B" in label)
    tables = tabulate(Network(abstract(workspace, 0), (seeker,), {"at b": labels}))
    assert tables.scale == 6
    assert tables.arrays["distances"].tolist() == [5, 2, 0, UNBOUNDED, 5]
    found = fastest_run(tables, Limits().begin())
    assert isinstance(found, Found)
    assert found.time == Fraction(5, 6)
    timed = schedule(tables, found.path, Fraction(1, 1000))
    assert timed.times == (0, Fraction(1, 2), Fraction(5, 6))


def test_where_steps_without_a_move_are_useful() -> None:
    """Never is -1 and always -2; where a target is sought, it is the number of the signal that shows it."""
    locations = (
        Location("calm", restless=Restless.NEVER),
        Location("busy", restless=Restless.ALWAYS),
        Location("seeking", target="at b", restless=Restless.WHEN_TARGET),
        Location("seeking what nobody reads", target="at a", restless=Restless.WHEN_TARGET),
        Location("seeking nothing", restless=Restless.WHEN_TARGET),
    )
    edges = tuple(
        Edge(location.name, location.name, requires=frozenset((name,)))
        for location in locations
        for name in ("at b", "at first")
    )
    two_cells = network(Transducer("each of them", locations, edges, (), ()))
    labels = {**two_cells.predicates, "at a": frozenset((0,)), "at first": frozenset((0,))}
    arrays: Any = tabulate(replace(two_cells, predicates=labels)).arrays
    first = arrays["component_start"][1]
    # Signals are numbered in the order of their names, as far as somebody reads them.
    assert arrays["location_restless"][first:].tolist() == [-1, -2, 0, -2, -2]


def test_a_target_that_cannot_be_reached() -> None:
    seeker = Transducer(
        "to b",
        (Location("seeking", target="at b"),),
        (Edge("seeking", "seeking"),),
        (Edge("seeking", "seeking", requires=frozenset(("at b",))),),
        (),
    )
    tables = tabulate(network(seeker, moves=(Move("b", "a"),)))
    assert tables.arrays["distances"].tolist() == [UNBOUNDED, 0, UNBOUNDED]
    assert fastest_run(tables, Limits().begin()) == Exhausted(1)


def test_edges_that_wait_for_a_signal_that_nobody_sends_are_left_out() -> None:
    listener = Transducer(
        "deaf",
        (Location("here"),),
        (Edge("here", "here", requires=frozenset(("never sent",))), Edge("here", "here")),
        (),
        (),
    )
    tables = tabulate(network(listener))
    first = tables.arrays["component_start"][1]
    assert np.diff(tables.arrays["move_start"][first:]).tolist() == [1]


@pytest.mark.parametrize("rows", [1, 5, 8, 9, 10, 40], ids="{} rows".format)
def test_pairs_are_numbered_in_order_whichever_way_is_quicker(rows: int) -> None:
    """Few are sorted, and many are marked in a table of all that there can be: nine, here."""
    stream = random.Random(rows)
    first, second = ([stream.randrange(-1, 2) for _ in range(rows)] for _ in range(2))
    pairs, which = _pairs(np.array(first, dtype=np.int32), np.array(second, dtype=np.int32), 2)
    assert pairs == sorted({*zip(first, second, strict=True)})
    assert [pairs[number] for number in which] == list(zip(first, second, strict=True))


@pytest.mark.parametrize("count", [63, 64, 65, 129])
def test_signals_fill_words_of_64(count: int) -> None:
    """The last of many signals is heard as well as the first: many transducers wait for one each."""
    names = [f"signal {number:03}" for number in range(count)]
    speaker = Transducer(
        "speaker", (Location("here"),), (Edge("here", "here", emits=frozenset(names)),), (), ()
    )
    listeners = tuple(
        Transducer(
            f"hears {name}",
            (Location("deaf"), Location("told")),
            (
                Edge("deaf", "told", requires=frozenset((name,))),
                Edge("deaf", "deaf", excludes=frozenset((name,))),
                Edge("told", "told"),
            ),
            (),
            (),
        )
        for name in names
    )
    tables = tabulate(network(speaker, *listeners))
    words = -(-count // 64)
    assert tables.arrays["words"] == words
    said = int(tables.arrays["move_emits"][tables.arrays["move_start"][tables.arrays["component_start"][1]]])
    masks = tables.arrays["signals"].reshape(-1, words)
    assert sum(int(mask).bit_count() for mask in masks[said]) == count
    heard = {int(row) for row in tables.arrays["move_reads"]} - {0}
    assert sorted(sum(int(word) << (64 * k) for k, word in enumerate(masks[row])) for row in heard) == [
        1 << number for number in range(count)
    ]


@pytest.mark.parametrize(
    ("first", "second", "bound"),
    [
        # The common denominator is 2 * 3 * 5 * ... of two large primes, about 10^18.
        ("1/999999937", "1/999999929", "1000000000"),
        ("1/999999937", "1/999999929", "2"),
        ("1/3", "1/7", str(2**60)),
    ],
)
def test_times_that_need_too_many_ticks(first: str, second: str, bound: str) -> None:
    watch = Transducer(
        "watch",
        (Location("here", (compare("x", "<=", bound),)),),
        (Edge("here", "here", resets=frozenset(("x",))),),
        (),
        (),
    )
    slow = network(watch, moves=(Move("a", "b", first), Move("b", "a", second)))
    with pytest.raises(OverflowError, match=rf"^a time of {bound} s is more than 2\^60 ticks of 1/"):
        tabulate(slow)


def test_times_at_the_limit_are_taken() -> None:
    """In half seconds the last that fits is 2^59 - 1/2."""
    longest = 2**59 - 1
    tables = tabulate(network(moves=(Move("a", "b", longest), Move("b", "a", "1/2"))))
    assert 2 * longest in tables.arrays["guard_value"].tolist()
    with pytest.raises(OverflowError):
        tabulate(network(moves=(Move("a", "b", 2**59), Move("b", "a", "1/2"))))
