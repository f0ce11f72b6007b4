"""The answers of UPPAAL's verifier are understood in all its spellings, and believed only after a check."""

from __future__ import annotations

import stat
import sys
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mitlplan.automata.lockstep import Lockstep, lockstep
from mitlplan.automata.timed_automaton import Automaton, Edge, Location, Network, Query
from mitlplan.automata.trace import Move, execute, stays
from mitlplan.automata.transducer import Constraint, Relation
from mitlplan.errors import ToolError
from mitlplan.formats.identifiers import with_identifiers
from mitlplan.formats.uppaal import KEYWORDS
from mitlplan.formats.verifyta import (
    VARIABLE,
    Verdict,
    fastest_trace,
    find_verifyta,
    read_moves,
    read_verdict,
)
from mitlplan.logic.normalize import normalize
from mitlplan.logic.parse import parse
from mitlplan.search import reach as native
from mitlplan.search.fastest import Limits, Stopped
from mitlplan.translation.seed.published_network import PublishedModel, published_model
from mitlplan.translation.seed.repaired import translate
from tests.formats.verifyta_double import SPELLINGS, spelled
from tests.oracles.published_reach import reach
from tests.search.test_reach import questions
from tests.translation.seed.paper import PHI, ring
from tests.translation.seed.test_repaired import network, paper_map

OLD = """\
Options for the verification:
  Generating fastest trace
  Search order is breadth first
  Using conservative space optimisation
  Seed is 1442480410
  State space representation uses minimal constraint systems

Verifying property 1 at line 1
 -- Property is satisfied.
Showing example trace.

State:
( sys.loc0 )
t=0 z[0]=0 z[1]=0 z[2]=0 z[3]=0 z[4]=0 z[5]=0 z[6]=0 z[7]=0

Delay: 1

State:
( sys.loc0 )
t=1 z[0]=1 z[1]=1 z[2]=1 z[3]=1 z[4]=1 z[5]=1 z[6]=1 z[7]=1

Transitions:
  sys.loc0->sys.loc2 { z[7] >= 1 && z[2] > 0 && z[3] > 0, tau, z[2] := 0, z[3] := 0, z[7] := 0 }

State:
( sys.loc2 )
t=1 z[0]=1 z[1]=1 z[2]=0 z[3]=0 z[4]=1 z[5]=1 z[6]=1 z[7]=0

Delay: 1

State:
( sys.loc2 )
t=2 z[0]=2 z[1]=2 z[2]=1 z[3]=1 z[4]=2 z[5]=2 z[6]=2 z[7]=1

Transitions:
  sys.loc2->sys.loc7 { z[7] >= 1 && z[2] > 0 && z[3] > 0 && z[6] > 0, tau, z[2] := 0, z[3] := 0 }

Delay: 1

Transitions:
  sys.loc7->sys.loc6_b { z[7] >= 1 && z[0] > 0 && z[1] > 0 && z[3] > 0, tau, z[0] := 0, z[1] := 0 }

Transitions:
  sys.loc6_b->sys.final { 1, tau, 1 }

State:
( sys.final )
t=3 z[0]=0 z[1]=0 z[2]=1 z[3]=0 z[4]=3 z[5]=3 z[6]=1 z[7]=0
"""

NEW = """\
Options for the verification:
  Generating fastest trace
  Search order is breadth first
  Using conservative space optimisation
  Seed is 1718093511
  State space representation uses minimal constraint systems with future testing
  Using HashMap + Compress integers for discrete state storage

Verifying formula 1 at model.q:1
 -- Formula is satisfied.
Showing example trace.

State
( sys.loc19 sys1.wait sys0.loc28 )
t=0 z[7]=0

Delay: 1

Transition: sys.loc19->sys.loc3 {z[7] >= 1 && z[2] >= 0 && z[0] > 0; tau; z[0] = 0, z[7] = 0;}

State
( sys.loc3 sys1.wait sys0.loc28 )
t=1 z[7]=0

Delay: 1

Transition: sys1.wait->sys1.final {1; ch?; ;} sys.loc3->sys.loc7 {z[7] >= 1; ch!; z[0] = 0, z[7] = 0;}

State
( sys.loc7 sys1.final sys0.loc28 )
t=2 z[7]=0

Transition: sys0.loc28->sys0.loc22_b {1; tau; z[2] = 0;}

Transition: sys0.loc22_b->sys0.final {1; tau; ;}
"""


