"""The page docs/performance.md: tables of what was measured, and in words where the planner is slower."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from fractions import Fraction
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median

from benchmarks.contest import Row, Times
from benchmarks.families import ROOT
from benchmarks.memory import Memory

STAGES = ("translate", "search", "loops", "check", "conflict")
LIBRARIES = ("numpy", "scipy", "rustworkx", "ortools", "python-sat", "z3-solver")

INTRODUCTION = """\
# Performance

Written by `make bench`; do not edit.

- {commit}, {date}
- command: `{command}`
- machine: {machine}; load average {load} when it began

The machine is shared and noisy: every number is the median of up to {rounds} runs in which all
contestants took turns, and a ratio compares only what ran in turns.

All times are milliseconds.

- **plan**: from the mission in memory to the checked plan, or to the proof that there is none. Not
  counted: the start of the process and reading the file. Its parts: *translate* (formula and map to
  tables), *search*, *loops* (looking for looping plans), *check* (the independent judge),
  *conflict* (which requirements exclude each other), *other* (exact times, slack, the plan itself).
- **least makespan**: in seconds; "none below b" where that is all that has been shown.
- **states**: zones that the search stored.
- **peers**: on a product made by hand for this one mission, cells times the progress of the
  formula, as `benchmarks/product.py` writes it down; "to build + to search". Whoever made it has
  found out by thinking what the planner finds out by itself (which deadlines need no counters, that
  all moves take 1); a peer computes no slack and checks nothing: it is the limit. Breadth-first
  search is possible since all moves are 1 and a product has no other weights.
- **ratio**: our *plan* to all that the peer does; behind the bar our *search* to its search. Above
  1 we are slower.
"""


@dataclass(frozen=True)
class Section:
    """A family, measured."""

    family: str
    title: str
    rows: Sequence[Row]


EXPLANATIONS = {
    "examples": """\
The mission files of `examples`. *warehouse x 1000/7* is the warehouse mission with every time
multiplied by 1000/7: planned in turns with the warehouse itself, it took {slower} times as long.
The product of warehouse and rescue has two layers of cells, before and after
the goods; whoever made it has proved that the age of the goods need not be counted.""",
    "paper": """\
