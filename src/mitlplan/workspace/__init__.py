"""The robot's world: cells, moves between them, and the propositions that hold in each cell."""

from mitlplan.workspace.graph import Move, graph
from mitlplan.workspace.grid import grid
from mitlplan.workspace.movingai import movingai
from mitlplan.workspace.regions import Box
from mitlplan.workspace.workspace import UNLIMITED, Workspace

__all__ = ["UNLIMITED", "Box", "Move", "Workspace", "graph", "grid", "movingai"]
