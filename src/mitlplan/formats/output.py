"""Files that are written whole or not at all.

A reader never sees half a file, and an error leaves what was there before: the content goes to a file beside,
which takes the place of the other at the end.
"""

from __future__ import annotations

import os
from pathlib import Path

from mitlplan.errors import OutputError


def check_writable(file: Path) -> None:
    """Refuse a place that cannot be written to, before any work is done for it.

    Raises
    ------
    OutputError
        If its folder is missing or it is a folder itself.
    """
    if file.is_dir():
        raise OutputError(f"cannot write {file}: it is a folder")
    if not file.parent.is_dir():
        raise OutputError(f"cannot write {file}: there is no folder {file.parent}")


def write_whole(file: Path, content: str | bytes) -> None:
    """Write `content` to `file`, text as UTF-8, or leave everything as it was.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    check_writable(file)
    # The target of a link is replaced, not the link; what is no file, such as a pipe, can only be written to.
    file = file.resolve()
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        if file.exists() and not file.is_file():
            file.write_bytes(data)
        else:
            _replace(file, data)
    except OSError as error:
        raise OutputError(f"cannot write {file}: {error.strerror}") from None


def _replace(file: Path, data: bytes) -> None:
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        beside.write_bytes(data)
        beside.replace(file)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
