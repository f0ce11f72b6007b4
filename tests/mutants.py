"""Would the tests notice? ``python -m tests.mutants [ROOM]... --sample 50 --seed 1``, or ``make mutants``.

A mutant is the package with one small fault in it: a comparison turned round, a number one off, a loop left
out (the operators of Cosmic Ray). One that no test notices shows a gap in the tests, a piece of code that
does nothing, or two ways of saying the same. The mutated source is given to the import system of a forked
process and never written to disk, so the working tree stays as it is and libraries are imported once. Each
mutant first meets the quick tests of its room, with few random cases, up to the first failure; only what
survives meets the slow ones. Where the parsed code is the same but for annotations and texts that document
it, there is no mutant. Before a room begins, its tests must pass without a fault and fail where a module
does not even load.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import CodeType, ModuleType
from typing import NoReturn

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src"

LONGEST = 600
"""Seconds of processor time after which the tests of a mutant are taken to hang: it is noticed."""

MOST_MEMORY = 4 << 30
"""Bytes that a mutant may use before it is noticed."""


@dataclass(frozen=True, slots=True)
class Room:
    """Where mutants are made, and the tests they meet."""

    sources: str
    quick: tuple[str, ...]
    slow: tuple[str, ...]


ROOMS = {
    "logic": Room(
        "mitlplan/logic",
        ("src/mitlplan/logic", "tests/logic"),
        ("tests/logic", "tests/test_cases.py", "tests/test_oracles.py"),
    ),
    "compact": Room(
        "mitlplan/translation/compact",
        ("tests/translation/compact/test_translate.py", "tests/test_must_show.py", "tests/test_cases.py"),
        ("tests/translation/compact",),
    ),
    "seed": Room(
        "mitlplan/translation/seed",
        ("tests/translation/seed",),
        (
            "tests/test_models.py",
            "tests/test_cli_models.py",
            # The others look at limits of time: on a busy machine they would notice anything.
            "tests/test_engine.py::test_the_model_of_a_random_mission_has_the_same_least_makespan",
        ),
    ),
    "search": Room(
        "mitlplan/search",
        (
            "src/mitlplan/search",
            "tests/search/test_fastest.py",
            "tests/search/test_lasso.py",
            "tests/search/test_systems.py",
            "tests/search/test_tables.py",
            "tests/test_must_show.py",
            "tests/test_slack.py",
            "tests/search/test_reach.py",
        ),
        ("tests/search/test_limits.py", "tests/test_cases.py", "tests/test_tour.py"),
    ),
}


@dataclass(frozen=True, slots=True)
class Mutant:
    """A module with one fault in it."""

    file: Path
    operator: str
    code: str

    @property
    def module(self) -> str:
        """The name under which it is imported."""
        return ".".join(self.file.relative_to(SOURCE).with_suffix("").parts)

    @property
    def difference(self) -> str:
        """The lines that differ from what stands in the file."""
        here = self.file.read_text(encoding="utf-8").splitlines()
        lines = difflib.unified_diff(here, self.code.splitlines(), lineterm="", n=0)
        return "\n".join(line for line in lines if not line.startswith(("---", "+++")))


def mutants_of(room: Room, chance: random.Random) -> Iterator[Mutant]:
    """All mutants of a room, in random order."""
    places = []
    for file in files_of(room):
        tree = get_ast(file.read_text(encoding="utf-8"))
        for name in operator_names():
            if get_operator(name).arguments():
                continue
            operator = get_operator(name)()
            count = sum(1 for node in ast_nodes(tree) for _ in operator.mutation_positions(node))
            places += [(file, name, occurrence) for occurrence in range(count)]
    chance.shuffle(places)
    for file, name, occurrence in places:
        text = file.read_text(encoding="utf-8")
        code = mutate_code(text, get_operator(name)(), occurrence)
        if code is not None and _meaning(code) not in (None, _meaning(text)):
            yield Mutant(file, name.removeprefix("core/"), code)


def files_of(room: Room) -> list[Path]:
    """The modules of a room."""
    return sorted((SOURCE / room.sources).rglob("*.py"))


class _Bare(ast.NodeTransformer):
    """Code without annotations and without texts that document it."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        node.annotation = None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns = None
        return self.generic_visit(node)

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        documents = isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        return ast.Pass() if documents else node


def _meaning(code: str) -> str | None:
    """What code does; ``None`` if it is no Python: a ``*`` in a signature is taken for a product."""
    try:
        return ast.dump(_Bare().visit(ast.parse(code)))
    except SyntaxError:
        return None


# --- A forked process --------------------------------------------------------------------------------------


