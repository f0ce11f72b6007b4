"""Files that are written whole or not at all.

A reader never sees half a file, and an error leaves what was there before: the text goes to a file beside,
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


def write_whole(file: Path, text: str) -> None:
    """Write `text` to `file`, or leave everything as it was.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    check_writable(file)
    # The target of a link is replaced, not the link; what is no file, such as a pipe, can only be written to.
    file = file.resolve()
    try:
        if file.exists() and not file.is_file():
            file.write_text(text, encoding="utf-8")
        else:
            _replace(file, text)
    except OSError as error:
        raise OutputError(f"cannot write {file}: {error.strerror}") from None


def _replace(file: Path, text: str) -> None:
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        beside.write_text(text, encoding="utf-8")
        beside.replace(file)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
