"""The paper's Table I by its own construction, the repaired and the compact one, into docs/paper.md.

    python -m benchmarks.paper_table [--output FILE]

The formulas stand on n x n grids with B top right, A bottom left and the robot top left; a move takes 1 s and
there is no waiting. Time intervals grow with the map: 4 becomes 4 (n-1), 2 becomes 2 (n-1), and phi2 is
`G F[0,n] A`; with n = 2 these are the paper's. The published models are searched by `reach` in the form
without stopped clocks, which has the same runs. A search has a minute; ours is the whole plan, judged.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

from mitlplan.logic.formula import Formula
from mitlplan.logic.parse import parse
from mitlplan.mission import mission_for
from mitlplan.models import lockstep_of
from mitlplan.planner import plan
from mitlplan.search.fastest import Limits, Stopped
from mitlplan.search.reach import Reached, reach
from mitlplan.search.tables import tabulate
from mitlplan.translation.seed.published_network import PublishedModel, published_model
from mitlplan.translation.seed.published_thaw import without_stopped_clocks
from mitlplan.workspace import Workspace, grid
from mitlplan.workspace.abstract import abstract
from tests.translation.seed.faults import table as faults_table

PAGE = Path(__file__).resolve().parents[1] / "docs" / "paper.md"
SIZES = (2, 4, 8)
SECONDS = 60.0
"""For one search."""

PAPER_TRANSITIONS = {
    ("phi1", 2): 22,
    ("phi1", 4): 181,
    ("phi1", 8): 886,
    ("phi2", 2): 69,
    ("phi2", 8): 1795,
    ("phi3", 2): 532,
    ("phi4", 2): 681,
}
"""Of the paper's Table I, as far as they are known to us; phi2 with A inside the grid."""

Result = TypeVar("Result")


@dataclass(frozen=True)
class Measured:
    """One construction on one mission: seconds of translation and of search, size, least makespan."""

    translation: float
    size: str
    search: float | None
    makespan: str

    def cells(self) -> tuple[str, str, str, str]:
        """As cells of the table."""
        search = f"over {SECONDS:g}" if self.search is None else f"{self.search:.3f}"
        return f"{self.translation:.3f}", self.size, search, self.makespan


def timed(work: Callable[[], Result]) -> tuple[Result, float]:
    """The result of `work`, and the seconds it took."""
    begin = time.perf_counter()
    result = work()
    return result, time.perf_counter() - begin


def corners(size: int) -> Workspace:
    """The grid with A and B in corners."""
    return grid(size, size, regions={"A": [[size - 1, 0]], "B": [[0, size - 1]]})


def text(name: str, size: int) -> str:
    """The formula, its intervals grown with the map."""
    half, whole = 2 * (size - 1), 4 * (size - 1)
    return {
        "phi1": "(!A U B) & F A",
        "phi2": f"G F[0,{size}] A",
        "phi3": f"F[0,{whole}] A & F[0,{whole}] B",
        "phi4": f"F[{half},{whole}] A & F[0,{half}] B",
    }[name]


def published(name: str, size: int) -> Measured:
    """The published construction."""
    formula: Formula = parse(text(name, size))
    chart = abstract(corners(size), 0)

    def build() -> PublishedModel:
        return published_model(formula, chart)

    model, seconds = timed(build)
    thawed = without_stopped_clocks(model)
    answer, search = timed(lambda: reach(thawed.network, thawed.query, Limits(seconds=SECONDS)))
    match answer:
        case Reached(trace, bound=bound) if bound == trace.least:
            return Measured(seconds, str(model.counted[1]), search, str(bound))
        case Reached(trace, bound=bound):
            return Measured(seconds, str(model.counted[1]), None, f"{bound} to {trace.least}")
        case Stopped():
            return Measured(seconds, str(model.counted[1]), None, "not found")
        case _:
            return Measured(seconds, str(model.counted[1]), search, "none")


def ours(name: str, size: int, construction: Literal["seed", "compact"]) -> Measured:
    """The repaired or the compact construction."""
    mission = mission_for(corners(size), text(name, size), start="r0c0")
    _, seconds = timed(lambda: tabulate(lockstep_of(mission, construction)))
    network = lockstep_of(mission, construction)
    edges = len(network.map.source) + sum(len(each.edges) for each in network.transducers)
    outcome, search = timed(lambda: plan(mission, construction=construction, time_limit=SECONDS))
    return Measured(seconds, str(edges), search, str(getattr(outcome, "makespan", "none")))


def first_table() -> str:
    """Table I in Markdown."""
    head = ["formula", "map", "the paper's transitions"]
    for construction in ("published", "repaired", "compact"):
        head += [f"{construction}: translation, s", "edges", "synthesis, s", "least makespan"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name in ("phi1", "phi2", "phi3", "phi4"):
        for size in SIZES:
            row = [f"`{text(name, size)}`", f"{size}x{size}", str(PAPER_TRANSITIONS.get((name, size), ""))]
            for measured in (published(name, size), ours(name, size, "seed"), ours(name, size, "compact")):
                row += measured.cells()
            lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines)


def between(page: str, name: str, block: str) -> str:
    """The page with a new block between its marks."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n{block}\n{end}{after}"


def main() -> None:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(description="The paper's Table I and the table of faults.")
    parser.add_argument("--output", type=Path, default=PAGE)
    output: Path = parser.parse_args().output
    page = PAGE.read_text(encoding="utf-8")
    page = between(page, "faults", faults_table())
    page = between(page, "table I", first_table())
    output.write_text(page, encoding="utf-8")
    print(f"written: {output}")


if __name__ == "__main__":
    main()
