"""Networks of timed automata that nobody here wrote, searched whole: ours beside other tools, in turns.

Fischer's protocol and CSMA/CD (:mod:`benchmarks.protocols`) are asked for what they are there to prevent, so
that every state is looked at. TChecker, if ``tck-reach`` is on the PATH, keeps the zones that lie in no other
(``covreach``), or in none up to simulation (``aLU-covreach``, which is also our test). Where it counts states
as we do, the work is the same and only the rate differs. UPPAAL's ``verifyta``, if it is there, tells no
counts that could be compared, and its time has the start of the process in it.

    python -m benchmarks.networks fischer 8

prints what memory our search takes, in a process of its own.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from benchmarks.contest import OURS, WrongAnswerError
from benchmarks.memory import peak, said
from benchmarks.protocols import PROTOCOLS, Protocol, as_tchecker, as_uppaal
from benchmarks.report import grouped, milliseconds, ratio
from benchmarks.satisfiability import GivenUpError
from mitlplan.errors import ToolError
from mitlplan.formats.verifyta import Verdict, find_verifyta, read_verdict
from mitlplan.search.reach import Effort, Unreachable, reach

SIZES: Mapping[str, Sequence[int]] = {"fischer": range(4, 11), "csma_cd": range(2, 11)}
TCHECKER = "tck-reach"
ALGORITHMS = ("covreach", "aLU-covreach")
LIMIT = 180.0
"""Seconds for one search of a peer: TChecker needs half a minute for ten processes."""


@dataclass(frozen=True, slots=True)
class Counts:
    """What a search did: states whose moves were tried, states kept, moves tried."""

    visited: int
    stored: int
    transitions: int


@dataclass
class Searched:
    """What was measured of one contestant on one network.

    Parameters
    ----------
    seconds
        One entry a round.
    counts
        None if it tells none.
    peak
        The most memory that its process held, in bytes; 0 if it is not known.
    before, kept
        Of ours alone, in bytes: what Python and the libraries held before the search, and in how much the
        search keeps its states.
    given_up
        Why there is no answer.
    """

    seconds: list[float] = field(default_factory=list)
    counts: Counts | None = None
    peak: int = 0
    before: int = 0
    kept: int = 0
    given_up: str | None = None


@dataclass(frozen=True)
class NetworkRow:
    """One network, measured; ours first."""

    protocol: Protocol
    searches: Mapping[str, Searched]

    @property
    def ours(self) -> Searched:
        """The planner's."""
        return self.searches[OURS]


Contestant = Callable[[Protocol, Searched], None]
"""Searches a network once and notes what that took."""


def networks() -> Iterator[tuple[str, int]]:
    """Names and sizes of all of them."""
    return ((name, size) for name, sizes in SIZES.items() for size in sizes)


def contestants() -> dict[str, Contestant]:
    """Ours, and the tools that are there."""
    found: dict[str, Contestant] = {OURS: _ours}
    tchecker = shutil.which(TCHECKER)
    if tchecker is not None:
        for algorithm in ALGORITHMS:
            found[f"{TCHECKER} {algorithm}"] = _by_tchecker(tchecker, algorithm)
    with suppress(ToolError):
        found["verifyta"] = _by_uppaal(find_verifyta())
    return found


def races(chosen: Iterable[tuple[str, int]], *, rounds: int, budget: float) -> Iterator[NetworkRow]:
    """The rows of the table; who gave up on one size of a protocol is not tried on larger ones.

    Parameters
    ----------
    rounds
        Runs at most.
    budget
        Seconds after which no further round begins.

    Raises
    ------
    WrongAnswerError
        If a contestant reaches what cannot be reached, or counts otherwise than it did before.
    """
    entered = contestants()
    absent: dict[tuple[str, str], str] = {}
    for name, size in chosen:
        protocol = PROTOCOLS[name](size)
        searches = {each: Searched(given_up=absent.get((name, each))) for each in entered}
        begin = time.perf_counter()
        for _ in range(rounds):
            for each, search in entered.items():
                if searches[each].given_up is None:
                    try:
                        search(protocol, searches[each])
                    except GivenUpError as error:
                        searches[each].given_up = str(error)
                        absent[name, each] = f"not tried: {error}"
            if time.perf_counter() - begin > budget:
                break
        ours = searches[OURS]
        ours.before, ours.peak, ours.kept = json.loads(
            said([sys.executable, "-m", "benchmarks.networks", name, str(size)])
        )
        yield NetworkRow(protocol, searches)


