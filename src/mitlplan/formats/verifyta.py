"""UPPAAL's own verifier as a search engine, where it is installed.

``verifyta -t 2`` says whether a query holds and prints the fastest trace on stderr. Its spelling has changed
over the versions (``Property is satisfied`` and ``Formula is satisfied``, ``State:`` and ``State``,
``Transitions:`` with an edge a line and ``Transition:`` with all of them in one); all are read. Of the trace
only the edges are used: their exact times are computed here, and the result is executed before it is
believed, since the verifier's answers are approximate where clocks are stopped.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from fractions import Fraction
from pathlib import Path

from mitlplan.automata.timed_automaton import Edge, Network, Query, holds, ticks_per_second, value_of
from mitlplan.automata.trace import Move
from mitlplan.errors import ToolError
from mitlplan.formats.identifiers import with_identifiers
from mitlplan.formats.uppaal import KEYWORDS, bounds, comparison, targets, update, write_uppaal
from mitlplan.search.fastest import MEGABYTE, Limits, Progress, Stopped
from mitlplan.search.reach import Effort, Reachable, Reached, Unknown, Unreachable
from mitlplan.search.timing import earliest

VARIABLE = "MITLPLAN_VERIFYTA"
"""The environment variable that names the program."""

_ABSENT = (
    f"verifyta is not on the PATH, and {VARIABLE} does not name it: UPPAAL comes from https://uppaal.org "
    "(free for academic use, with a licence key); without it, leave out --engine uppaal"
)

_VERDICT = re.compile(r"(?:Property|Formula) (is NOT|is|MAY be) satisfied")
_SECTION = re.compile(r"^[ \t]*(State|Transitions?|Delay)\s*:?", re.MULTILINE)
_EDGE = re.compile(r"\b(\w+)\.(\w+)\s*->\s*(\w+)\.(\w+)\s*(?:\{([^{}]*)\})?", re.ASCII)
_OUT_OF_MEMORY = re.compile("out of memory|bad_alloc", re.IGNORECASE)

_LOOK = 0.1
"""Seconds between looks at limits."""


class Verdict(Enum):
    """What the verifier says of the query."""

    YES = "satisfied"
    NO = "not satisfied"
    MAYBE = "may be satisfied"


def find_verifyta(environment: Mapping[str, str] = os.environ) -> Path:
    """Where the program is.

    Raises
    ------
    ToolError
        If it is nowhere, with a sentence that says how to get it.
    """
    named = environment.get(VARIABLE)
    found = shutil.which(named or "verifyta", path=environment.get("PATH"))
    if found is None:
        raise ToolError(_ABSENT if named is None else f"{VARIABLE} names {named}, which cannot be run")
    return Path(found)


def fastest_trace(
    network: Network,
    query: Query,
    limits: Limits | None = None,
    *,
    epsilon: Fraction = Fraction(1, 1000),
    verifyta: Path,
) -> Reachable:
    """The fastest trace to a target, found by ``verifyta`` and executed here.

    Parameters
    ----------
    network, query
        As for :func:`~mitlplan.formats.uppaal.write_uppaal`.
    limits
        None by default; the program is stopped at the limit of time, and gets no more memory than is said.
    epsilon
        How near to come to a least time that no trace attains, in seconds.
    verifyta
        The program.

    Returns
    -------
    Reached, Unreachable, Unknown or Stopped
        The program tells nothing of its effort; that no trace is faster is its word.

    Raises
    ------
    ToolError
        If the program fails or says what is not understood.
    """
    limits = (Limits() if limits is None else limits).begin()
    output, errors = _run(network, query, verifyta, limits)
    said = output + errors
    if _VERDICT.search(said) is None:
        if limits.over():
            return Stopped(f"verifyta was stopped at the time limit of {limits.seconds:g} s", None, 0)
        if limits.megabytes is not None and _OUT_OF_MEMORY.search(said):
            return Stopped(f"verifyta reached the memory limit of {limits.megabytes} MB", None, 0)
        last = (errors or output).strip().splitlines()
        raise ToolError(f"verifyta gave no verdict: {last[-1] if last else 'it said nothing at all'}")
    verdict = read_verdict(said)
    if verdict is Verdict.NO:
        return Unreachable(Effort())
    moves = read_moves(errors if _SECTION.search(errors) else output, network)
    for target in query.targets:
        trace = earliest(network, moves, target, epsilon=epsilon)
        if trace is not None:
            bound = trace.least if verdict is Verdict.YES else Fraction(0)
            return Reached(trace, target, bound, Effort())
    return Unknown(1, Effort())


def _run(network: Network, query: Query, verifyta: Path, limits: Limits) -> tuple[str, str]:
    """What the program prints on stdout and stderr, as far as it gets before the limit of time."""
    named, asked = with_identifiers(network, query, KEYWORDS)
    with tempfile.TemporaryDirectory(prefix="mitlplan") as folder:
        model, question = Path(folder, "model.xml"), Path(folder, "model.q")
        model.write_text(write_uppaal(network, query), encoding="utf-8")
        question.write_text(f"E<> {targets(asked, ticks_per_second(named, asked))}\n", encoding="utf-8")
        try:
            process = subprocess.Popen(  # noqa: S603  (the program is the user's own choice)
                [*_confined(limits), str(verifyta), "-t", "2", str(model), str(question)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
                # Often a script that starts the program: both are stopped together.
                start_new_session=True,
            )
        except OSError as error:
            raise ToolError(f"{verifyta} cannot be run: {error.strerror}") from None
        with process:
            try:
                return _heard(process, limits)
            finally:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)


def _confined(limits: Limits) -> list[str]:
    """What to write before a command that gets no more memory than the limits say."""
    if limits.megabytes is None:
        return []
    return ["sh", "-c", 'ulimit -v "$0" && exec "$@"', str(limits.megabytes * MEGABYTE // 1024)]


def _heard(process: subprocess.Popen[str], limits: Limits) -> tuple[str, str]:
    while not limits.over():
        remaining = limits.remaining()
        try:
            return process.communicate(timeout=_LOOK if remaining is None else min(_LOOK, remaining))
        except subprocess.TimeoutExpired:
            if limits.progress is not None:
                limits.progress(Progress(0, None, limits.elapsed))
    return "", ""


def read_verdict(output: str) -> Verdict:
    r"""The verdict in what the program printed.

    Examples
    --------
    >>> read_verdict("Verifying property 1 at line 1\n -- Property is NOT satisfied.\n")
    <Verdict.NO: 'not satisfied'>
    """
    match = _VERDICT.search(output)
    if match is None:
        raise ToolError("verifyta gave no verdict")
    return {"is": Verdict.YES, "is NOT": Verdict.NO, "MAY be": Verdict.MAYBE}[match[1]]


def read_moves(text: str, network: Network) -> list[Move]:
    """The moves of a trace as printed.

    Parameters
    ----------
    text
        The output that has the trace.
    network
        The network as it was exported.

    Raises
    ------
    ToolError
        If the trace takes an edge that the network does not have.
    """
    return list(_Matcher(network).moves(text))


class _Matcher:
    """Finds the edges that a trace speaks of; integers are followed to tell like ones apart."""

    def __init__(self, network: Network) -> None:
        named, _ = with_identifiers(network, Query(()), KEYWORDS)
        self._network = named
        self._scale = ticks_per_second(named)
        self._automaton = {automaton.name: place for place, automaton in enumerate(named.automata)}
        self._values = {variable.name: variable.initial for variable in named.variables}

    def moves(self, text: str) -> Iterator[Move]:
        for section in _sections(text):
            edges = [self._edge(match) for match in _EDGE.finditer(section)]
            if edges:
                edges.sort(key=lambda edge: not self._sends(edge))
                for place, index in edges:
                    for assignment in self._network.automata[place].edges[index].assignments:
                        self._values[assignment.variable] = value_of(assignment.value, self._values)
                yield tuple(edges)

    def _sends(self, edge: tuple[int, int]) -> bool:
        side = self._network.automata[edge[0]].edges[edge[1]].synchronisation
        return side is not None and side.sends

    def _edge(self, match: re.Match[str]) -> tuple[int, int]:
        process, source, other, target, label = match.groups()
        place = self._automaton.get(process)
        if place is None or process != other:
            raise ToolError(
                f"verifyta speaks of {process}.{source}->{other}.{target}, which is not in the model"
            )
        automaton = self._network.automata[place]
        names = [location.name for location in automaton.locations]
        fitting = [
            (index, edge)
            for index, edge in enumerate(automaton.edges)
            if (names[edge.source], names[edge.target]) == (source, target)
            and all(holds(test, self._values) for test in edge.tests)
        ]
        if not fitting:
            raise ToolError(f"verifyta takes {process}.{source}->{target}, which the model does not have")
        likely = max(fitting, key=lambda pair: self._likeness(pair[1], label or ""))
        return place, likely[0]

    def _likeness(self, edge: Edge, label: str) -> int:
        """How many of the edge's conditions and updates are found in the label."""
        said = {_squeezed(part) for part in re.split("&&|[,;]", label)}
        parts: list[str] = [*bounds(edge.guard, self._scale), *map(comparison, edge.tests)]
        parts += [*(f"{clock} = 0" for clock in edge.resets), *map(update, edge.assignments)]
        if edge.synchronisation is not None:
            parts.append(str(edge.synchronisation))
        found = sum(_squeezed(part) in said for part in parts)
        return 2 * found - len(parts)


def _squeezed(text: str) -> str:
    return re.sub(r"[\s()]", "", text).replace(":=", "=")


def _sections(text: str) -> Sequence[str]:
    """The parts of a trace that tell transitions."""
    found = list(_SECTION.finditer(text))
    ends = [*(match.start() for match in found[1:]), len(text)]
    return [
        text[match.end() : end]
        for match, end in zip(found, ends, strict=False)
        if match[1].startswith("Transition")
    ]
