from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.document import Document, Fault, read_document
from mitlplan.errors import MissionError


def write(folder: Path, content: str | bytes, name: str = "some.yaml") -> Path:
    file = folder / name
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return file


def test_every_scalar_stays_text(tmp_path: Path) -> None:
    text = "a: 0.1\nb: [1e400, yes, null, ~, 0x10, 2020-01-01, 1_000]\nc:\n'd': \"5\"\n"
    assert read_document(write(tmp_path, text)).data == {
        "a": "0.1",
        "b": ["1e400", "yes", "null", "~", "0x10", "2020-01-01", "1_000"],
        "c": "",
        "d": "5",
    }


def test_numbers_of_json_stay_text(tmp_path: Path) -> None:
    file = write(tmp_path, '{"a": 0.1, "b": [1e400, true, null, 123456789012345678901]}', "some.json")
    assert read_document(file).data == {"a": "0.1", "b": ["1e400", True, None, "123456789012345678901"]}


@pytest.mark.parametrize("name", ["some.yaml", "some.json"])
def test_places(tmp_path: Path, name: str) -> None:
    text = '{"a": {"b": [1,\n  {"c": "x"}]},\n "d": 2}'
    document = read_document(write(tmp_path, text, name))
    found = [
        document.error(Fault("wrong", ("a", "b", 1, "c"))),
        document.error(Fault("wrong", ("a", "b", 1), "c")),
        document.error(Fault("wrong", ("a", "b"))),
        document.error(Fault("wrong", ("a", "nowhere", 7))),
        document.error(Fault("wrong")),
    ]
    assert [(error.line, error.column) for error in found] == [(2, 9), (2, 4), (1, 13), (1, 7), (1, 1)]
    assert str(found[0]) == f"{tmp_path / name}:2:9: a.b[1].c: wrong"


def test_tabs_in_json_do_not_move_columns(tmp_path: Path) -> None:
    document = read_document(write(tmp_path, '{\n\t"a":\t[1,\t2]\n}', "some.json"))
    error = document.error(Fault("wrong", ("a", 1)))
    assert (error.line, error.column) == (2, 11)


def test_the_first_of_several_faults_is_told() -> None:
    document = Document({"a": "1", "b": "2"}, "m", "b: 2\na: 1\n")
    assert str(document.error(Fault("one", ("a",)), Fault("two", ("b",)))) == "m:1:4: b: two"


def test_without_a_file_there_is_no_place() -> None:
    assert str(Document({"a": 1}).error(Fault("wrong", ("a",)))) == "a: wrong"


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("", "1:1: the file is empty"),
        ("# only a comment\n", "1:1: the file is empty"),
        ("a: [1,\n", "2:1: this is no YAML: expected the node content, but found '<stream end>'"),
        ("a: 1\n\tb: 2", "2:1: this is no YAML: found character '\\t' that cannot start any token"),
        ("a: 1\na: 2\n", "2:1: the key 'a' is given twice, first in line 1"),
        ("a: &x 1\n", "1:4: anchors (&name) are not read; write the value out where it is needed"),
        ("a: *x\n", "1:4: aliases (*name) are not read; write the value out"),
        ("a: !A U B\n", "1:4: put this in quotes: YAML takes a text that begins with ! for a tag"),
        (
            "a: !!python/object:os.system x\n",
            "1:4: put this in quotes: YAML takes a text that begins with ! for a tag",
        ),
        ("a: 1\n---\nb: 2\n", "2:1: a second document begins here; a mission is one document"),
        ("? [a, b]\n: 1\n", "1:3: a key must be a text"),
        ("a: \x07\n", "1: the character U+0007 may not stand in YAML"),
        ("[" * 40 + "]" * 40, "1:31: the file is nested too deep; 30 levels are read"),
        (b"a: 1\nb: \xff\n", "2: the file is no text in UTF-8"),
    ],
)
def test_what_is_no_document(tmp_path: Path, content: str | bytes, problem: str) -> None:
    file = write(tmp_path, content)
    with pytest.raises(MissionError) as caught:
        read_document(file)
    assert str(caught.value) == f"{file}:{problem}"


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ('{"a": 1,\n "b" 2}', "2:6: this is no JSON: Expecting ':' delimiter"),
        ('{"a": 1, \n "a": 2}', "2:2: the key 'a' is given twice, first in line 1"),
        ("[" * 100_000, " the file is nested too deep; 30 levels are read"),
        ("a: 1", "1:1: this is no JSON: Expecting value"),
    ],
)
def test_what_is_no_json(tmp_path: Path, content: str, problem: str) -> None:
    file = write(tmp_path, content, "some.json")
    with pytest.raises(MissionError) as caught:
        read_document(file)
    assert str(caught.value) == f"{file}:{problem}"


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(MissionError) as caught:
        read_document(tmp_path / "nowhere.yaml")
    assert str(caught.value) == f"{tmp_path / 'nowhere.yaml'}: cannot read it: No such file or directory"


@pytest.mark.parametrize(("name", "most"), [("huge.yaml", "8 MB of YAML"), ("huge.json", "32 MB of JSON")])
def test_a_file_that_is_huge(tmp_path: Path, name: str, most: str) -> None:
    file = tmp_path / name
    with file.open("wb") as stream:
        stream.truncate(2**30)
    with pytest.raises(MissionError, match=f"the file is too large; at most {most} are read"):
        read_document(file)


@pytest.mark.parametrize("name", ["many.yaml", "many.json"])
def test_a_file_of_too_many_values(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mitlplan.document._MOST_VALUES", 10)
    with pytest.raises(MissionError, match="the file holds too much; at most 1000000 values are read"):
        read_document(write(tmp_path, f"[{', '.join(['1'] * 30)}]", name))


def test_places_are_not_sought_in_large_files(monkeypatch: pytest.MonkeyPatch) -> None:
    text = '{"a": "1"}'
    assert str(Document({"a": "1"}, "m", text).error(Fault("wrong", ("a",)))) == "m:1:7: a: wrong"
    monkeypatch.setattr("mitlplan.document._MOST_CHARACTERS_SEARCHED", 5)
    assert str(Document({"a": "1"}, "m", text).error(Fault("wrong", ("a",)))) == "m: a: wrong"


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path: Path) -> None:
    assert read_document(write(tmp_path, b"\xef\xbb\xbfa: 1\n")).data == {"a": "1"}


_PLAIN = st.recursive(
    st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text("abc", max_size=3), inner, max_size=4)
    ),
    max_leaves=20,
)


@given(_PLAIN)
def test_json_is_yaml(tmp_path_factory: pytest.TempPathFactory, data: object) -> None:
    """The places of JSON are found by reading it as YAML, so both readings must agree."""
    folder = tmp_path_factory.mktemp("both")
    text = json.dumps(data)
    assert read_document(write(folder, text)).data == data
    assert read_document(write(folder, text, "some.json")).data == data


@given(st.text(max_size=60) | st.text("ab:- \n[]{},'\"!&*#|>?%@\t", max_size=60))
def test_any_text_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    file = write(tmp_path_factory.mktemp("any"), text.encode("utf-8", "surrogatepass"))
    try:
        read_document(file)
    except MissionError as error:
        assert str(error).startswith(str(file))  # noqa: PT017  # any text may also be right
