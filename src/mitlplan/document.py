"""YAML and JSON files as plain data that remembers where everything stood.

Every scalar stays the text that was written, so that no number passes through a float; who needs a number
reads the text exactly. A file is untrusted: its size and depth are limited, keys must differ, and anchors,
aliases and tags, which YAML needs for its bombs, are refused. JSON is read by the fast standard parser, which
forgets places; only when an error needs one is the text read again as the YAML that it also is.
"""

from __future__ import annotations

import json
import pathlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    DocumentStartEvent,
    Event,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceStartEvent,
)
from ruamel.yaml.reader import ReaderError

from mitlplan.errors import MissionError

Path: TypeAlias = Sequence[str | int]
"""Keys and places from the root of a document to a value in it."""

_MOST_BYTES = {"JSON": 32 * 2**20, "YAML": 8 * 2**20}
_MOST_CHARACTERS_SEARCHED = 2 * 2**20
"""Places in JSON are found by reading it as YAML, which takes a second or more for a million characters."""

_MOST_VALUES = 1_000_000
_DEEPEST = 30
_TOO_MANY = f"the file holds too much; at most {_MOST_VALUES} values are read"
_SURROGATE = re.compile(r"\\(?:u|U0000)[dD][89a-fA-F]")


@dataclass(slots=True)
class _Node:
    """A value with its place; `keys` holds the places of a mapping's keys."""

    line: int
    column: int
    value: str | list[_Node] | dict[str, _Node]
    keys: dict[str, _Node] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong with the value under `path`, or with the key `key` there."""

    problem: str
    path: Path = ()
    key: str | None = None


@dataclass(frozen=True, slots=True)
class Document:
    """The data of a file, and how to find a place in it.

    Parameters
    ----------
    data
        Mappings, lists and texts; what was not read from a file may hold other values.
    file
        For messages; empty if there is none.
    text
        What to search for places; empty if there is none.
    """

    data: Any
    file: str = ""
    text: str = ""

    def error(self, *faults: Fault) -> MissionError:
        """The error for whichever of `faults` comes first in the file."""
        root = self._root()
        placed = [(_locate(root, fault), fault) for fault in faults]
        (line, column), fault = min(placed, key=lambda pair: pair[0])
        where = show_path(fault.path)
        return MissionError(
            f"{where}: {fault.problem}" if where else fault.problem,
            file=self.file,
            line=line or None,
            column=column or None,
        )

    def _root(self) -> _Node | None:
        if not 0 < len(self.text) <= _MOST_CHARACTERS_SEARCHED:
            return None
        try:
            return _tree(self.text, self.file)
        except MissionError:
            return None


def _locate(root: _Node | None, fault: Fault) -> tuple[int, int]:
    """Line and column from 1, as far as the path can be followed; zeros if there is no text."""
    if root is None:
        return 0, 0
    node = root
    for step in fault.path:
        match node.value, step:
            case dict() as entries, str() if step in entries:
                node = entries[step]
            case list() as items, int() if 0 <= step < len(items):
                node = items[step]
    if fault.key is not None:
        node = node.keys.get(fault.key, node)
    return node.line, node.column


def show_path(path: Path) -> str:
    """A path as people write it.

    Examples
    --------
    >>> show_path(["workspace", "grid", "blocked", 0])
    'workspace.grid.blocked[0]'
    """
    shown = ""
    for step in path:
        if isinstance(step, int):
            shown += f"[{step}]"
        else:
            shown += f".{step if step and step.isprintable() else repr(step)}"
    return shown.removeprefix(".")


def read_document(file: pathlib.Path, *, json_only: bool = False) -> Document:
    """Read a YAML file, or a JSON file if it is called ``.json`` or nothing else is expected.

    Raises
    ------
    MissionError
        If it cannot be read, with line and column.
    """
    kind = "JSON" if json_only or file.suffix == ".json" else "YAML"
    most = _MOST_BYTES[kind]
    try:
        with file.open("rb") as stream:
            content = stream.read(most + 1)
    except OSError as error:
        raise MissionError(f"cannot read it: {error.strerror}", file=str(file)) from None
    if len(content) > most:
        problem = f"the file is too large; at most {most >> 20} MB of {kind} are read"
        raise MissionError(problem, file=str(file))
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise MissionError("the file is no text in UTF-8", file=str(file), line=line) from None
    data = _json(text, str(file)) if kind == "JSON" else _plain(_tree(text, str(file)))
    if _SURROGATE.search(text):
        _refuse_halves(data, str(file))
    return Document(data, str(file), text)


def _refuse_halves(data: Any, file: str) -> None:
    """Refuse texts with half of a pair of surrogates, which are characters in no encoding."""
    pending = [data]
    while pending:
        match pending.pop():
            case dict() as entries:
                pending += [*entries, *entries.values()]
            case list() as items:
                pending += items
            case str() as text if any("\ud800" <= sign <= "\udfff" for sign in text):
                raise MissionError(f"the text {text!r} holds half of a character", file=file)


class _RepeatedKeyError(Exception):
    """A JSON object has this key twice."""


def _json(text: str, file: str) -> Any:
    # Every value but the first in its list or object has a comma before it.
    if text.count(",") + text.count("[") + text.count("{") > 2 * _MOST_VALUES:
        raise MissionError(_TOO_MANY, file=file)
    try:
        return json.loads(
            text, parse_int=str, parse_float=str, parse_constant=str, object_pairs_hook=_different_keys
        )
    except json.JSONDecodeError as error:
        raise MissionError(
            f"this is no JSON: {error.msg}", file=file, line=error.lineno, column=error.colno
        ) from None
    except RecursionError:
        raise MissionError(f"the file is nested too deep; {_DEEPEST} levels are read", file=file) from None
    except _RepeatedKeyError as repeated:
        if len(text) <= _MOST_CHARACTERS_SEARCHED:
            _tree(text, file)
        raise MissionError(f"the key '{repeated}' is given twice", file=file) from None


def _different_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise _RepeatedKeyError(key)
        found[key] = value
    return found


def _plain(node: _Node) -> Any:
    match node.value:
        case dict() as entries:
            return {key: _plain(value) for key, value in entries.items()}
        case list() as items:
            return [_plain(item) for item in items]
        case text:
            return text


def _tree(text: str, file: str) -> _Node:
    # Tabs may separate in JSON but not in every place of YAML; in neither do they move a column here.
    if file.endswith(".json"):
        text = text.replace("\t", " ")
    builder = _Builder(file)
    try:
        for event in YAML(typ="safe", pure=True).parse(text):
            builder.take(event)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise MissionError(
            f"this is no YAML: {error.problem or error.context}",
            file=file,
            line=mark.line + 1 if mark else None,
            column=mark.column + 1 if mark else None,
        ) from None
    except ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise MissionError(
            f"the character U+{ord(text[error.position]):04X} may not stand in YAML", file=file, line=line
        ) from None
    except (YAMLError, ValueError, OverflowError) as error:
        # The parser itself stumbles over an escape such as \U00110000.
        raise MissionError(f"this is no YAML: {error}", file=file) from None
    if builder.root is None:
        raise MissionError("the file is empty", file=file, line=1, column=1)
    return builder.root


class _Builder:
    """Grows the tree of nodes from the parser's events, without recursion."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.root: _Node | None = None
        self._open: list[_Node] = []
        self._count = 0
        self._keys: list[_Node | None] = []

    def take(self, event: Event) -> None:
        match event:
            case AliasEvent():
                raise self._fault("aliases (*name) are not read; write the value out", event)
            case DocumentStartEvent() if self.root is not None:
                raise self._fault("a second document begins here; a mission is one document", event)
            case NodeEvent():
                self._take_node(event)
            case CollectionEndEvent():
                self._open.pop()
                self._keys.pop()

    def _take_node(self, event: NodeEvent) -> None:
        if event.anchor is not None:
            raise self._fault("anchors (&name) are not read; write the value out where it is needed", event)
        tag = getattr(event, "tag", None)
        if tag is not None:
            raise self._fault("put this in quotes: YAML takes a text that begins with ! for a tag", event)
        self._count += 1
        if self._count > _MOST_VALUES:
            raise self._fault(_TOO_MANY, event)
        line, column = event.start_mark.line + 1, event.start_mark.column + 1
        match event:
            case ScalarEvent():
                self._place(_Node(line, column, event.value), event)
            case MappingStartEvent() | SequenceStartEvent():
                node = _Node(line, column, {} if isinstance(event, MappingStartEvent) else [])
                self._place(node, event)
                self._open.append(node)
                self._keys.append(None)
                if len(self._open) > _DEEPEST:
                    raise self._fault(f"the file is nested too deep; {_DEEPEST} levels are read", event)

    def _place(self, node: _Node, event: NodeEvent) -> None:
        if not self._open:
            self.root = node
            return
        parent = self._open[-1]
        match parent.value:
            case list() as items:
                items.append(node)
            case dict() as entries:
                key = self._keys[-1]
                if key is None:
                    self._keys[-1] = self._checked_key(node, parent, event)
                else:
                    assert isinstance(key.value, str)
                    entries[key.value] = node
                    parent.keys[key.value] = key
                    self._keys[-1] = None

    def _checked_key(self, node: _Node, parent: _Node, event: NodeEvent) -> _Node:
        if not isinstance(node.value, str):
            raise self._fault("a key must be a text", event)
        if node.value in parent.keys:
            first = parent.keys[node.value].line
            raise self._fault(f"the key {node.value!r} is given twice, first in line {first}", event)
        return node

    def _fault(self, problem: str, event: Event) -> MissionError:
        mark = event.start_mark
        return MissionError(problem, file=self.file, line=mark.line + 1, column=mark.column + 1)
