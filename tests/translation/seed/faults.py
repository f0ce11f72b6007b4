"""Every fault of the published construction, with what it accepts or misses and what is true.

What the published construction does is found by an explicit simulation of its networks, tick by tick
(:mod:`tests.oracles.published_reach`), or by executing one run; what is true is said by the judge
(:mod:`mitlplan.logic.semantics`) and by the planner. The rows make the table of docs/paper.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from mitlplan import paper
from mitlplan.automata.chart import chart, labels
from mitlplan.automata.iota import Iota, along_map
from mitlplan.automata.timed_automaton import Automaton, Edge, Location, Network, Urgency, ticks_per_second
from mitlplan.automata.trace import Trace, execute
from mitlplan.errors import TranslationError
from mitlplan.logic.formula import Formula, Not
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.mission import mission_for
from mitlplan.models import model_of_mission
from mitlplan.plan import Plan
from mitlplan.planner import plan
from mitlplan.translation.seed.published import published_automaton
from mitlplan.translation.seed.published_network import PublishedModel, published_model
from mitlplan.translation.seed.published_transducers import Flavour, generator, timed_eventually
from mitlplan.workspace import Move, Workspace, graph
from mitlplan.workspace.abstract import abstract
from tests.oracles.published_reach import reach

LATEST = Fraction(14)
ONE = Fraction(1)


@dataclass(frozen=True)
class Fault:
    """A row of the table."""

    number: int
    fault: str
    example: str
    published: str
    truth: str


def line(*cells: str, closed: bool = False) -> Workspace:
    """Cells in a row, joined both ways (or one way round), each with its propositions."""
    names = [f"c{index}" for index in range(len(cells))]
    moves = [Move(one, other, 1, both=not closed) for one, other in pairwise(names)]
    if closed:
        moves.append(Move(names[-1], names[0], 1))
    return graph({name: cell.split() for name, cell in zip(names, cells, strict=True)}, moves)


def model(text: str, workspace: Workspace, flavour: Flavour = Flavour.PAPER) -> PublishedModel:
    return published_model(parse(text), abstract(workspace, 0), names=list(workspace.names), flavour=flavour)


def hurried(network: Network) -> Network:
    """Fault 1 repaired: no time passes before the generator begins."""

    def changed(automaton: Automaton) -> Automaton:
        locations = (replace(at, urgency=Urgency.URGENT) if at.stopped else at for at in automaton.locations)
        return replace(automaton, locations=tuple(locations))

    return replace(network, automata=tuple(changed(automaton) for automaton in network.automata))


@dataclass(frozen=True)
class Accepted:
    """The fastest run that the published construction accepts."""

    time: Fraction
    stays: tuple[tuple[str, Fraction], ...]
    workspace: Workspace

    def __str__(self) -> str:
        return f"accepts at {self.time}: " + " ".join(f"{at} {cell}" for cell, at in self.stays)

    def signal(self) -> Signal:
        holds = dict(
            zip(
                self.workspace.names, map(self.workspace.holds, range(len(self.workspace.names))), strict=True
            )
        )
        segments = tuple(Segment(at, holds[cell]) for cell, at in self.stays)
        return Signal(segments, self.time)


def accepted(
    text: str, workspace: Workspace, flavour: Flavour = Flavour.PAPER, *, hurry: bool = False
) -> Accepted | None:
    """The fastest run accepted, or ``None``."""
    published = model(text, workspace, flavour)
    network = hurried(published.network) if hurry else published.network
    found = reach(network, published.query, latest=LATEST)
    if found is None:
        return None
    stays = [(workspace.names[0], Fraction(0))]
    for time, move in found.trace:
        for place, index in move:
            cell = published.cells[network.automata[0].edges[index].target] if place == 0 else None
            if cell is not None and time > 0:
                stays.append((workspace.names[cell], time))
    return Accepted(found.time, tuple(stays), workspace)


def shown(found: Accepted | None) -> str:
    return f"accepts nothing up to {LATEST}" if found is None else str(found)


def verdict(text: str, found: Accepted | None) -> str:
    """What the judge says of the run: whatever follows it."""
    assert found is not None
    formula: Formula = parse(text)
    if satisfies(Not(formula), found.signal()):
        return "the judge: violated, whatever follows"
    return "the judge: satisfied" if satisfies(formula, found.signal()) else "the judge: undecided"


def truth(text: str, workspace: Workspace) -> str:
    """What the planner says."""
    mission = mission_for(workspace, text, start=workspace.names[0], propositions=("A", "B"))
    outcome = plan(mission)
    if isinstance(outcome, Plan):
        return f"least makespan {outcome.makespan}: {outcome}"
    return "infeasible"


def every_fault() -> list[Fault]:
    """All rows, in the order of the list that they come from; 14 is new."""
    return [
        _frozen_clocks(),
        _stale_clocks(),
        _forgotten_reset(),
        _strict_gap(),
        _long_first_stretch(),
        _acceptance_not_necessary(),
        _acceptance_not_sufficient(),
        _dropped_promise(),
        _simultaneous_promises(),
        _constant_promise(),
        _truncated_bounds(),
        _long_delay(),
        _mixture(),
        _steps_with_moves_only(),
        _restarts(),
    ]


def _frozen_clocks() -> Fault:
    text, workspace = "G F[0,2] A", line("", "B", "", "A")
    found = accepted(text, workspace)
    return Fault(
        1,
        "nothing forces the run to leave Gen0, and all clocks stand still there: every deadline is void",
        f"`{text}`, pos0 to pos3 in a row: the direct move to A is gone, A is 3 s away",
        shown(found),
        f"{verdict(text, found)}; {truth(text, workspace)}",
    )


def _stale_clocks() -> Fault:
    text = "G F[0,2] A"
    found = accepted(text, paper.workspace(), hurry=True)
    return Fault(
        2,
        "clocks that were not yet reset bound the checker: with a = 0 no stay of positive length is left",
        f"`{text}` on the paper's map, Gen0 left at once (fault 1 repaired)",
        shown(found),
        truth(text, paper.workspace()),
    )


def _forgotten_reset() -> Fault:
    text = "F[2,4] A"
    found = accepted(text, paper.workspace(), Flavour.PROGRAM)
    other = accepted(text, paper.workspace())
    return Fault(
        3,
        "the program forgets to reset z when the checker begins with a gap",
        f"`{text}` on the paper's map",
        f"the program {shown(found)}; the paper's version {shown(other)}",
        truth(text, paper.workspace()),
    )


def _strict_gap() -> Fault:
    """A checker alone, with the generator's clocks at rest, round a triangle: A is missed for exactly 2 s."""
    workspace = line("", "A", "", closed=True)
    problems = {flavour: _gap(workspace, flavour) for flavour in Flavour}
    return Fault(
        4,
        "a gap must be shorter than b-a, where [a,b] allows b-a",
        "the checker of `F[0,2] A` round a triangle with A on [1,2) and [4,5)",
        f"the paper's version: {problems[Flavour.PAPER]}; "
        f"the program: {problems[Flavour.PROGRAM] or 'executed'}",
        truth("G F[0,2] A", workspace),
    )


