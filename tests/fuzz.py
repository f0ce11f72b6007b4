"""Random missions without end: ``python -m tests.fuzz --seconds 600 --seed 1000000``.

Goes through the seeds from the one given, compares engine, oracle and judge on each, and prints every
mission on which they differ. Stops after the seconds or missions given, or at Ctrl-C; exits with 1 if
anything was found.
"""

from __future__ import annotations

import argparse
import sys
import time
from itertools import count

from tests.comparison import disagreements
from tests.mission_strategies import random_mission

PROGRESS_EVERY = 5.0
FIRST_SEED = 1_000_000
"""Beyond the seeds of the ordinary tests."""


def main(arguments: list[str] | None = None) -> int:
    """Run until told to stop; the exit code says whether all agreed."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, default=None, help="stop after that long")
    parser.add_argument("--missions", type=int, default=None, help="stop after that many")
    parser.add_argument("--seed", type=int, default=FIRST_SEED, help="the first mission")
    options = parser.parse_args(arguments)
    begin = shown = time.monotonic()
    failures = done = 0
    try:
        for done, seed in enumerate(count(options.seed)):
            now = time.monotonic()
            if options.seconds is not None and now - begin >= options.seconds:
                break
            if options.missions is not None and done >= options.missions:
                break
            if now - shown >= PROGRESS_EVERY:
                shown = now
                pace = (now - begin) / done * 1000
                _say(f"{done} missions, {failures} failures, {pace:.0f} ms each, at seed {seed}")
            failures += _fails(seed)
    except KeyboardInterrupt:
        _say("interrupted")
    _say(f"{done} missions, {failures} failures")
    return 1 if failures else 0


def _fails(seed: int) -> bool:
    small = random_mission(seed)
    try:
        found = disagreements(small)
    except Exception as error:  # noqa: BLE001 - whatever goes wrong, the mission is what one wants to see
        found = [f"{type(error).__name__}: {error}"]
    if found:
        sys.stdout.write("\n".join([f"seed {seed}", *found, small.yaml(), ""]))
        sys.stdout.flush()
    return bool(found)


def _say(text: str) -> None:
    sys.stderr.write(text + "\n")


if __name__ == "__main__":
    sys.exit(main())
