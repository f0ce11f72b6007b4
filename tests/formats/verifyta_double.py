"""A program that answers as UPPAAL's verifier does, in either spelling, with our own search inside.

It is given the model as a file and knows nothing else of the mission: what it prints has to be found in the
network again, edge by edge, though the states that it passes through and its delays are not told.
"""

from __future__ import annotations

import stat
import sys
from collections.abc import Iterator
from pathlib import Path

from mitlplan.automata.timed_automaton import Network
from mitlplan.automata.trace import Move
from mitlplan.formats.uppaal import bounds, comparison, update
from mitlplan.formats.uppaal_query import read_query
from mitlplan.formats.uppaal_read import read_uppaal
from mitlplan.search.reach import Reached, reach

ROOT = Path(__file__).resolve().parents[2]
SPELLINGS = ("old", "new")


def verifier(folder: Path, spelling: str) -> Path:
    """The program, in `folder`."""
    program = folder / "verifyta"
    program.write_text(
        f"#!{sys.executable}\nimport sys\nsys.path.insert(0, {str(ROOT)!r})\n"
        f"from tests.formats.verifyta_double import main\nmain({spelling!r}, *sys.argv[1:])\n"
    )
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program


def main(spelling: str, option: str, order: str, model_file: str, question_file: str) -> None:
    """Searches, and prints what came of it."""
    assert (option, order) == ("-t", "2"), "the fastest trace is wanted"
    model = read_uppaal(Path(model_file).read_bytes())
    answer = reach(model.network, read_query(Path(question_file).read_text(encoding="utf-8").strip(), model))
    reached = isinstance(answer, Reached)
    thing = "Property" if spelling == "old" else "Formula"
    print(f"Verifying {thing.lower()} 1 at line 1\n -- {thing} is {'' if reached else 'NOT '}satisfied.")  # noqa: T201
    if isinstance(answer, Reached):
        print("Showing example trace.", file=sys.stderr)  # noqa: T201
        for move in answer.trace.moves:
            print("\n".join(spelled(model.network, move, spelling)), file=sys.stderr)  # noqa: T201


def spelled(network: Network, move: Move, spelling: str) -> Iterator[str]:
    """A move with the state before it."""
    parts = [_edge(network, place, index, spelling) for place, index in move]
    if spelling == "old":
        yield from ("State:", "( ... )", "", "Delay: 1", "", "Transitions:", *(f"  {each}" for each in parts))
    else:
        # The sender may come last.
        yield from ("State", "( ... )", "", "Delay: 1", "", f"Transition: {' '.join([*parts[1:], parts[0]])}")
    yield ""


def _edge(network: Network, place: int, index: int, spelling: str) -> str:
    automaton = network.automata[place]
    edge = automaton.edges[index]
    ends = (f"{automaton.name}.{automaton.locations[at].name}" for at in (edge.source, edge.target))
    guard = " && ".join([*bounds(edge.guard, 1), *map(comparison, edge.tests)]) or "1"
    channel = edge.synchronisation or "tau"
    updates = ", ".join([*(f"{clock} = 0" for clock in sorted(edge.resets)), *map(update, edge.assignments)])
    if spelling == "old":
        return f"{'->'.join(ends)} {{ {guard}, {channel}, {updates.replace(' = ', ' := ') or 1} }}"
    return f"{'->'.join(ends)} {{{guard}; {channel}; {updates};}}"