def phi(number: int) -> PublishedModel:
    return published_model(PHI[f"phi{number}"], ring())


@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        (OLD, Verdict.YES),
        (NEW, Verdict.YES),
        ("\x1b[2K -- Formula is satisfied.\n", Verdict.YES),
        (" -- Property is NOT satisfied.", Verdict.NO),
        (" -- Formula is NOT satisfied.", Verdict.NO),
        (" -- Formula MAY be satisfied.", Verdict.MAYBE),
    ],
)
def test_the_verdict_in_both_spellings(text: str, verdict: Verdict) -> None:
    assert read_verdict(text) is verdict


def names(own: Network, moves: list[tuple[tuple[int, int], ...]]) -> list[list[str]]:
    shown = []
    for move in moves:
        edges = [(own.automata[place], own.automata[place].edges[index]) for place, index in move]
        shown.append(
            [
                f"{each.name}.{each.locations[e.source].name}->{each.locations[e.target].name}"
                for each, e in edges
            ]
        )
    return shown


def test_a_trace_in_the_old_spelling() -> None:
    own = phi(1).network
    assert names(own, read_moves(OLD, own)) == [
        ["sys.loc0->loc2"],
        ["sys.loc2->loc7"],
        ["sys.loc7->loc6_b"],
        ["sys.loc6_b->final"],
    ]


def test_a_trace_in_the_new_spelling_with_the_sender_first() -> None:
    own = phi(2).network
    assert names(own, read_moves(NEW, own)) == [
        ["sys.loc19->loc3"],
        ["sys.loc3->loc7", "sys1.wait->final"],
        ["sys0.loc28->loc22_b"],
        ["sys0.loc22_b->final"],
    ]


@pytest.mark.parametrize(
    ("trace", "problem"),
    [
        ("Transitions:\n  robot.a->robot.b { }\n", r"speaks of robot.a->robot.b, which is not in the model"),
        (
            "Transitions:\n  sys.loc0->sys.loc9_b { }\n",
            "takes sys.loc0->loc9_b, which the model does not have",
        ),
    ],
)
def test_edges_that_are_not_there(trace: str, problem: str) -> None:
    with pytest.raises(ToolError, match=problem):
        read_moves(trace, phi(1).network)


def pretended(folder: Path, *, output: str = "", errors: str = "", seconds: float = 0, code: int = 0) -> Path:
    """A program that says what was recorded."""
    program = folder / "verifyta"
    program.write_text(
        f"#!{sys.executable}\nimport sys, time\ntime.sleep({seconds})\n"
        f"assert sys.argv[1:3] == ['-t', '2'] and open(sys.argv[4]).read().startswith('E<> ')\n"
        f"sys.stdout.write({output!r})\nsys.stderr.write({errors!r})\nsys.exit({code})\n"
    )
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program


def split(recorded: str) -> tuple[str, str]:
    """What goes to stdout, and the trace, which goes to stderr."""
    options, _, trace = recorded.partition("Showing example trace.\n")
    return options, f"Showing example trace.\n{trace}"


@pytest.mark.parametrize(("number", "recorded", "least"), [(1, OLD, 3), (2, NEW, 2)])
@pytest.mark.parametrize("together", [False, True])
def test_the_fastest_trace_gets_exact_times(
    number: int, recorded: str, least: int, together: bool, tmp_path: Path
) -> None:
    output, errors = (recorded, "") if together else split(recorded)
    model = phi(number)
    verifyta = pretended(tmp_path, output=output, errors=errors)
    answer = fastest_trace(model.network, model.query, verifyta=verifyta)
    assert isinstance(answer, native.Reached)
    trace = answer.trace
    assert (trace.end, trace.attained, answer.bound) == (least, True, least)
    assert execute(model.network, trace) is None
    cells = [cell for cell, _ in stays(model.network, trace, 0, model.cells)]
    assert cells == ([0, 1, 0, 3] if number == 1 else [0, 3, 0])


def test_an_unreachable_target_and_a_trace_that_is_none(tmp_path: Path) -> None:
    model = phi(1)
    unreachable = pretended(tmp_path, output=" -- Formula is NOT satisfied.\n")
    answer = fastest_trace(model.network, model.query, verifyta=unreachable)
    assert answer == native.Unreachable(native.Effort())
    skipped = OLD.replace("  sys.loc0->sys.loc2", "  sys.loc2->sys.loc1")
    spurious = pretended(tmp_path, output=skipped.replace("is satisfied", "MAY be satisfied"))
    assert isinstance(fastest_trace(model.network, model.query, verifyta=spurious), native.Unknown)


