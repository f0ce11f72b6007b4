"""Networks are measured beside the tools that are there, and whoever is wrong ends the benchmark."""

from __future__ import annotations

import stat
import sys
from pathlib import Path

import pytest

from benchmarks import networks
from benchmarks.contest import OURS, WrongAnswerError
from benchmarks.memory import said
from benchmarks.networks import NetworkRow, networks_part, races

TCHECKER = """\
import os, sys
assert sys.argv[1:5] in (["-a", "covreach", "-s", "bfs"], ["-a", "aLU-covreach", "-s", "bfs"])
assert "\\nsystem:" in open(sys.argv[5]).read()
print("COVERED_STATES 1\\nMEMORY_MAX_RSS 9000\\nREACHABLE", {reachable!r})
print("RUNNING_TIME_SECONDS 0.5\\nSTORED_STATES", 65 if "covreach" in sys.argv else 60)
print("VISITED_STATES 71\\nVISITED_TRANSITIONS", {transitions})
"""


def program(folder: Path, name: str, text: str) -> None:
    file = folder / name
    file.write_text(f"#!{sys.executable}\n{text}")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)


def raced(monkeypatch: pytest.MonkeyPatch, folder: Path) -> NetworkRow:
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    (row,) = races([("fischer", 3)], rounds=2, budget=60)
    return row


def test_a_row_has_our_search_and_the_tools_that_are_there(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    program(tmp_path, "tck-reach", TCHECKER.format(reachable="false", transitions=126))
    program(tmp_path, "verifyta", "print(' -- Formula is NOT satisfied.')")
    row = raced(monkeypatch, tmp_path)
    assert list(row.searches) == [OURS, "tck-reach covreach", "tck-reach aLU-covreach", "verifyta"]
    assert row.ours.counts == networks.Counts(71, 65, 126) == row.searches["tck-reach covreach"].counts
    assert row.searches["tck-reach covreach"].seconds == [0.5, 0.5]
    assert 0 < row.ours.kept < row.ours.peak
    assert row.ours.before <= row.ours.peak
    page = networks_part([row], 1.1).splitlines()
    head, _, line = (each for each in page if each.startswith("|"))
    assert head.count("|") == line.count("|")
    assert line.startswith("| Fischer | 3 | 71 | 65 | 126 | **")
    assert line.count("the same") == 1
    assert "71, 60" in line
    assert any(each.startswith("- tck-reach aLU-covreach: the same counts on 0 of 1;") for each in page)


def test_who_reaches_what_cannot_be_reached_is_wrong(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program(tmp_path, "tck-reach", TCHECKER.format(reachable="true", transitions=126))
    with pytest.raises(WrongAnswerError, match="Fischer 3: .* says COVERED_STATES"):
        raced(monkeypatch, tmp_path)


def test_who_counts_otherwise_every_time_is_wrong(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program(tmp_path, "tck-reach", TCHECKER.format(reachable="false", transitions="os.getpid()"))
    with pytest.raises(WrongAnswerError, match="counts"):
        raced(monkeypatch, tmp_path)


def test_who_takes_too_long_gives_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program(tmp_path, "tck-reach", "import time\ntime.sleep(30)")
    monkeypatch.setattr(networks, "LIMIT", 0.2)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    first, second = races([("fischer", 2), ("fischer", 3)], rounds=1, budget=60)
    assert first.searches["tck-reach covreach"].given_up == "over 0.2 s"
    assert second.searches["tck-reach covreach"].given_up == "not tried: over 0.2 s"
    assert "| over 0.2 s |  |  |  |" in networks_part([first], 1.1)


def test_the_peak_of_memory_is_that_of_the_program_alone() -> None:
    """Whatever this process holds, a program that was started by it holds no part of that."""
    held = bytearray(300_000_000)
    held[::4096] = b"1" * len(held[::4096])
    own = "import resource; print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    assert int(said([sys.executable, "-c", own])) * 1024 < 200_000_000
