from __future__ import annotations

import os
from pathlib import Path

import pytest

from mitlplan.errors import OutputError
from mitlplan.formats.output import check_writable, write_whole


def test_a_file_is_made_and_replaced(tmp_path: Path) -> None:
    file = tmp_path / "plan.json"
    write_whole(file, "one")
    write_whole(file, "two")
    assert file.read_text(encoding="utf-8") == "two"
    assert list(tmp_path.iterdir()) == [file]


def test_bytes_are_written_as_they_are(tmp_path: Path) -> None:
    file = tmp_path / "plan.png"
    write_whole(file, b"\x89PNG\r\n\xff")
    assert file.read_bytes() == b"\x89PNG\r\n\xff"
    assert list(tmp_path.iterdir()) == [file]


def test_what_was_there_stays_if_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "plan.json"
    file.write_text("one", encoding="utf-8")

    def no_space(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", no_space)
    with pytest.raises(OutputError) as caught:
        write_whole(file, "two")
    assert str(caught.value) == f"cannot write {file}: No space left on device"
    assert file.read_text(encoding="utf-8") == "one"
    assert list(tmp_path.iterdir()) == [file]


def test_an_interrupt_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "plan.json", "two")
    assert list(tmp_path.iterdir()) == []


def test_the_target_of_a_link_is_replaced(tmp_path: Path) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("one", encoding="utf-8")
    link.symlink_to(target)
    write_whole(link, "two")
    assert link.is_symlink()
    assert target.read_text(encoding="utf-8") == "two"


def test_what_is_no_file_is_written_to() -> None:
    write_whole(Path(os.devnull), "two")
    assert not Path(os.devnull).is_file()


def test_places_that_cannot_be_written_to(tmp_path: Path) -> None:
    with pytest.raises(OutputError) as caught:
        check_writable(tmp_path)
    assert str(caught.value) == f"cannot write {tmp_path}: it is a folder"
    with pytest.raises(OutputError) as caught:
        check_writable(tmp_path / "no" / "plan.json")
    assert str(caught.value) == (
        f"cannot write {tmp_path / 'no' / 'plan.json'}: there is no folder {tmp_path / 'no'}"
    )