def test_failures_are_told_in_a_sentence(tmp_path: Path) -> None:
    model = phi(1)

    def problem(verifyta: Path) -> str:
        with pytest.raises(ToolError) as caught:
            fastest_trace(model.network, model.query, verifyta=verifyta)
        return str(caught.value)

    licence = pretended(tmp_path, errors="Licence expired\nPlease renew.\n", code=1)
    assert problem(licence) == "verifyta gave no verdict: Please renew."
    assert problem(pretended(tmp_path)) == "verifyta gave no verdict: it said nothing at all"
    assert problem(tmp_path / "nothing").endswith("cannot be run: No such file or directory")


def test_limits_stop_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Under sanitizers what is loaded before the program has no room within the limit.
    monkeypatch.delenv("LD_PRELOAD", raising=False)
    model = phi(1)
    slow = pretended(tmp_path, seconds=9)
    answer = fastest_trace(model.network, model.query, Limits(seconds=0.2), verifyta=slow)
    assert answer == Stopped("verifyta was stopped at the time limit of 0.2 s", None, 0)
    full = pretended(tmp_path, errors="std::bad_alloc\n", code=134)
    answer = fastest_trace(model.network, model.query, Limits(megabytes=500), verifyta=full)
    assert answer == Stopped("verifyta reached the memory limit of 500 MB", None, 0)


def test_where_the_program_is(tmp_path: Path) -> None:
    program = pretended(tmp_path)
    assert find_verifyta({"PATH": str(tmp_path)}) == program
    assert find_verifyta({VARIABLE: str(program), "PATH": ""}) == program
    with pytest.raises(ToolError, match=r"UPPAAL comes from https://uppaal.org .* leave out --engine uppaal"):
        find_verifyta({"PATH": ""})
    with pytest.raises(ToolError, match="MITLPLAN_VERIFYTA names /nowhere, which cannot be run"):
        find_verifyta({VARIABLE: "/nowhere", "PATH": str(tmp_path)})


def stepped(text: str) -> Lockstep:
    core = normalize(parse(text), "standard", horizon="infinite")
    own = network(paper_map(waiting=False), 0, translate(core))
    return lockstep(own, ["pos0", "pos1", "pos2", "pos3"], parkings=False)


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("text", ["(!A U B) & F A", "F[0,4] A & F[1,2] B", "G[0,3] !A & F B"])
def test_like_edges_are_told_apart(text: str, spelling: str) -> None:
    own = stepped(text)
    found = reach(own.network, own.query, latest=Fraction(6))
    assert found is not None
    renamed, _ = with_identifiers(own.network, own.query, KEYWORDS)
    lines = (line for _, move in found.trace for line in spelled(renamed, move, spelling))
    assert read_moves("\n".join(lines), own.network) == [move for _, move in found.trace]


def test_one_number_is_no_part_of_another() -> None:
    late, later = ((Constraint("x", Relation.AT_LEAST, Fraction(bound)),) for bound in (1, 10))
    walk = Automaton("robot", (Location("a"), Location("b")), (Edge(0, 1, late), Edge(0, 1, later)))
    trace = "Transitions:\n  robot.a->robot.b { x >= 10, tau, 1 }\n"
    assert read_moves(trace, Network((walk,), ("x",))) == [((0, 1),)]


@settings(max_examples=100)
@given(questions(relations=tuple(Relation)), st.sampled_from(SPELLINGS))
def test_the_edges_of_any_trace_are_found_again(question: tuple[Network, Query], spelling: str) -> None:
    network, query = question
    answer = native.reach(network, query)
    if not isinstance(answer, native.Reached):
        return
    renamed, _ = with_identifiers(network, query, KEYWORDS)
    lines = (line for move in answer.trace.moves for line in spelled(renamed, move, spelling))
    again = read_moves("\n".join(lines), network)

    def meant(moves: Iterable[Move]) -> list[list[tuple[int, Edge]]]:
        return [[(place, network.automata[place].edges[index]) for place, index in move] for move in moves]

    assert meant(again) == meant(answer.trace.moves)
