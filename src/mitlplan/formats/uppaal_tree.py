"""The XML of a model as a plain tree that knows its lines.

The file is untrusted: entities are refused, nothing is fetched, and size and depth are limited.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any
from xml.sax import SAXException
from xml.sax.handler import ContentHandler, feature_external_ges

from mitlplan.errors import ModelError
from mitlplan.formats.uppaal_syntax import Place

MOST_BYTES = 64 * 2**20
MOST_ELEMENTS = 1_000_000
MOST_LEVELS = 12


@dataclass(slots=True)
class Node:
    """An element: `text_line` is where its text begins."""

    name: str
    attributes: Mapping[str, str]
    line: int
    children: list[Node] = field(default_factory=list)
    text: str = ""
    text_line: int = 0

    def all(self, name: str) -> list[Node]:
        """The children called `name`."""
        return [child for child in self.children if child.name == name]

    def first(self, name: str) -> Node | None:
        """The first child called `name`."""
        return next((child for child in self.children if child.name == name), None)


class _Builder(ContentHandler):
    def __init__(self, file: str) -> None:
        super().__init__()
        self._file = file
        self._locator: Any = None
        self.root = Node("", {}, 0)
        self._open = [self.root]
        self._texts: list[list[str]] = [[]]
        self._count = 0

    def setDocumentLocator(self, locator: Any) -> None:  # noqa: N802  (the name that SAX calls)
        self._locator = locator

    def _line(self) -> int:
        return int(self._locator.getLineNumber() or 0)

    def startElement(self, name: str, attrs: Any) -> None:  # noqa: N802
        self._count += 1
        if self._count > MOST_ELEMENTS or len(self._open) > MOST_LEVELS:
            problem = "the model is too large or too deep to be read"
            raise ModelError(problem, file=self._file, line=self._line())
        node = Node(name, dict(attrs.items()), self._line())
        self._open[-1].children.append(node)
        self._open.append(node)
        self._texts.append([])

    def endElement(self, name: str) -> None:  # noqa: N802
        del name
        node = self._open.pop()
        node.text = "".join(self._texts.pop())

    def characters(self, content: str) -> None:
        if not self._texts[-1]:
            self._open[-1].text_line = self._line()
        self._texts[-1].append(content)


def parse_xml(text: bytes, file: str) -> Node:
    """The element ``nta`` of a model.

    Raises
    ------
    ModelError
        If the text is no XML, no model, or too large.
    """
    from defusedxml.common import DefusedXmlException
    from defusedxml.expatreader import DefusedExpatParser

    if len(text) > MOST_BYTES:
        raise ModelError(f"the file has more than {MOST_BYTES // 2**20} MB, which is not read", file=file)
    builder = _Builder(file)
    # All at once: expat begins anew on a word of the XML that goes on in the next piece of the file.
    # Every UPPAAL file names its DTD. It is not fetched, and declarations of entities are refused.
    parser = DefusedExpatParser(bufsize=len(text) + 1, forbid_external=False)
    parser.setFeature(feature_external_ges, False)
    parser.setContentHandler(builder)
    try:
        parser.parse(BytesIO(text))
    except DefusedXmlException:
        raise ModelError("entities are not read", file=file) from None
    except SAXException as error:
        line = getattr(error, "getLineNumber", lambda: None)()
        raise ModelError(f"this is no XML: {error.getMessage()}", file=file, line=line) from None
    except (ValueError, LookupError) as error:
        raise ModelError(f"this is no XML: {error}", file=file) from None
    root = builder.root.first("nta")
    if root is None:
        raise ModelError("this is no UPPAAL model: the outermost element is not nta", file=file)
    return root


def place_of(node: Node, element: str, file: str) -> Place:
    """Where the text of `node` stands."""
    return Place(file, node.text_line or node.line, element)
