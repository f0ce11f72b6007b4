"""Pictures of automata: a graph in Graphviz's language becomes SVG."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from mitlplan.errors import ToolError


def draw_graph(dot: str) -> bytes:
    """The picture of a graph, as SVG.

    Parameters
    ----------
    dot
        The graph; if its nodes have places (``pos``) they are kept.

    Raises
    ------
    ToolError
        If Graphviz is not installed, or does not understand the graph.

    Examples
    --------
    >>> draw_graph('digraph { a -> b }').startswith(b"<?xml")
    True
    """
    try:
        pygraphviz: Any = import_module("pygraphviz")
    except ImportError:
        problem = "pictures of automata need Graphviz: pip install 'mitlplan[draw]'"
        raise ToolError(problem) from None
    try:
        graph = pygraphviz.AGraph(string=dot)
        drawn: bytes = graph.draw(format="svg", prog="neato" if ' pos="' in dot else "dot")
    except (ValueError, OSError, pygraphviz.DotError) as error:
        raise ToolError(f"Graphviz does not draw this graph: {error}") from None
    return drawn
