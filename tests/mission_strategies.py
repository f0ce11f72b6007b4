"""Random small missions as Hypothesis strategies, which shrink: the generator is that of the fuzzer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hypothesis import strategies as st

from mitlplan.logic import formula as f
from mitlplan_fuzz.missions import SmallMission, draw_formula, draw_mission


@dataclass(frozen=True)
class DrawnChoices:
    """Numbers that Hypothesis draws, and shrinks."""

    draw: st.DrawFn

    def number(self, least: int, most: int) -> int:
        return self.draw(st.integers(least, most))


@st.composite
def missions(draw: st.DrawFn) -> SmallMission:
    """Small missions."""
    return draw_mission(DrawnChoices(draw))


@st.composite
def formulas(
    draw: st.DrawFn, names: Sequence[str] = ("A", "B"), *, depth: int = 3, open_ends: bool = True
) -> f.Formula:
    """Formulas with one to four temporal operators."""
    return draw_formula(DrawnChoices(draw), names, depth=depth, open_ends=open_ends)