No waiting, moves of 1, start top left, B top right, A bottom left. The intervals grow with the
grid; with n = 2 they are the paper's own: phi1 = `(!A U B) & F A`; phi3 = `F[0,4(n-1)] A &
F[0,4(n-1)] B`; phi4 = `F[2(n-1),4(n-1)] A & F[0,2(n-1)] B`; phi2 = `G F[0,max(2,n)] A`, a loop. The
least makespan of phi1, phi3 and phi4 must be 3(n-1): {shown} missions, every n from 2 to 64, were
planned and it was. Two products for phi4: the better one knows that moves can be undone, so that
only parity matters; the other counts moves up to the window.""",
    "goals": """\
`F[0,T] g1 & ... & F[0,T] gk`, the goals drawn at random, no waiting; T a tenth above the optimum,
or 1 below it. The subset DP, CP-SAT and HiGHS are given the distances between the goals (scipy,
counted) and find the shortest walk: they know that nothing else matters.""",
    "responses": """\
`F goal & G(p1 -> F[0,2n] q1) & ...` up to the end of the mission (horizon: finite), no waiting;
each p is a whole row of the grid, each q a cell at random. The product counts the age of each
demand.""",
    "large": """\
`(!A U B) & F[0,h] A & G !fire`, horizon: finite, no waiting; A, B and fire are boxes of 1 % of the
map each. Maps of 1024 x 1024 are tiles of smaller ones.""",
}


MEMORY = """\
## Memory

Each mission in a process of its own: the most memory it held (resident set) with Python, the libraries and
the map loaded, and when the plan was made. What the search keeps for its states (zones, steps, queue, hash
table, as it counts them for `--memory-limit`) is that of its last moment, with the room it has reserved, so
that few states seem large.

"""


def memory_table(memory: Sequence[tuple[str, Memory]]) -> Iterator[str]:
    """A table of Markdown."""
    yield "| mission | before, MB | peak, MB | states | bytes a state |"
    yield "| --- | ---: | ---: | ---: | ---: |"
    for name, one in memory:
        each = f"{one.stored / one.states:.0f}" if one.states else ""
        states = grouped(one.states) if one.states else ""
        yield f"| {name} | {one.before / 1e6:.0f} | {one.peak / 1e6:.0f} | {states} | {each} |"


def write(
    file: Path,
    sections: Sequence[Section],
    *,
    command: str,
    rounds: int,
    load: Sequence[float],
    facts: Mapping[str, str],
    memory: Sequence[tuple[str, Memory]] = (),
    parts: Sequence[str] = (),
) -> None:
    """Writes the page; `facts` are what the explanations of the sections leave open, `parts` end it."""
    page = [
        INTRODUCTION.format(
            commit=commit(),
            date=datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
            command=command,
            machine=machine(),
            rounds=rounds,
            load=", ".join(f"{one:.1f}" for one in load),
        )
    ]
    for section in sections:
        text = EXPLANATIONS[section.family].format(**facts)
        page.append(f"## {section.title}\n\n{text}\n\n" + "\n".join(table(section.rows)) + "\n")
        page.append("\n".join(remarks(section)) + "\n")
    if memory:
        page.append(MEMORY + "\n".join(memory_table(memory)) + "\n")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join([*page, *parts]), encoding="utf-8")


def commit() -> str:
    """The commit that was measured."""

    def git(*arguments: str) -> str:
        done = subprocess.run(  # noqa: S603 (nobody's input)
            ["git", *arguments],  # noqa: S607 (whichever git the user has)
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        return done.stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", "src", "native", "benchmarks")
    return f"Commit {git('rev-parse', '--short=12', 'HEAD') or 'unknown'}" + (
        " with changes" if changed else ""
    )


def machine() -> str:
    """Processor, cores, memory, versions."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [
            line.split(":")[1].strip() for line in cpuinfo.read_text().splitlines() if "model name" in line
        ]
        model = names[0] if names else model
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    versions = []
    for library in LIBRARIES:
        try:
            versions.append(f"{library} {version(library)}")
        except PackageNotFoundError:
            versions.append(f"no {library}")
    return (
        f"{model}, {os.cpu_count()} cores, {memory:.0f} GB, {platform.system()}, "
        f"Python {platform.python_version()}, {', '.join(versions)}"
    )


def milliseconds(value: float) -> str:
    """Three digits, or all before the point."""
    shown = value * 1000
    return f"{shown:.{0 if shown >= 100 else 1 if shown >= 10 else 2}f}"


def ratio(value: float) -> str:
    """Two digits, or all before the point."""
    return f"{value:.{0 if value >= 10 else 1 if value >= 1 else 2}f}"


def grouped(number: int) -> str:
    """Thousands apart."""
    return f"{number:,}".replace(",", " ")


def table(rows: Sequence[Row]) -> Iterator[str]:
    """A table of Markdown, the peers of all rows side by side."""
    peers = list(dict.fromkeys(name for row in rows for name in list(row.times)[1:]))
    seen = {stage for row in rows for stages in row.ours.stages for stage in stages}
    stages = [stage for stage in STAGES if stage in seen]
    head = ["mission", "size", "least makespan", "states", *stages, "other", "**plan**"]
    for peer in peers:
        head += [peer, "ratio"]
    yield "| " + " | ".join(head) + " |"
    yield "|" + "|".join([" --- "] * 3 + [" ---: "] * (len(head) - 3)) + "|"
    for row in rows:
        cells = [row.instance.name, row.instance.size, _makespan(row), *_own(row.ours, stages)]
        for peer in peers:
            cells += _beside(row.ours, row.times.get(peer))
        yield "| " + " | ".join(cells) + " |"


def _makespan(row: Row) -> str:
    if isinstance(row.answer, Fraction) and row.answer.denominator > 1:
        return f"{row.answer} = {float(row.answer):.1f}"
    return f"{row.answer} (none below {row.ours.bound})" if _unproved(row) else str(row.answer)


def _unproved(row: Row) -> bool:
    bound = row.ours.bound
    return isinstance(row.answer, Fraction) and bound is not None and bound < row.answer


def _own(times: Times, stages: Sequence[str]) -> list[str]:
    states = grouped(times.states) if times.states else ""
    if times.given_up is not None:
        return [states, *([""] * (len(stages) + 1)), times.given_up]
    parts = [times.stage(stage) for stage in stages]
    parts.append(max(0.0, times.total - sum(parts)))
    return [
        states,
        *(milliseconds(part) if part else "" for part in parts),
        f"**{milliseconds(times.total)}**",
    ]


PREPARED = 1e-5
"""Seconds below which nothing was prepared."""


def _beside(ours: Times, peer: Times | None) -> list[str]:
    if peer is None:
        return ["", ""]
    if peer.given_up is not None:
        return [peer.given_up, ""]
    build, search = median(peer.prepare), median(peer.solve)
    shown = milliseconds(search) if build < PREPARED else f"{milliseconds(build)} + {milliseconds(search)}"
    if ours.given_up is not None:
        return [shown, ""]
    against = ratio(ours.total / peer.total)
    if build >= PREPARED:
        against += f" \\| {ratio(ours.stage('search') / search)}"
    return [shown, against]


def remarks(section: Section) -> Iterator[str]:
    """Where we are slower and faster, in words."""
    held = [row for row in section.rows if row.ours.given_up is None]
    for name in dict.fromkeys(name for row in held for name in list(row.times)[1:]):
        both = [row for row in held if name in row.times and row.times[name].given_up is None]
        if both:
            yield f"- {name}: {_compared(both, name)}."
    open_ends = [_called(row) for row in held if _unproved(row)]
    if open_ends:
        yield f"- Not shown to be least: {', '.join(open_ends)}."
    for row in section.rows:
        if row.ours.given_up is not None and not row.ours.given_up.startswith("not tried"):
            yield f"- **No answer** to {_called(row)}: {row.ours.given_up}."


def _called(row: Row) -> str:
    return f"{row.instance.name} {row.instance.size}".strip()


def _compared(rows: Sequence[Row], name: str) -> str:
    whole = [(row.ours.total / row.times[name].total, row) for row in rows]
    parts = [_slower(whole)]
    built = [row for row in rows if median(row.times[name].prepare) >= PREPARED]
    if built:
        searches = [(row.ours.stage("search") / median(row.times[name].solve), row) for row in built]
        parts.append(f"search to search {_slower(searches)}")
    return "; ".join(parts)


def _slower(ratios: Sequence[tuple[float, Row]]) -> str:
    slower = sum(one > 1 for one, _ in ratios)
    if slower == 0:
        best, row = min(ratios, key=lambda one: one[0])
        return f"faster on all {len(ratios)}, at best {ratio(1 / best)} times ({_called(row)})"
    worst, row = max(ratios, key=lambda one: one[0])
    return f"**slower** on {slower} of {len(ratios)}, at worst {ratio(worst)} times ({_called(row)})"