def _ours(protocol: Protocol, measured: Searched) -> None:
    begin = time.perf_counter()
    effort = _effort(protocol)
    measured.seconds.append(time.perf_counter() - begin)
    _note(protocol, OURS, measured, Counts(effort.visited, effort.stored, effort.transitions))


def _effort(protocol: Protocol) -> Effort:
    answer = reach(protocol.network, protocol.forbidden)
    if not isinstance(answer, Unreachable):
        raise WrongAnswerError(f"{protocol.name} {protocol.size}: {OURS} says {answer}")
    return answer.effort


def _note(protocol: Protocol, name: str, measured: Searched, counts: Counts) -> None:
    if measured.counts not in {None, counts}:
        raise WrongAnswerError(f"{protocol.name} {protocol.size}: {name} counts {counts} now")
    measured.counts = counts


def _by_tchecker(program: str, algorithm: str) -> Contestant:
    def search(protocol: Protocol, measured: Searched) -> None:
        with _written(as_tchecker(protocol, protocol.forbidden), "model.tck") as model:
            output = said([program, "-a", algorithm, "-s", "bfs", str(model)], limit=LIMIT)
        found = dict(re.findall(r"^(\w+) (\S+)$", output, re.MULTILINE))
        if found.get("REACHABLE") != "false":
            raise WrongAnswerError(f"{protocol.name} {protocol.size}: {program} says {output.strip()}")
        measured.seconds.append(float(found["RUNNING_TIME_SECONDS"]))
        measured.peak = int(found["MEMORY_MAX_RSS"]) * 1024
        keys = ("VISITED_STATES", "STORED_STATES", "VISITED_TRANSITIONS")
        _note(protocol, algorithm, measured, Counts(*(int(found[key]) for key in keys)))

    return search


def _by_uppaal(program: Path) -> Contestant:
    def search(protocol: Protocol, measured: Searched) -> None:
        with _written(as_uppaal(protocol, protocol.forbidden), "model.xml") as model:
            begin = time.perf_counter()
            output = said([str(program), str(model)], limit=LIMIT)
            measured.seconds.append(time.perf_counter() - begin)
        if read_verdict(output) is not Verdict.NO:
            raise WrongAnswerError(f"{protocol.name} {protocol.size}: {program} says {output.strip()}")

    return search


@contextmanager
def _written(model: str, name: str) -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="mitlplan") as folder:
        file = Path(folder, name)
        file.write_text(model, encoding="utf-8")
        yield file


# -- on the page ---------------------------------------------------------------------------------------


EXPLANATION = """\
## Networks of timed automata

`reach` on protocols of the literature, `python -m benchmarks.protocols` writes them: Fischer's mutual
exclusion with a delay of 10, and CSMA/CD with frames of 808 and signals of 26. All states are looked
at, since what is asked for never happens. TChecker (`tck-reach -s bfs`, where it is on the PATH) tells
how long its search took, without the start of the process and the reading of the model; *time* is ours
from the network in memory to the proof. **ratio**: our time to its. Where the counts of states visited,
states stored and moves are the same, both did the same work. *peak* is the most memory that a
process of its own held; ours has Python in it, *before* that is; *bytes a state* is what our search
keeps (zones, links, queue, hash tables), with the room it has reserved.
"""


SECOND_CORE = """\
### A second core

Two searches at once, in two threads, take {ratio} times as long as one alone (Fischer, n = 8): the
interpreter's lock is free while they search, so a second core serves a second mission. Within one search it
would not pay. By a profile (perf, Fischer with n = 10, 2026-11-26) three fifths of the time go into what has
to be done in one order, so that answers and counts stay the same every time: giving numbers to rows of
locations and integers (a quarter of all), comparing and keeping zones (a fifth), the queue (a seventh).
Making successors is the rest, and halving it would save a fifth at most, less what handing zones from one
core to the other costs.
"""


