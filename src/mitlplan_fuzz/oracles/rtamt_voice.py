"""A foreign voice: rtamt's discrete-time monitor on signals that change at whole times.

With closed whole bounds and an until that starts now, or is closed, every subformula has one truth value
from each whole time to the next, so the discrete monitor decides the same question. Each tick is one sample;
a proposition is the robustness 1 or -1, and the formula holds where its robustness is positive. (rtamt's
monitor of continuous signals is not asked: its until is wrong at ties.)
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec

from mitlplan.logic import formula as f
from mitlplan_fuzz.formulas import parts

NO_RTAMT = "rtamt is not installed here, and has no say: pip install 'mitlplan[fuzz]'"


@cache
def rtamt_is_there() -> bool:
    """Whether this voice can be heard: it is installed, and can be imported by this version of Python."""
    if find_spec("rtamt") is None:
        return False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            import rtamt  # noqa: F401
        except ImportError:
            return False
    return True


def speaks_of(formula: f.Formula, until: str) -> bool:
    """Whether the discrete monitor means the same by `formula`."""
    timed = [
        part for part in parts(formula) if isinstance(part, (f.Eventually, f.Always, f.Until, f.Release))
    ]
    if any(isinstance(part, f.WeakUntil) for part in parts(formula)):
        return False
    if any(part.interval.upper is None for part in timed):
        return False
    if any(part.interval.lower_open or part.interval.upper_open for part in timed):
        return False
    # The standard until with a lower bound may be true at a last instant, which only 0 itself surely is.
    return until == "closed" or not any(
        isinstance(inner, (f.Until, f.Release)) and inner.interval.lower > 0
        for part in timed
        for operand in f.operands_of(part)
        for inner in parts(operand)
    )


def reach(formula: f.Formula) -> int:
    """How many seconds ahead `formula` looks at most."""
    below = max((reach(operand) for operand in f.operands_of(formula)), default=0)
    if isinstance(formula, f.Next):
        return below + 1
    interval = getattr(formula, "interval", None)
    return below + (0 if interval is None else int(interval.upper))


def monitored(formula: f.Formula, labels: Sequence[frozenset[str]], names: Sequence[str], until: str) -> bool:
    """Whether rtamt finds `formula` true at the first of `labels`: two at least, one a second."""
    with warnings.catch_warnings():
        # Its parser's runtime imports a module that is on its way out, and is gone from Python 3.12 on.
        warnings.simplefilter("ignore")
        import rtamt

        specification = rtamt.StlDiscreteTimeSpecification()
        for name in (*names, "out"):
            specification.declare_var(name, "float")
        specification.spec = f"out = {_text(formula, until)}"
        specification.parse()
        samples = {name: [1.0 if name in label else -1.0 for label in labels] for name in names}
        (_, robustness), *_ = specification.evaluate({"time": list(range(len(labels))), **samples})
    return bool(robustness > 0)


def _text(formula: f.Formula, until: str) -> str:
    """The formula in rtamt's language."""

    def inner(operand: f.Formula) -> str:
        return f"({_text(operand, until)})"

    match formula:
        case f.Constant() | f.WeakUntil():
            raise ValueError("not in rtamt's language")
        case f.Atom(name):
            return f"{name} > 0"
        case f.Not(operand):
            return f"not {inner(operand)}"
        case f.And(operands):
            return " and ".join(map(inner, operands))
        case f.Or(operands):
            return " or ".join(map(inner, operands))
        case f.Implies(left, right):
            return f"{inner(left)} implies {inner(right)}"
        case f.Iff(left, right):
            # rtamt's own iff is a distance, and no positive one.
            return inner(f.Or((f.And((left, right)), f.And((f.Not(left), f.Not(right))))))
        case f.Next(operand):
            return f"eventually[1,1] {inner(operand)}"
        case f.Eventually(operand, interval):
            return f"eventually{interval} {inner(operand)}"
        case f.Always(operand, interval):
            return f"always{interval} {inner(operand)}"
        case f.Until(left, right, interval):
            reached = f.And((left, right)) if until == "closed" else right
            return f"{inner(left)} until{interval} {inner(reached)}"
        case f.Release(left, right, interval):
            return f"not {inner(f.Until(f.Not(left), f.Not(right), interval))}"
