"""The answers of ``mitlplan satisfiable`` and its kin: a word and, if there is one, a signal to show it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Witness:
    """A signal, for writing.

    Parameters
    ----------
    stretches
        When each begins, in seconds, and what holds from then on.
    end
        Where the last one ends.
    repeat_from
        To which time the signal goes back at `end`, again and again; ``None`` if anything may follow.
    """

    stretches: tuple[tuple[Fraction, frozenset[str]], ...]
    end: Fraction
    repeat_from: Fraction | None


def decision_to_text(word: str, reason: str = "", witness: Witness | None = None) -> str:
    """The answer as lines.

    Examples
    --------
    >>> stretches = ((Fraction(0), frozenset()), (Fraction(2), frozenset("A")))
    >>> signal = Witness(stretches, Fraction(3), Fraction(2))
    >>> print(decision_to_text("satisfiable", witness=signal), end="")
    satisfiable
    from 0: nothing
    from 2: A
    from 3: again as from 2, and so on
    """
    lines = [f"{word}: {reason}" if reason else word]
    if witness is not None:
        lines += [
            f"from {start}: {', '.join(sorted(holds)) or 'nothing'}" for start, holds in witness.stretches
        ]
        lines.append(
            f"after {witness.end}: anything"
            if witness.repeat_from is None
            else f"from {witness.end}: again as from {witness.repeat_from}, and so on"
        )
    return "\n".join(lines) + "\n"


def decision_to_json(word: str, reason: str = "", witness: Witness | None = None) -> str:
    """The answer as JSON, times as texts.

    Examples
    --------
    >>> print(decision_to_json("valid"), end="")
    {"mitlplan": 1, "status": "valid", "reason": null, "witness": null}
    """
    answer = {"mitlplan": 1, "status": word, "reason": reason or None, "witness": _signal(witness)}
    return json.dumps(answer, ensure_ascii=False) + "\n"


def _signal(witness: Witness | None) -> dict[str, object] | None:
    if witness is None:
        return None
    return {
        "segments": [{"start": str(start), "holds": sorted(holds)} for start, holds in witness.stretches],
        "end": str(witness.end),
        "repeat_from": None if witness.repeat_from is None else str(witness.repeat_from),
    }