def _gap(workspace: Workspace, flavour: Flavour) -> str | None:
    automaton = published_automaton(parse("F[0,2] A"), flavour=flavour)
    (checker,) = automaton.checkers
    cells = chart(abstract(workspace, 0), list(workspace.names), clock="m")
    product = along_map(cells, labels(abstract(workspace, 0)), checker)
    stopped = frozenset(automaton.main.clocks)
    locations = tuple(replace(at, stopped=stopped) for at in product.locations)
    names = [location.name.split(" x ")[-1] for location in locations]
    edges = tuple(Edge(edge.source, edge.target, edge.guard, edge.resets) for edge in product.edges)
    start = next(
        index for index, part in enumerate(product.parts) if part[0] == 0 and names[index] == "CHK01"
    )
    network = Network((Automaton("checker", locations, edges, start),), (*checker.clocks, "m"))
    moves, at = [], start
    for cell, name in ((1, "CHK_2"), (2, "CHK_3"), (0, "CHK_3"), (1, "CHK_2")):
        index = next(
            index
            for index, edge in enumerate(edges)
            if edge.source == at and product.parts[edge.target][0] == cell and names[edge.target] == name
        )
        moves.append(((0, index),))
        at = edges[index].target
    problem = execute(network, Trace(tuple(moves), tuple(ONE * time for time in range(1, 5))))
    return problem and problem.replace(locations[edges[moves[2][0][1]].target].name, "CHK_3")


def _long_first_stretch() -> Fault:
    """A generator alone: the truth of F[1,3] A, where A holds on [0,2), is [0,1)."""
    problems = {}
    for flavour in Flavour:
        operator = timed_eventually(ONE, 3 * ONE, iter([f"x{index}" for index in range(9)]))
        guess = generator(operator, flavour)
        problems[flavour] = execute(
            _alone(guess),
            Trace((_edge(guess, "Gen0", "Gen_2"), _edge(guess, "Gen_2", "Gen_3")), (0 * ONE, ONE)),
        )
    return Fault(
        5,
        "the program asks that the first true stretch of the guess, too, last b-a",
        "the generator of `F[1,3] A` where A holds on [0,2): the truth is [0,1)",
        f"the program: {problems[Flavour.PROGRAM]}; the paper's version: "
        f"{problems[Flavour.PAPER] or 'executed'}",
        "true from 0, false from 1 on",
    )


