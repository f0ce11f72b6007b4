"""Robot plans that meet their deadlines.

    import mitlplan as mp
    workspace = mp.grid(rows=2, columns=2, regions={"A": [(1, 0)], "B": [(0, 1)]})
    print(mp.plan(workspace, "(!A U B) & F A", start="r0c0"))

The names below are the whole public interface (docs: interface). Each is looked up when it is first used, so
that importing the package costs nothing and ``mitlplan --help`` answers at once.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mitlplan.check import check
    from mitlplan.errors import FormulaError, MissionError, MitlplanError, WorkspaceError
    from mitlplan.logic.formula import Formula
    from mitlplan.logic.parse import parse
    from mitlplan.logic.show import show
    from mitlplan.mission import Mission, mission_for, read, schema
    from mitlplan.plan import Infeasible, LimitReached, Loop, Plan, Step
    from mitlplan.planner import Satisfiable, Unsatisfiable, equivalent, plan, satisfiable, valid
    from mitlplan.workspace import Box, Move, Workspace, graph, grid, movingai

    __version__: str

_HOMES = {
    "check": ("check",),
    "errors": ("FormulaError", "MissionError", "MitlplanError", "WorkspaceError"),
    "logic.formula": ("Formula",),
    "logic.parse": ("parse",),
    "logic.show": ("show",),
    "mission": ("Mission", "mission_for", "read", "schema"),
    "plan": ("Infeasible", "LimitReached", "Loop", "Plan", "Step"),
    "planner": ("Satisfiable", "Unsatisfiable", "equivalent", "plan", "satisfiable", "valid"),
    "workspace": ("Box", "Move", "Workspace", "graph", "grid", "movingai"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Box",
    "Formula",
    "FormulaError",
    "Infeasible",
    "LimitReached",
    "Loop",
    "Mission",
    "MissionError",
    "MitlplanError",
    "Move",
    "Plan",
    "Satisfiable",
    "Step",
    "Unsatisfiable",
    "Workspace",
    "WorkspaceError",
    "__version__",
    "check",
    "equivalent",
    "graph",
    "grid",
    "mission_for",
    "movingai",
    "parse",
    "plan",
    "read",
    "satisfiable",
    "schema",
    "show",
    "valid",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("mitlplan")
        except PackageNotFoundError:
            return "0+uninstalled"
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mitlplan' has no attribute {name!r}")
    found: object = getattr(import_module(f"mitlplan.{_HOME_OF[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return __all__


class _Package(ModuleType):
    """The package, in which a submodule never takes the place of the function called after it.

    ``mitlplan.plan`` and ``mitlplan.check`` are modules as well as functions. Importing a module binds it in
    its package; here the function stays, and ``from mitlplan.plan import Step`` works all the same.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOME_OF and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
