"""Pages do what they say: their Python and their commands work, and what is cited is there."""

from __future__ import annotations

import contextlib
import doctest
import io
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mitlplan.cli import app
from mitlplan.mission import read

ROOT = Path(__file__).parents[1]
PAGES = (
    ROOT / "README.md",
    ROOT / "ARCHITECTURE.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")),
)
SOURCES = sorted(
    file
    for folder in ("src", "tests", "native")
    for file in (ROOT / folder).rglob("*")
    if file.suffix in {".py", ".cpp", ".hpp"}
)


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(
        rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def each_block(language: str) -> list[object]:
    return [
        pytest.param(block, id=f"{page.name}-{number}")
        for page in PAGES
        for number, block in enumerate(blocks(page, language))
    ]


@pytest.mark.parametrize("block", each_block("python"))
def test_python_prints_what_its_comments_say(block: str) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block, "page", "exec"), {})  # noqa: S102  # the page is ours
    promised = re.findall(r"print\(.*\)\s+# (.*?)(?:   .*)?$", block, re.MULTILINE)
    assert promised
    assert printed.getvalue().splitlines() == promised


@pytest.mark.parametrize("block", each_block("pycon"))
def test_what_is_typed_answers_as_shown(block: str) -> None:
    test = doctest.DocTestParser().get_doctest(block, {}, "page", None, None)
    report: list[str] = []
    assert doctest.DocTestRunner().run(test, out=report.append).failed == 0, "".join(report)


@pytest.mark.parametrize("block", each_block("yaml"))
def test_missions_are_missions(block: str, tmp_path: Path) -> None:
    file = tmp_path / "mission.yaml"
    file.write_text(block, encoding="utf-8")
    assert read(file).spec


def test_the_commands_of_the_readme_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = ROOT / "README.md"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mission.yaml").write_text(blocks(page, "yaml")[0], encoding="utf-8")
    commands = re.findall(r"^    mitlplan (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert {command.split()[0] for command in commands} == {"plan", "check", "draw", "satisfiable"}
    for command in commands:
        result = CliRunner().invoke(app, shlex.split(command, comments=True))
        assert (result.exit_code, result.stderr) == (0, ""), command


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"(?<!\w)\[[^\]]+\]\((?!https?:)([^)#]*)\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


def cited() -> Iterator[tuple[str, int | None, str]]:
    """Each page that a source cites, with the section if one is named, and where."""
    for source in SOURCES:
        text = re.sub(r"\s+", " ", source.read_text(encoding="utf-8"))
        where = str(source.relative_to(ROOT))
        for page, sections in re.findall(r"docs: (\w+)(?:, sections? ([\d, and]+))?", text):
            numbers = re.findall(r"\d+", sections)
            for number in numbers or [None]:
                yield page, None if number is None else int(number), where
        for page in re.findall(r"docs/(\w+)\.md", text):
            yield page, None, where


def test_what_the_sources_cite_is_there() -> None:
    found = list(cited())
    assert {page for page, _, _ in found} >= {"semantics", "translation", "interface", "paper"}
    for page, section, where in found:
        file = ROOT / "docs" / f"{page}.md"
        if page == "performance" and not file.exists():
            continue  # written by make bench
        assert file.exists(), where
        if section is not None:
            assert re.search(rf"^## {section}\. ", file.read_text(encoding="utf-8"), re.MULTILINE), where
