"""What all tests share: how many random cases, and which native module.

The profile `test` draws the same cases every time, so a red run is red for everyone; `fuzz` draws new ones.
MITLPLAN_NATIVE names the folder of another build of the native module, the one with sanitizers.
Ctrl-C is heard even where the tests run in the background, whose shell has it ignored: some tests press it.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import sys
import threading
from pathlib import Path

from hypothesis import HealthCheck, settings

settings.register_profile(
    "test",
    max_examples=100,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "fuzz", max_examples=20_000, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("test")

if (
    threading.current_thread() is threading.main_thread()
    and signal.getsignal(signal.SIGINT) is signal.SIG_IGN
):
    signal.signal(signal.SIGINT, signal.default_int_handler)


def _take_native_module_from(folder: Path) -> None:
    (file,) = folder.glob("_core*.so")
    specification = importlib.util.spec_from_file_location("mitlplan._core", file)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["mitlplan._core"] = module
    specification.loader.exec_module(module)


if "MITLPLAN_NATIVE" in os.environ:
    _take_native_module_from(Path(os.environ["MITLPLAN_NATIVE"]))