def _alone(iota: Iota) -> Network:
    locations = tuple(Location(at.name, at.invariant, at.stopped) for at in iota.locations)
    edges = tuple(Edge(each.source, each.target, each.guard, each.resets) for each in iota.edges)
    (start,) = iota.initial
    return Network((Automaton("generator", locations, edges, start),), iota.clocks)


def _edge(iota: Iota, source: str, target: str) -> tuple[tuple[int, int], ...]:
    names = [location.name for location in iota.locations]
    for index, edge in enumerate(iota.edges):
        if (names[edge.source], names[edge.target]) == (source, target):
            return ((0, index),)
    raise KeyError((source, target))


def _acceptance_not_necessary() -> Fault:
    text = "F[0,4] A & F[0,4] B"
    return Fault(
        6,
        "accepting needs a verified falling edge: a plan may not end in A",
        f"`{text}` on the paper's map (phi3)",
        shown(accepted(text, paper.workspace())),
        truth(text, paper.workspace()),
    )


def _acceptance_not_sufficient() -> Fault:
    text = "F[0,2] A & F[0,2] B"
    found = accepted(text, paper.workspace())
    return Fault(
        6,
        "... and the edges that were verified say nothing of the deadline",
        f"`{text}`, the bounds of the published model of phi3",
        shown(found),
        f"{verdict(text, found)}; {truth(text, paper.workspace())}",
    )


def _dropped_promise() -> Fault:
    text, workspace = "F(A & F B)", line("", "A")
    found = accepted(text, workspace)
    return Fault(
        7,
        "F = (F1 & F2) | F3: the promises of the operands are dropped",
        f"`{text}` where B is nowhere",
        shown(found),
        truth(text, workspace),
    )


def _simultaneous_promises() -> Fault:
    text, workspace = "A & F B", line("A", "B")
    return Fault(
        7,
        "... atoms are never in a Büchi set, so a conjunction with one is never accepted",
        f"`{text}`, A here and B one move away",
        shown(accepted(text, workspace)),
        truth(text, workspace),
    )


def _constant_promise() -> Fault:
    text, workspace = "G F A", graph({"c0": ["A"], "c1": []}, [Move("c0", "c1", 1), Move("c1", "c1", 1)])
    found = accepted(text, workspace)
    return Fault(
        7,
        "... and one visit to a Büchi location counts as infinitely many",
        f"`{text}` where A cannot be visited again",
        shown(found),
        truth(text, workspace),
    )


def _truncated_bounds() -> Fault:
    text = "F[0.5,1.5] A"
    ours = model_of_mission(mission_for(paper.workspace(), text, start="pos0"), "seed")
    return Fault(
        9,
        "bounds are truncated to integers: [0.5,1.5] becomes [0,1]",
        f"`{text}` on the paper's map",
        f"ours has {ticks_per_second(ours.network)} time units a second, and bounds 1 and 3",
        truth(text, paper.workspace()),
    )


def _long_delay() -> Fault:
    size = published_automaton(parse("F[4,5] A")).size
    return Fault(
        10,
        "names are compared by their beginnings and kept in 40 bytes: the program crashes from m = 5 on",
        "`F[4,5] A`, m = 6",
        f"ours, to the same letter, has {size[0]} locations and {size[1]} edges",
        "no fault of the idea",
    )


def _mixture() -> Fault:
    text = "F[0,2] A & F B"
    try:
        model(text, paper.workspace())
    except TranslationError as error:
        said = str(error).partition(";")[0]
    return Fault(
        11,
        "a timed and an untimed part in one formula make the program crash",
        f"`{text}` on the paper's map",
        f"ours refuses: {said}",
        truth(text, paper.workspace()),
    )


def _steps_with_moves_only() -> Fault:
    published = model("G F[0,2] A", paper.workspace())
    system = published.network.automata[0]
    staying = [edge for edge in system.edges if published.cells[edge.source] == published.cells[edge.target]]
    return Fault(
        12,
        "the checker steps only when the robot moves: a window that ends during a stay is missed",
        "the product of phi2 with the paper's map",
        f"{len(staying)} of its {len(system.edges)} edges leave the robot in its cell",
        "silent steps are needed",
    )


def _restarts() -> Fault:
    text, workspace = "F[2,4] A", line("", "", "", "", "", "", "A")
    found = accepted(text, workspace, hurry=True)
    return Fault(
        14,
        "the paper's generator may go round in no time, so clocks start again whenever it likes",
        f"`{text}`, A 6 s away, Gen0 left at once (fault 1 repaired)",
        shown(found),
        f"{verdict(text, found)}; {truth(text, workspace)}",
    )


def table() -> str:
    """The rows as a table in Markdown."""
    lines = ["| # | fault | example | as published | what is true |", "|---|---|---|---|---|"]
    for row in every_fault():
        cells = (str(row.number), row.fault, row.example, row.published, row.truth)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)