class _Mutated(importlib.machinery.SourceFileLoader):
    def __init__(self, mutant: Mutant) -> None:
        super().__init__(mutant.module, str(mutant.file))
        self._mutant = mutant

    def get_code(self, fullname: str) -> CodeType:
        return compile(self._mutant.code, self.get_filename(fullname), "exec", dont_inherit=True)


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, mutant: Mutant) -> None:
        self._mutant = mutant

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != self._mutant.module:
            return None
        return importlib.util.spec_from_loader(fullname, _Mutated(self._mutant))


def complaint(mutant: Mutant, tests: Sequence[str], profile: str) -> str | None:
    """What these tests say of a mutant, up to the first that fails; ``None`` if all of them pass."""
    with tempfile.TemporaryFile() as said:
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            _test(mutant, tests, profile, said.fileno())
        try:
            _, status = os.waitpid(child, 0)
        finally:
            # Whatever ended the tests, programs that they started end with them.
            with suppress(ProcessLookupError):
                os.killpg(child, signal.SIGKILL)
        said.seek(0)
        return said.read().decode(errors="replace") if status else None


def _test(mutant: Mutant, tests: Sequence[str], profile: str, said: int) -> NoReturn:
    code = 1
    try:
        os.setsid()  # tests that press Ctrl-C mean themselves
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST + 5))
        resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
        for stream in (1, 2):
            os.dup2(said, stream)
        sys.dont_write_bytecode = True
        sys.meta_path.insert(0, _Finder(mutant))
        import pytest

        options = ["-q", "-x", "-p", "no:xdist", "-p", "no:cacheprovider", f"--hypothesis-profile={profile}"]
        # The libraries are there before pytest could have rewritten their assertions.
        options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
        code = pytest.main([*options, *(str(ROOT / test) for test in tests)])
    except BaseException:  # noqa: BLE001  (it is told, and the process ends)
        traceback.print_exc()
    finally:
        # Nothing that belongs to the process it was forked from is ended or written twice.
        sys.stdout.flush()
        os._exit(min(code, 1))


def survives(mutant: Mutant, room: Room) -> bool:
    """Whether no test of the room notices a mutant."""
    return complaint(mutant, room.quick, "mutants") is None and complaint(mutant, room.slow, "test") is None


def believe(room: Room) -> None:
    """Ends the program unless the tests of a room pass as they are, and fail where there is no module."""
    file = files_of(room)[-1]
    text = file.read_text(encoding="utf-8")
    for tests, profile in ((room.quick, "mutants"), (room.slow, "test")):
        fault = complaint(Mutant(file, "nothing", text), tests, profile)
        if fault is not None:
            raise SystemExit(f"{fault}\nThe tests of {room.sources} fail without a mutant.")
    if complaint(Mutant(file, "everything", f"{text}\nraise AssertionError"), room.quick, "mutants") is None:
        raise SystemExit(f"No test of {room.sources} misses {file}.")


def main(arguments: list[str] | None = None) -> None:
    """Print the mutants that survive, and how many did not."""
    summary, _, more = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=summary, epilog=more)
    parser.add_argument("rooms", nargs="*", metavar="ROOM", help=f"of {', '.join(ROOMS)}; all by default")
    parser.add_argument("--sample", type=int, default=50, help="how many mutants of each room")
    parser.add_argument("--seed", type=int, default=1, help="which ones")
    options = parser.parse_args(arguments)
    for unknown in set(options.rooms) - ROOMS.keys():
        parser.error(f"no room {unknown!r}; there are {', '.join(ROOMS)}")
    os.nice(10)
    _import_libraries()
    for name in options.rooms or ROOMS:
        room = ROOMS[name]
        begin = time.monotonic()
        believe(room)
        made = survivors = 0
        for mutant in islice(mutants_of(room, random.Random(options.seed)), options.sample):
            made += 1
            if survives(mutant, room):
                survivors += 1
                place = mutant.file.relative_to(ROOT)
                print(f"\n{name} {made}: {place}, {mutant.operator}\n{mutant.difference}", flush=True)
        minutes = (time.monotonic() - begin) / 60
        print(f"\n{name}: {made - survivors} of {made} mutants noticed, {minutes:.0f} min", flush=True)


def _import_libraries() -> None:
    """What every forked process needs, and has no part of the package in it."""
    import hypothesis.strategies
    import numpy as np
    import pydantic
    import pytest
    import ruamel.yaml
    import scipy.optimize
    import scipy.sparse.csgraph

    assert all(
        (hypothesis.strategies, np, pydantic, pytest, ruamel.yaml, scipy.optimize, scipy.sparse.csgraph)
    )
    assert not any(name.split(".")[0] == "mitlplan" for name in sys.modules)


if __name__ == "__main__":
    main()
