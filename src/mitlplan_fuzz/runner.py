"""Cases one after the other, in several processes at once.

Each process goes through its own seeds and says which it is about to try: so a crash of the native half, or a
case that never ends, is a finding with a seed as well. Ctrl-C is heard by the parent alone, which then ends
the others.
"""

from __future__ import annotations

import multiprocessing
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from mitlplan_fuzz.comparison import Verdict, verdict_on
from mitlplan_fuzz.missions import random_case

HANGS = 300.0
"""Seconds after which a case is taken to hang: the engine itself gives up after a few."""

BETWEEN_LOOKS = 0.5


@dataclass(frozen=True)
class Finding:
    """A case on which the voices differ."""

    seed: int
    sentences: tuple[str, ...]
    case: str


@dataclass
class Tally:
    """What has come of all cases so far."""

    done: int = 0
    findings: list[Finding] = field(default_factory=list)
    gave_up: list[int] = field(default_factory=list)
    votes: Counter[str] = field(default_factory=Counter)
    interrupted: bool = False


@dataclass
class _Worker:
    """A process, and what is known of it."""

    process: BaseProcess
    reports: Connection
    next_seed: int
    trying: int | None = None
    since: float = 0.0


def fuzz(
    first_seed: int,
    *,
    seconds: float | None,
    cases: int | None,
    jobs: int,
    found: Callable[[Finding], None],
    progress: Callable[[Tally], None],
) -> Tally:
    """Try cases until told to stop.

    Parameters
    ----------
    first_seed
        The cases are those of this seed and the following ones.
    seconds, cases
        When to stop; ``None`` is never.
    jobs
        How many processes.
    found
        Told of every finding, at once.
    progress
        Told how far it has got, a few times a second.

    Returns
    -------
    Tally
        What came of it, also if Ctrl-C put an end to it.
    """
    end = None if seconds is None else time.time() + seconds
    last = None if cases is None else first_seed + cases
    tally = Tally()
    workers = [_started(first_seed + number, jobs, last, end) for number in range(jobs)]
    try:
        while workers:
            for ready in wait([worker.reports for worker in workers], timeout=BETWEEN_LOOKS):
                worker = next(worker for worker in workers if worker.reports is ready)
                if not _heard(worker, tally, found):
                    workers.remove(worker)
                    again = _lost(worker, tally, found, jobs, last, end)
                    workers += [again] if again is not None else []
            for worker in workers:
                if worker.trying is not None and time.monotonic() - worker.since > HANGS:
                    worker.process.kill()
            progress(tally)
    except KeyboardInterrupt:
        tally.interrupted = True
    finally:
        for worker in workers:
            worker.process.kill()
            worker.process.join()
    return tally


def _started(seed: int, step: int, last: int | None, end: float | None) -> _Worker:
    # Forked threads would inherit locks; a fresh interpreter inherits nothing.
    context = multiprocessing.get_context("spawn")
    reports, own = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(own, seed, step, last, end), daemon=True)
    process.start()
    own.close()
    return _Worker(process, reports, seed)


def _work(reports: Connection, seed: int, step: int, last: int | None, end: float | None) -> None:
    """What a process does: every `step`-th seed, an announcement and a verdict each."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while (last is None or seed < last) and (end is None or time.time() < end):
        reports.send(seed)
        case = random_case(seed)
        try:
            verdict = verdict_on(case, seed=seed)
        except Exception:  # noqa: BLE001  (whatever goes wrong, the case is what one wants to see)
            verdict = Verdict([traceback.format_exc()])
        reports.send((verdict, str(case) if verdict.disagreements else ""))
        seed += step
    reports.send(None)


def _heard(worker: _Worker, tally: Tally, found: Callable[[Finding], None]) -> bool:
    """Take one report of a worker; ``False`` if it has ended."""
    try:
        report = worker.reports.recv()
    except EOFError:
        return False
    match report:
        case None:
            worker.trying = None
            worker.process.join()
            return False
        case int(seed):
            worker.trying, worker.since = seed, time.monotonic()
        case (Verdict() as verdict, str(case)):
            assert worker.trying is not None
            tally.done += 1
            tally.votes += verdict.votes
            if verdict.gave_up:
                tally.gave_up.append(worker.trying)
            if verdict.disagreements:
                _record(Finding(worker.trying, tuple(verdict.disagreements), case), tally, found)
            worker.trying = None
    return True


def _lost(
    worker: _Worker,
    tally: Tally,
    found: Callable[[Finding], None],
    jobs: int,
    last: int | None,
    end: float | None,
) -> _Worker | None:
    """If a worker died on a case, that is a finding, and another one goes on behind it."""
    worker.process.join()
    if worker.trying is None:
        return None
    tally.done += 1
    how = f"the process died with {worker.process.exitcode}, after {time.monotonic() - worker.since:.0f} s"
    _record(Finding(worker.trying, (how,), str(random_case(worker.trying))), tally, found)
    return _started(worker.trying + jobs, jobs, last, end)


def _record(finding: Finding, tally: Tally, found: Callable[[Finding], None]) -> None:
    tally.findings.append(finding)
    found(finding)
