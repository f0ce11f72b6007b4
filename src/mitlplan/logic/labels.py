"""Whether some label makes a formula true: a truth table, one integer a formula.

The labels of n atoms are numbered from 0 to 2^n - 1, and the set of labels of which a formula is true is the
integer with these bits: a conjunction is ``&``. What stands below a temporal operator counts as an atom, the
same for a formula and, negated, for its negation. More than 16 atoms are not tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from operator import and_, or_
from typing import NamedTuple

from mitlplan.logic.core import (
    Conjunction,
    Core,
    CoreRelease,
    CoreUntil,
    Disjunction,
    Literal,
    Truth,
    negate,
)

MOST_ATOMS = 16


def possible(core: Core) -> bool:
    """Whether some label may make `core` true; also if it has too many atoms to tell.

    Parameters
    ----------
    core
        Any formula; a temporal operator in it is true or false of a label as it likes.

    Examples
    --------
    >>> near, busy = Literal("near"), Literal("busy")
    >>> possible(Conjunction((busy, Disjunction((near, negate(busy))))))
    True
    >>> possible(Conjunction((CoreUntil(busy, near), negate(CoreUntil(busy, near)))))
    False
    """
    truths = _truths(core)
    return truths is None or truths.of_core != 0


def certain(core: Core) -> bool:
    """Whether every label makes `core` true; not if it has too many atoms to tell.

    Examples
    --------
    >>> near, busy = Literal("near"), Literal("busy")
    >>> certain(Disjunction((Conjunction((busy, near)), negate(busy), negate(near))))
    True
    """
    truths = _truths(core)
    return truths is not None and truths.of_core == truths.of_true


class _Truths(NamedTuple):
    """The labels of which a formula is true, and all labels."""

    of_core: int
    of_true: int


def _truths(core: Core) -> _Truths | None:
    atoms = dict.fromkeys(_atoms(core))
    if len(atoms) > MOST_ATOMS:
        return None
    everything = (1 << (1 << len(atoms))) - 1
    # The table of the i-th atom repeats 2^i zeros and 2^i ones.
    tables = {atom: everything // ((1 << (1 << i)) + 1) << (1 << i) for i, atom in enumerate(atoms)}
    return _Truths(_table(core, tables, everything), everything)


def _atoms(core: Core) -> Iterator[Core]:
    match core:
        case Truth():
            pass
        case Literal(name):
            yield Literal(name)
        case Conjunction(operands) | Disjunction(operands):
            for operand in operands:
                yield from _atoms(operand)
        case CoreUntil():
            yield core
        case CoreRelease():
            yield negate(core)


def _table(core: Core, tables: dict[Core, int], everything: int) -> int:
    match core:
        case Truth(value):
            return everything if value else 0
        case Literal(name, positive):
            return tables[Literal(name)] ^ (0 if positive else everything)
        case Conjunction(operands):
            return reduce(and_, (_table(operand, tables, everything) for operand in operands))
        case Disjunction(operands):
            return reduce(or_, (_table(operand, tables, everything) for operand in operands))
        case CoreUntil():
            return tables[core]
        case CoreRelease():
            return tables[negate(core)] ^ everything