def networks_part(rows: Sequence[NetworkRow], second: float) -> str:
    """The part of the page, in Markdown; `second` is what :func:`two_at_once` says."""
    return "\n".join(
        [
            EXPLANATION,
            *networks_table(rows),
            "",
            *networks_remarks(rows),
            "",
            SECOND_CORE.format(ratio=ratio(second)),
        ]
    )


def two_at_once(rounds: int = 9) -> float:
    """How many times as long two searches in two threads take as one alone."""
    protocol = PROTOCOLS["fischer"](8)
    alone: list[float] = []
    both: list[float] = []
    with ThreadPoolExecutor(2) as pool:
        for _ in range(rounds):
            for count, seconds in ((1, alone), (2, both)):
                begin = time.perf_counter()
                list(pool.map(lambda _: reach(protocol.network, protocol.forbidden), range(count)))
                seconds.append(time.perf_counter() - begin)
    return median(both) / median(alone)


def networks_table(rows: Sequence[NetworkRow]) -> Iterator[str]:
    """A table of Markdown, the peers side by side."""
    peers = list(dict.fromkeys(name for row in rows for name in list(row.searches)[1:]))
    head = ["network", "n", "visited", "stored", "moves", "**time**", "moves a second", "bytes a state"]
    head += ["before, MB", "peak, MB"]
    for peer in peers:
        head += [f"{peer}: time", "ratio", "visited, stored", "peak, MB"]
    yield "| " + " | ".join(head) + " |"
    yield "|" + "|".join([" --- ", *([" ---: "] * (len(head) - 1))]) + "|"
    for row in rows:
        cells = [row.protocol.name, str(row.protocol.size), *_own(row.ours)]
        for peer in peers:
            cells += _beside(row.ours, row.searches[peer])
        yield "| " + " | ".join(cells) + " |"


def _own(ours: Searched) -> list[str]:
    counts = ours.counts
    assert counts is not None, "ours has no limit"
    return [
        grouped(counts.visited),
        grouped(counts.stored),
        grouped(counts.transitions),
        f"**{milliseconds(median(ours.seconds))}**",
        grouped(round(counts.transitions / median(ours.seconds))),
        f"{ours.kept / counts.stored:.0f}",
        f"{ours.before / 1e6:.0f}",
        f"{ours.peak / 1e6:.0f}",
    ]


def _beside(ours: Searched, peer: Searched) -> list[str]:
    if peer.given_up is not None:
        return [peer.given_up, "", "", ""]
    counts = peer.counts
    shown = ""
    if counts is not None:
        shown = (
            "the same" if counts == ours.counts else f"{grouped(counts.visited)}, {grouped(counts.stored)}"
        )
    seconds = median(peer.seconds)
    peak_shown = f"{peer.peak / 1e6:.0f}" if peer.peak else ""
    return [milliseconds(seconds), ratio(median(ours.seconds) / seconds), shown, peak_shown]


def networks_remarks(rows: Sequence[NetworkRow]) -> Iterator[str]:
    """How our rate compares, in words."""
    for peer in dict.fromkeys(name for row in rows for name in list(row.searches)[1:]):
        both = [row for row in rows if row.searches[peer].given_up is None]
        times = [median(row.ours.seconds) / median(row.searches[peer].seconds) for row in both]
        if times:
            same = sum(row.searches[peer].counts == row.ours.counts for row in both)
            yield (
                f"- {peer}: the same counts on {same} of {len(both)}; it takes {ratio(1 / max(times))} to "
                f"{ratio(1 / min(times))} times as long as we do."
            )


def _memory_of(protocol: Protocol) -> tuple[int, int, int]:
    before = peak()
    effort = _effort(protocol)
    return before, peak(), effort.bytes


if __name__ == "__main__":
    print(json.dumps(_memory_of(PROTOCOLS[sys.argv[1]](int(sys.argv[2])))))
