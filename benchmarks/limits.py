"""Measures whether limits are kept: of time, of memory, and of patience after Ctrl-C.

    python -m benchmarks.limits [--seconds 3] [--megabytes 200] [--interrupts 4] [--seed 1] [MISSION]...

Starts the command line as a user does, on missions each of which is heavy in another stage. A row tells how
long the command ran, in parts of its time limit; how much more memory it took than a command with nothing to
do, in parts of its memory limit; and how long it took to end after Ctrl-C at a random moment, at worst.
Moments are drawn from the first line of ours on: before that Python starts, and hears Ctrl-C in its own way.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.families import ROOT

SEED = 1
PATIENCE = 60.0
"""Seconds after which a command is killed, and its row says so."""


def _grid(size: int, spec: Any, count: int, *, waiting: bool = False, **more: Any) -> dict[str, Any]:
    """A mission on a square grid with `count` regions g0, g1, ... of a cell each."""
    cells = [[row, column] for row in range(size) for column in range(size)] if size <= 300 else []
    random.Random(SEED).shuffle(cells)
    chosen = cells[:count] or [[size - 1, size - 1], [0, size - 1], [size // 2, size // 2]]
    regions = {f"g{number}": [cell] for number, cell in enumerate(chosen)}
    grid = {"rows": size, "columns": size, "waiting": waiting, "regions": regions, **more}
    return {"mitlplan": 1, "workspace": {"grid": grid}, "robot": {"start": "r0c0"}, "spec": spec}


def _nested(levels: int) -> str:
    formula = "g0"
    for level in range(1, levels + 1):
        formula = f"G[1,{level + 2}] (F[{level},{level + 3}] {formula} | g{level % 4})"
    return formula


def missions() -> Mapping[str, dict[str, Any]]:
    """By the stage that is heavy."""
    wide = " & ".join(
        f"(F[0,{i}] (g{i % 10} | g{(i * 3 + 1) % 10})) | G[{i},{2 * i + 1}] g{(i + 2) % 10}"
        for i in range(1, 600)
    )
    promises = {f"r{i}": f"G F[0,{20 + i}] g{i}" for i in range(6)}
    responses = {f"q{i}": f"G(g{i} -> F[2,{9 + i}] g{i + 1})" for i in range(5)}
    return {
        "reading": _grid(2000, "F (g0 & F[0,5000] g1) & G !g2", 3),
        "formula": _grid(6, wide, 10),
        "translation": _grid(4, _nested(8), 4),
        "tables": _grid(
            6, " & ".join(f"G(g{i % 10} -> F[{i},{2 * i + 3}] g{i * 7 % 10})" for i in range(1, 200)), 10
        ),
        "search": _grid(20, " & ".join(f"F (g{k} & F[2,30] g{(k + 1) % 12})" for k in range(12)), 12),
        "successors": _grid(
            20, " & ".join(f"G[0,200] (g{k} -> F[10,25] g{k + 1})" for k in range(7)) + " & F g0", 8
        ),
        "zone graph": _grid(
            20, " & ".join(f"G (g{k} -> F[3,60] g{(k + 1) % 4})" for k in range(4)) + " & G F g0", 4
        ),
        "walks": _grid(4, "G F[0,30] g0 & G F[0,35] g1 & G (g0 -> F[3,30] g2)", 4, move_time=[1, "5/2"]),
        "waiting walks": _grid(
            4, "G F[0,30] g0 & G F[0,35] g1 & G (g0 -> F[3/2,30] g2) & F G[0,7/3] !g1", 4, waiting=True
        ),
        "tour": _grid(200, " & ".join(f"G F[0,{1000 + 7 * i}] g{i}" for i in range(6)), 6, waiting=True),
        "slack": _grid(300, " & ".join(f"F[0,2000] g{i}" for i in range(12)), 12, waiting=True),
        "slack of a loop": _grid(
            100, " & ".join(f"G F[0,{900 + 7 * i}] g{i}" for i in range(5)), 5, waiting=True
        ),
        "conflict": _grid(8, promises | responses, 8, waiting=True),
    }


COMMANDS = {
    "satisfiable": [
        "satisfiable",
        " & ".join(f"G(a{i} -> F[1,{i + 2}] a{i + 1})" for i in range(11)) + " & F a0",
    ],
    "equivalent": [
        "equivalent",
        " & ".join(f"G(a{i} -> F[1,{i + 2}] a{i + 1})" for i in range(4)),
        " & ".join(f"G(a{i} -> F[1,{i + 2}] a{i + 1})" for i in range(3)),
    ],
}
"""Formulas to be decided, which need no mission file."""


@dataclass(frozen=True, slots=True)
class Ended:
    """How a command ended.

    Parameters
    ----------
    code, seconds, said
        Its exit code, its duration or the time from the signal on, and the last line on stderr.
    megabytes
        The most memory it held.
    interrupted
        Whether it got the signal before it ended by itself.
    """

    code: int
    seconds: float
    megabytes: float
    said: str
    interrupted: bool


def ended(command: Sequence[str], interrupt_after: float | None = None) -> Ended:
    """Run `mitlplan` to its end, or to Ctrl-C so many seconds after its first line."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        begin = time.monotonic()
        process = subprocess.Popen(  # noqa: S603  # what is measured
            [sys.executable, "-m", "mitlplan", *command], stdout=output, stderr=errors
        )
        most, since, first_line = 0.0, begin, None
        interrupted = False
        while process.poll() is None:
            most = max(most, _peak(process.pid))
            now = time.monotonic()
            if first_line is None and _listens(process.pid):
                first_line = now
            if interrupt_after is not None and first_line is not None and now - first_line >= interrupt_after:
                process.send_signal(signal.SIGINT)
                since, interrupt_after, interrupted = now, None, True
            if now - begin > PATIENCE:
                process.kill()
            time.sleep(0.005)
        seconds = time.monotonic() - since
        errors.seek(0)
        lines = errors.read().decode(errors="replace").strip().splitlines()
        return Ended(process.returncode, seconds, most, lines[-1] if lines else "", interrupted)


