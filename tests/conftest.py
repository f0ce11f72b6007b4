"""What all tests share: how many random cases, and that Ctrl-C is heard.

The profile `test` draws the same cases every time, so a red run is red for everyone; `mutants` draws the
first few of them, for tests that are run again and again (tests/mutants.py); `fuzz` draws new ones. Ctrl-C
is heard even where the tests run in the background, whose shell has it ignored: some tests press it.
"""

from __future__ import annotations

import signal
import threading

from hypothesis import HealthCheck, settings

collect_ignore = ["mutants.py"]
"""No tests but a program, whose packages are not installed with those of the tests."""

settings.register_profile(
    "test",
    max_examples=100,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("mutants", settings.get_profile("test"), max_examples=15)
settings.register_profile(
    "fuzz", max_examples=20_000, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("test")

if (
    threading.current_thread() is threading.main_thread()
    and signal.getsignal(signal.SIGINT) is signal.SIG_IGN
):
    signal.signal(signal.SIGINT, signal.default_int_handler)
