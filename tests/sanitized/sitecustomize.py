"""Another build of the native module for every interpreter that is started with this folder on its path.

Python imports a module of this name by itself when it starts. MITLPLAN_NATIVE names the folder of the build:
the tests run under sanitizers in this way, and so do the programs that they start.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType


class _OtherBuild(MetaPathFinder):
    """Finds the native module, and nothing else, in the folder of the other build."""

    def __init__(self, folder: str) -> None:
        (self.file,) = Path(folder).absolute().glob("_core*.so")

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        del path, target
        return spec_from_file_location(fullname, self.file) if fullname == "mitlplan._core" else None


if "MITLPLAN_NATIVE" in os.environ:
    sys.meta_path.insert(0, _OtherBuild(os.environ["MITLPLAN_NATIVE"]))