def _listens(pid: int) -> bool:
    """Whether a process catches SIGTERM, which Python by itself does not."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    except OSError:
        return False
    caught = re.search(r"SigCgt:\s+([0-9a-f]+)", status)
    return caught is not None and bool(int(caught[1], 16) >> (signal.SIGTERM - 1) & 1)


def _peak(pid: int) -> float:
    """The high-water mark of a process's resident memory, in megabytes."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    except OSError:
        return 0.0
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    return int(found[1]) * 1024 / 1e6 if found else 0.0


def main() -> None:
    """Print a row for each mission."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--megabytes", type=int, default=200)
    parser.add_argument("--interrupts", type=int, default=4)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("names", nargs="*", metavar="MISSION")
    asked = parser.parse_args()
    # A shell turns Ctrl-C off for what it starts in the background, and programs hand that on.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as folder:
        commands = dict(_commands(Path(folder)))
        commands = {name: command for name, command in commands.items() if name in (asked.names or commands)}
        idle = ended(["satisfiable", "F a"])
        print(f"nothing to do: {idle.seconds:.2f} s, {idle.megabytes:.0f} MB")
        print(f"{'mission':16} {'time':>16} {'memory':>16}   Ctrl-C, at worst")
        chance = random.Random(asked.seed)
        for name, command in commands.items():
            timed = ended([*command, "--time-limit", str(asked.seconds)])
            held = ended([*command, "--memory-limit", str(asked.megabytes), "--time-limit", "20"])
            stops = [
                ended(command, chance.uniform(0, 6 if count % 2 else 1)) for count in range(asked.interrupts)
            ]
            stops = [one for one in stops if one.interrupted]
            worst = max((one.seconds for one in stops), default=0.0)
            growth = held.megabytes - idle.megabytes
            print(
                f"{name:16} {timed.seconds / asked.seconds:8.2f} exit {timed.code:3}"
                f" {growth / asked.megabytes:8.2f} exit {held.code:3}"
                f" {worst:8.2f} s exit {sorted({one.code for one in stops})}",
                flush=True,
            )
            for one in (timed, held, *stops):
                if one.code not in (0, 1, 3, 130):
                    print(f"  exit {one.code}: {one.said}")


def _commands(folder: Path) -> Iterator[tuple[str, list[str]]]:
    for name, mission in missions().items():
        file = folder / f"{name}.json"
        file.write_text(json.dumps(mission), encoding="utf-8")
        yield name, ["plan", str(file)]
    yield from COMMANDS.items()
    yield "examples", ["plan", str(ROOT / "examples" / "patrol-berlin.yaml")]


if __name__ == "__main__":
    main()
