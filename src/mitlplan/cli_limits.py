"""What holds a command to its limits of time and memory, in every stage of it.

A search looks at its limits itself, and says how far it got. Reading, translating and judging do not; for
them an alarm raises :class:`~mitlplan.errors.OutOfTime` a little later, and a bound on the memory of the
process turns what is too much into MemoryError. Where neither is heard, because a library computes, the
native half has the last word.

The bound counts the private memory that the process asks for (RLIMIT_DATA), beyond what it held when the work
began: libraries are not the user's mission. Without a limit it is what the machine has to give, so that too
large a mission ends with a sentence and not by the hand of the kernel.
"""

from __future__ import annotations

import os
import re
import resource
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from mitlplan.cli_signals import last_word, listens
from mitlplan.errors import OutOfTime

if TYPE_CHECKING:
    from types import FrameType

    from mitlplan.search.fastest import Limits

LIMIT = 3
"""The exit code of a command that a limit stopped."""

LATE = 0.03
"""After what part of the time limit more the alarm rings: searches look at the clock themselves."""

TOO_LATE = 0.04
"""After what part more the process ends, whatever it does. A tenth in all is promised."""

LEAST = 0.05
"""Seconds that each of these takes at least."""

LONGEST_START = 60.0
"""Seconds after which nobody believes any more that Python has only just started."""

Answer = TypeVar("Answer")


def began() -> float:
    """When this command was started, by :func:`time.monotonic`: Python's own start is part of a program."""
    now = time.monotonic()
    if not listens():
        return now
    try:
        started = int(_read("/proc/self/stat").rpartition(")")[2].split()[19])
        age = time.clock_gettime(time.CLOCK_BOOTTIME) - started / os.sysconf("SC_CLK_TCK")
    except (OSError, IndexError, ValueError):
        return now - time.process_time()
    return now - (age if started and 0 <= age < LONGEST_START else time.process_time())


def held_to(limits: Limits, work: Callable[[], Answer], otherwise: Callable[[str], Answer]) -> Answer:
    """What `work` answers, or what is to be said when a limit stops it, made from the reason.

    Parameters
    ----------
    limits
        Those of `work`, which keeps them itself where it can.

    Raises
    ------
    MemoryError
        Where there is no limit of memory but that of the machine.
    """
    if not listens():
        return work()
    if limits.megabytes is not None:
        # A loop may need it when no room is left, and an import then says anything but that.
        import scipy.optimize  # noqa: F401
    try:
        with _alarm(limits), room(limits.megabytes):
            return work()
    except OutOfTime:
        reason = limits.out_of_time
    except (MemoryError, SystemError):  # the second is what Python makes of the first now and then
        if limits.megabytes is None:
            raise
        reason = limits.out_of_memory
    # Only here is everything free that the work held.
    return otherwise(reason)


@contextmanager
def _alarm(limits: Limits) -> Iterator[None]:
    remaining = limits.remaining()
    if limits.seconds is None or remaining is None:
        yield
        return
    patience = max(TOO_LATE * limits.seconds, LEAST)
    word = last_word([(signal.SIGALRM, patience, LIMIT, f"mitlplan: {limits.out_of_time}")])
    signal.signal(signal.SIGALRM, _ring)
    signal.setitimer(signal.ITIMER_REAL, max(remaining + max(LATE * limits.seconds, LEAST), LEAST))
    try:
        yield
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_IGN)
        signal.setitimer(signal.ITIMER_REAL, 0)
    # Who has an answer may take the time to write it. That there is none, the last word may say as well.
    word.answered()


def _ring(_number: int, _frame: FrameType | None) -> None:
    raise OutOfTime


@contextmanager
def room(megabytes: int | None) -> Iterator[None]:
    """Within, the process gets no more memory than this, or than there is, beyond what it holds."""
    free = megabytes * 1_000_000 if megabytes is not None else _free()
    if not listens() or free is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    held = _kilobytes("/proc/self/status", "VmData")
    wanted = held + free if soft == resource.RLIM_INFINITY else min(held + free, soft)
    resource.setrlimit(resource.RLIMIT_DATA, (wanted, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _free() -> int | None:
    """The bytes that the machine, or the container, has to give; ``None`` if it does not say."""
    try:
        machine = sum(_kilobytes("/proc/meminfo", name) for name in ("MemAvailable", "SwapFree"))
    except (OSError, ValueError):
        return None
    try:
        group = Path("/sys/fs/cgroup", _read("/proc/self/cgroup").rpartition("0::/")[2].strip())
        cached = re.search(r"^inactive_file (\d+)", _read(group / "memory.stat"), re.MULTILINE)
        used = int(_read(group / "memory.current")) - int(cached[1] if cached else 0)
        return max(0, min(machine, int(_read(group / "memory.max")) - used))
    except (OSError, ValueError):
        return machine  # no container, or one without a limit


def _kilobytes(file: str, name: str) -> int:
    """What a line such as ``VmData:  120 kB`` tells, in bytes."""
    found = re.search(rf"^{name}:\s+(\d+) kB", _read(file), re.MULTILINE)
    if found is None:
        raise ValueError(f"{file} does not tell {name}")
    return int(found[1]) * 1024


def _read(file: str | Path) -> str:
    return Path(file).read_text(encoding="ascii", errors="replace")
