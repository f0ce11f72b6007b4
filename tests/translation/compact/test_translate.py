"""What the translation reads off a formula: which transducer will do, and what the present label tells."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mitlplan.logic.core import Core, CoreRelease, holds
from mitlplan.logic.normalize import normalize, written
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.translation.compact.translate import constant_value, name_of, necessary_label, translate
from tests.strategies import ATOMS, as_many, core_formulas, signals

ONCE = {"idle", "done", "free", "held"}


@pytest.mark.parametrize(
    ("text", "once"),
    [
        ("G[0,3] p", True),
        ("p R q", True),
        ("(p & !q) R[1,3] q", True),
        ("(p | F[0,2] q) R[1,3] q", True),
        ("(p U[1,2] q) R q", True),
        ("(G[0,1] p) R q", True),
        # These may hold just after an instant and not at it, where a release claimed once does not look.
        ("(F[0,2) p) R q", False),
        ("(p & (p R[1,2] q)) R q", False),
        ("(p U (p R(0,2] q)) R q", False),
    ],
)
def test_a_release_in_a_one_shot_position_is_claimed_once_if_its_left_side_begins_attained(
    text: str, once: bool
) -> None:
    core = normalize(parse(text), horizon="infinite")
    assert isinstance(core, CoreRelease)
    (release,) = [one for one in translate(core).transducers if one.name == name_of(core)]
    assert ({location.name for location in release.locations} == ONCE) is once


@as_many(5)
@given(core_formulas(), signals(repeating=True))
def test_a_necessary_label_is_there_wherever_the_formula_holds(core: Core, signal: Signal) -> None:
    if satisfies(written(core), signal):
        assert holds(necessary_label(core), signal.segments[0].holds)


@as_many(2)
@given(core_formulas(), st.frozensets(st.sampled_from(ATOMS)))
def test_the_value_of_a_formula_where_the_label_never_changes(core: Core, label: frozenset[str]) -> None:
    for_ever = Signal((Segment(Fraction(0), label),), Fraction(1), repeat_from=Fraction(0))
    assert holds(constant_value(core), label) == satisfies(written(core), for_ever)
