from __future__ import annotations

import json
from fractions import Fraction

from mitlplan.formats.witness import Witness, decision_to_json, decision_to_text

STRETCHES = ((Fraction(0), frozenset({"B", "A"})), (Fraction(1, 2), frozenset[str]()))


def test_a_witness_that_repeats() -> None:
    witness = Witness(STRETCHES, Fraction(3), Fraction(1, 2))
    assert decision_to_text("satisfiable", witness=witness) == (
        "satisfiable\nfrom 0: A, B\nfrom 1/2: nothing\nfrom 3: again as from 1/2, and so on\n"
    )
    assert json.loads(decision_to_json("satisfiable", witness=witness)) == {
        "mitlplan": 1,
        "status": "satisfiable",
        "reason": None,
        "witness": {
            "segments": [{"start": "0", "holds": ["A", "B"]}, {"start": "1/2", "holds": []}],
            "end": "3",
            "repeat_from": "1/2",
        },
    }


def test_a_witness_after_which_anything_may_come() -> None:
    witness = Witness(STRETCHES[:1], Fraction(1), None)
    assert decision_to_text("not valid", witness=witness) == ("not valid\nfrom 0: A, B\nafter 1: anything\n")


def test_no_witness() -> None:
    assert decision_to_text("limit", "60 seconds are over") == "limit: 60 seconds are over\n"
    assert decision_to_text("valid") == "valid\n"
    assert json.loads(decision_to_json("limit", "60 seconds are over"))["reason"] == "60 seconds are over"
