"""The normal form: what it looks like, and that no rewriting changes the truth or when it is known.

"Known" is meant as the judge means it: the sets of times at which a formula surely holds are the same before
and after, on signals that repeat and on signals that end, with both horizons.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Literal as Choice

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mitlplan.errors import FormulaError
from mitlplan.logic.core import FALSE, TRUE, Core, Literal, always, conjunction
from mitlplan.logic.formula import (
    MOST_LEVELS,
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
    operands_of,
)
from mitlplan.logic.interval import Interval
from mitlplan.logic.normalize import _core, co_safe, normalize, warnings, written
from mitlplan.logic.parse import parse
from mitlplan.logic.semantics import truth
from mitlplan.logic.show import show
from mitlplan.logic.signal import Signal
from tests.strategies import formulas, intervals, signals

Horizon = Choice["finite", "infinite"]
EITHER_HORIZON = pytest.mark.parametrize("horizon", ["finite", "infinite"])
EITHER_UNTIL = pytest.mark.parametrize("until", ["standard", "closed"])


def _known(formula: Formula, signal: Signal, horizon: Horizon) -> list[bool]:
    """Whether the formula surely holds, instant by instant and between: bounds and changes are halves."""
    times = truth(formula, signal, horizon="infinite" if signal.repeat_from is not None else horizon)
    return [Fraction(quarter, 4) in times for quarter in range(int(8 * signal.end) + 6)]


# ----------------------------------------------------------------------------------------- what it looks like


def _as_it_stands(text: str) -> Core:
    return _core(parse(text), positive=True, closed=False)


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("true", "true"),
        ("!(A & !B)", "!A | B"),
        ("A -> B", "!A | B"),
        ("!(A -> B)", "!B & A"),
        ("A <-> B", "!A & !B | A & B"),
        ("!(A <-> B)", "!A & B | !B & A"),
        ("!F[0,2] A", "G[0,2] !A"),
        ("!G(0,2) A", "F(0,2) !A"),
        ("!(A U[1,2] B)", "!A R[1,2] !B"),
        ("!(A R B)", "!A U !B"),
        ("X A", "F[1,1] A"),
        ("!X A", "F[1,1] !A"),
        ("G[2,2] A", "F[2,2] A"),
        ("X X A", "F[2,2] A"),
        ("F X A", "F[1,inf) A"),
        ("A W B", "B R (A | B)"),
        ("!(A W B)", "!B U (!A & !B)"),
        ("!A W A", "!A U A | G !A"),
        ("A W F B", "A U F B | G A"),
        ("F[0,0] A", "A"),
        ("G[5,inf) false", "G[5,inf) false"),
        ("A U[0,0] B", "B"),
        ("A & (B | A) & B", "(A | B) & A & B"),
        ("(A | B) & !A & !B", "false"),
        ("A & B | !A | !B", "true"),
        ("F (A & B | !A | !B)", "true"),
        # One until inside another
        ("F F A", "F A"),
        ("G G A", "G A"),
        ("F[1,2] F[3,4] A", "F[4,6] A"),
        ("F(1,2] F[3,4) A", "F(4,6) A"),
        ("F(0,1) F[0,2] A", "F(0,3) A"),
        ("G[1,2) G[3,4] A", "G[4,6) A"),
        ("G[1,2] G A", "G[1,2] G A"),
        ("G G[0,2] A", "G G[0,2] A"),
        ("A U (A U B)", "A U B"),
        ("A U[1,2](A U[0,1] B)", "A U[1,3] B"),
        ("A U (B U C)", "A U (B U C)"),
        ("A R[0,1](A R[2,3] B)", "A R[2,4] B"),
        # Side by side
        ("F A | F B", "F(A | B)"),
        ("F A | F !A", "F !A | F A"),
        ("G A & G B", "G(A & B)"),
        ("G[0,2] A & G[0,3] B", "G[0,2] A & G[0,3] B"),
        ("G A & G F B", "G F B & G A"),
        ("(!A U C) & (!B U C)", "(!A & !B) U C"),
        ("F[0,2] A & F[0,4] A", "F[0,2] A"),
        ("F[0,2] A & F[1,4] A", "F[0,2] A & F[1,4] A"),
        ("F[0,2] A | F(2,4) A", "F[0,4) A"),
        ("F[0,2) A | F(2,4) A", "F(2,4) A | F[0,2) A"),
        ("G[0,2] A & G[2,5] A & G(3,7] A", "G[0,7] A"),
        ("G[0,2] A | G[0,4] A", "G[0,2] A"),
        ("G[0,2] A & G A", "G A & G[0,2] A"),
        # Where G is asked once
        ("G(A & F[0,2] B & F C)", "G F C & G F[0,2] B & G A"),
        ("F[0,3] G(A & F[0,2] B)", "F[0,3] G(F[0,2] B & A)"),
        ("G[1,2] F[3,5] A", "G[4,5] F[0,2] A"),
        ("G(1,2) F(3,5] A", "G(4,5) F(0,2] A"),
        ("G[0,1] F[1,2] G[2,4] A", "G[3,4] F[0,1] G[0,2] A"),
        ("F[0,9] G[0,1] F[1,2] A", "F[0,9] G[1,2] F[0,1] A"),
        ("G[0,5](A | G[0,1] F[1,2] B)", "G[0,5](A | G[0,1] F[1,2] B)"),
        ("G F[3,5] A", "G F[3,5] A"),
    ],
)
def test_normal_forms(text: str, normal: str) -> None:
    assert normalize(parse(text)) == _as_it_stands(normal)


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("G F[3,5] A", "G[3,inf) F[0,2] A"),
        ("G F[1,2] G[2,4] A", "G[3,inf) F[0,1] G[0,2] A"),
        ("G[1,2] G A", "G[1,inf) A"),
        ("G G[0,2] A", "G A"),
        ("G[0,2] A & G A", "G A"),
        ("F[0,3] G F[1,2] A", "F[0,3] G[1,inf) F[0,1] A"),
        ("G F[1,2] G A", "G[1,inf) F[0,1] G A"),
    ],
)
def test_an_infinite_horizon_allows_more(text: str, normal: str) -> None:
    assert normalize(parse(text), horizon="infinite") == _as_it_stands(normal)


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("A U B", "A U (A & B)"),
        ("A R B", "A R (A | B)"),
        ("A W B", "(A & B) R A"),
        ("!(A U B)", "!A R (!A | !B)"),
        ("A W F B", "A U (F B & A) | G A"),
        ("!A U A", "false"),
        ("!A R A", "true"),
        ("A U[1,2] !A", "false"),
        ("F A & G B", "F A & G B"),
    ],
)
def test_the_closed_until_is_written_out(text: str, normal: str) -> None:
    assert normalize(parse(text), "closed") == _as_it_stands(normal)


@EITHER_UNTIL
@EITHER_HORIZON
@given(formula=formulas(depth=3, punctual=True))
def test_a_normal_form_stays_as_it_is(
    formula: Formula, until: Choice["standard", "closed"], horizon: Horizon
) -> None:
    core = normalize(formula, until, horizon=horizon)
    assert normalize(written(core), horizon=horizon) == core


# ------------------------------------------------------------------------------------ what it does not change


def _closed_written_out(formula: Formula) -> Formula:
    """The law of the closed until: ``p U (p & q)``, ``p R (p | q)``, word for word."""
    parts = [_closed_written_out(operand) for operand in operands_of(formula)]
    match formula:
        case Until(interval=interval):
            return Until(parts[0], And((parts[0], parts[1])), interval)
        case Release(interval=interval):
            return Release(parts[0], Or((parts[0], parts[1])), interval)
        case WeakUntil():
            return WeakUntil(parts[0], And((parts[0], parts[1])))
        case And():
            return And(tuple(parts))
        case Or():
            return Or(tuple(parts))
        case Implies():
            return Implies(*parts)
        case Iff():
            return Iff(*parts)
        case Not():
            return Not(*parts)
        case Next():
            return Next(*parts)
        case Eventually(interval=interval):
            return Eventually(parts[0], interval)
        case Always(interval=interval):
            return Always(parts[0], interval)
        case _:
            return formula


@EITHER_UNTIL
@given(formula=formulas(depth=3, longest=2, punctual=True), signal=signals(repeating=True))
def test_it_is_true_of_the_same_signals(
    formula: Formula, until: Choice["standard", "closed"], signal: Signal
) -> None:
    as_written = _closed_written_out(formula) if until == "closed" else formula
    for horizon in ("finite", "infinite"):
        normal = written(normalize(formula, until, horizon=horizon))
        assert _known(normal, signal, horizon) == _known(as_written, signal, horizon)


# Not with trivial parts: of `!A | F[0,0] A` the normal form knows that it will hold, the judge does not.
@EITHER_UNTIL
@EITHER_HORIZON
@given(
    formula=formulas(depth=3, longest=2, punctual=True, trivial=False),
    signal=signals(repeating=False),
)
def test_it_is_known_of_the_same_prefixes(
    formula: Formula, until: Choice["standard", "closed"], horizon: Horizon, signal: Signal
) -> None:
    as_written = _closed_written_out(formula) if until == "closed" else formula
    normal = written(normalize(formula, until, horizon=horizon))
    assert _known(normal, signal, horizon) == _known(as_written, signal, horizon)


def _sum(first: Interval, second: Interval) -> Interval:
    upper = None if first.upper is None or second.upper is None else first.upper + second.upper
    return Interval(
        first.lower + second.lower,
        upper,
        first.lower_open or second.lower_open,
        first.upper_open or second.upper_open,
    )


def _later(interval: Interval, delay: Fraction) -> Interval:
    return _sum(interval, Interval(delay, delay))


def _both_or_neither(first: Interval, second: Interval) -> bool:
    return (first.upper is None) == (second.upper is None)


parts = formulas(depth=2, longest=2, trivial=False)
subscripts = intervals(longest=2)
bounded = intervals(longest=2, unbounded=False)
any_signal = signals()


@EITHER_HORIZON
class TestIdentities:
    """The rules of identities.py, each with arbitrary formulas for its letters and every kind of interval."""

    @given(p=parts, q=parts, first=subscripts, second=subscripts, signal=any_signal)
    def test_an_until_in_an_until(
        self, horizon: Horizon, p: Formula, q: Formula, first: Interval, second: Interval, signal: Signal
    ) -> None:
        nested = Until(p, Until(p, q, second), first)
        assert _known(nested, signal, horizon) == _known(Until(p, q, _sum(first, second)), signal, horizon)

    @given(p=parts, q=parts, first=subscripts, second=subscripts, signal=any_signal)
    def test_a_release_in_a_release(
        self, horizon: Horizon, p: Formula, q: Formula, first: Interval, second: Interval, signal: Signal
    ) -> None:
        assume(horizon == "infinite" or _both_or_neither(first, second))
        nested = Release(p, Release(p, q, second), first)
        assert _known(nested, signal, horizon) == _known(Release(p, q, _sum(first, second)), signal, horizon)

    @given(p=parts, first=subscripts, second=subscripts, delay=st.integers(1, 4), signal=any_signal)
    def test_a_delay_moves_outwards(
        self, horizon: Horizon, p: Formula, first: Interval, second: Interval, delay: int, signal: Signal
    ) -> None:
        assume(horizon == "infinite" or first.upper is not None)
        time = Fraction(delay, 2)
        inner = Always(Eventually(p, _later(second, time)), first)
        outer = Always(Eventually(p, second), _later(first, time))
        assert _known(inner, signal, horizon) == _known(outer, signal, horizon)

    @given(p=parts, first=subscripts, second=bounded, third=bounded, signal=any_signal)
    def test_a_delay_moves_through_a_chain(
        self, horizon: Horizon, p: Formula, first: Interval, second: Interval, third: Interval, signal: Signal
    ) -> None:
        assume(horizon == "infinite" or first.upper is not None)
        one = Fraction(1)
        inner = Always(Eventually(Always(p, _later(third, one)), second), first)
        outer = Always(Eventually(Always(p, third), second), _later(first, one))
        assert _known(inner, signal, horizon) == _known(outer, signal, horizon)

    @given(p=parts, q=parts, interval=subscripts, signal=any_signal)
    def test_always_over_and(
        self, horizon: Horizon, p: Formula, q: Formula, interval: Interval, signal: Signal
    ) -> None:
        together, apart = Always(And((p, q)), interval), And((Always(p, interval), Always(q, interval)))
        assert _known(together, signal, horizon) == _known(apart, signal, horizon)

    @given(p=parts, q=parts, r=parts, interval=subscripts, signal=any_signal)
    def test_sides_that_combine_below_and(
        self, horizon: Horizon, p: Formula, q: Formula, r: Formula, interval: Interval, signal: Signal
    ) -> None:
        untils = And((Until(p, r, interval), Until(q, r, interval)))
        assert _known(untils, signal, horizon) == _known(Until(And((p, q)), r, interval), signal, horizon)
        releases = And((Release(r, p, interval), Release(r, q, interval)))
        assert _known(releases, signal, horizon) == _known(Release(r, And((p, q)), interval), signal, horizon)

    @given(r=parts, interval=subscripts, signal=any_signal)
    def test_sides_that_combine_below_or(
        self, horizon: Horizon, r: Formula, interval: Interval, signal: Signal
    ) -> None:
        p, q = Atom("A"), And((Not(Atom("A")), Atom("B")))
        untils = Or((Until(r, p, interval), Until(r, q, interval)))
        assert _known(untils, signal, horizon) == _known(Until(r, Or((p, q)), interval), signal, horizon)
        releases = Or((Release(p, r, interval), Release(q, r, interval)))
        assert _known(releases, signal, horizon) == _known(Release(Or((p, q)), r, interval), signal, horizon)

    @given(p=parts, q=parts, first=subscripts, signal=any_signal)
    def test_intervals_within_intervals(
        self, horizon: Horizon, p: Formula, q: Formula, first: Interval, signal: Signal
    ) -> None:
        wide = _sum(first, Interval(Fraction(0), Fraction(1), upper_open=True))
        untils = And((Until(p, q, first), Until(p, q, wide)))
        assert _known(untils, signal, horizon) == _known(Until(p, q, first), signal, horizon)
        releases = Or((Release(p, q, first), Release(p, q, wide)))
        assert _known(releases, signal, horizon) == _known(Release(p, q, first), signal, horizon)

    @given(p=parts, q=parts, first=bounded, second=subscripts, closed=st.booleans(), signal=any_signal)
    def test_intervals_that_touch(
        self,
        horizon: Horizon,
        p: Formula,
        q: Formula,
        first: Interval,
        second: Interval,
        closed: bool,
        signal: Signal,
    ) -> None:
        end = first.upper or Fraction(0)
        early = Interval(first.lower, end, first.lower_open, upper_open=not closed)
        late = Interval(end, None if second.upper is None else end + second.upper, closed, second.upper_open)
        whole = Interval(first.lower, late.upper, first.lower_open, second.upper_open)
        untils = Or((Until(p, q, early), Until(p, q, late)))
        assert _known(untils, signal, horizon) == _known(Until(p, q, whole), signal, horizon)
        assume(horizon == "infinite" or late.upper is not None)
        releases = And((Release(p, q, early), Release(p, q, late)))
        assert _known(releases, signal, horizon) == _known(Release(p, q, whole), signal, horizon)


# ----------------------------------------------------------------------------- co-safe, warnings and refusals


@pytest.mark.parametrize(
    ("text", "safe"),
    [
        ("(!A U B) & F A", True),
        ("F[2,4] A & F[0,2] B", True),
        ("G[0,3] !A & F B", True),
        ("F(A & F[2,2] A)", True),
        ("!G A", True),
        ("G F[0,2] A", False),
        ("G !B & F A", False),
        ("F G A", False),
        ("A W B", False),
        ("!(A U B)", False),
        ("F A | G B", False),
        ("true", True),
    ],
)
def test_co_safe(text: str, safe: bool) -> None:
    assert co_safe(normalize(parse(text))) is safe


@pytest.mark.parametrize(
    ("text", "node", "consequence", "left", "right"),
    [
        ("!A U A", "!A U A", "can never hold", "!A", "A"),
        ("G(B -> (A U[1,2] !(A | C))) & F(A U C)", "A U[1,2] !(A | C)", "can never hold", "A", "!(A | C)"),
        ("F B U (C & G !B)", "F B U (C & G !B)", "can never hold", "F B", "C & G !B"),
        ("C | (!A W A)", "!A W A", "can hold only if `!A` holds for ever", "!A", "A"),
        ("(!A U A) & F(!A U A)", "!A U A", "can never hold", "!A", "A"),
    ],
)
def test_sides_that_exclude_each_other(text: str, node: str, consequence: str, left: str, right: str) -> None:
    assert warnings(parse(text), "standard") == ()
    (warning,) = warnings(parse(text), "closed")
    assert warning == (
        f"`{node}` {consequence}: with the closed until `{left}` must still hold at the instant of "
        f"`{right}`, but excludes it; take the standard until, or change one side."
    )


def test_a_release_whose_sides_leave_nothing_out() -> None:
    (warning,) = warnings(parse("!(A R !A)"), "closed")
    assert warning == (
        "`A R !A` always holds: with the closed until it asks for `A` or `!A`, and one of them always holds; "
        "take the standard until, or change one side."
    )


@pytest.mark.parametrize("text", ["A U B", "A U (B | F A)", "G(A U B) | B R A", "A W B", "true U A"])
def test_sides_that_overlap(text: str) -> None:
    assert warnings(parse(text), "closed") == ()


def test_a_warning_is_kept_short() -> None:
    (warning,) = warnings(parse("A & " + "b" * 100 + " U !" + "b" * 100), "closed")
    assert warning.startswith(f"`{'b' * 57}...` can never hold: with the closed until `{'b' * 57}...` must")


def test_too_many_atoms_give_no_warning() -> None:
    many = " | ".join(f"cell{index}" for index in range(20))
    assert warnings(parse(f"({many}) U !({many})"), "closed") == ()


def test_formulas_that_were_built_are_checked_too() -> None:
    with pytest.raises(FormulaError) as refusal:
        normalize(And((Atom("B"), Always(Next(Atom("A"))))))
    assert str(refusal.value) == (
        "`X` asks for one exact instant, and here again and again (below G or W, left of U or right of R): "
        "that is outside MITL, and undecidable.\n"
        "  B & G X A\n"
        "        ^^^\n"
        "  hint: allow a little time: F[1,1.1] A"
    )


def test_a_formula_that_was_built_too_deep_is_refused() -> None:
    formula: Formula = Atom("A")
    for _ in range(10_000):
        formula = Not(formula)
    for refuse in (normalize, lambda deep: warnings(deep, "closed")):
        with pytest.raises(FormulaError, match="^The formula is nested more than 100 levels deep.$"):
            refuse(formula)


@EITHER_UNTIL
@pytest.mark.parametrize("opening", ["!", "F ", "G[0,1] ", "X ", "A & (B | (", "A U ", "A -> ", "B R[0,1] "])
def test_the_deepest_formulas_are_normalised(opening: str, until: Choice["standard", "closed"]) -> None:
    text = opening * ((MOST_LEVELS - 1) // max(1, opening.count("("))) + "C"
    text += ")" * text.count("(")
    core = normalize(parse(text), until)
    assert core not in (TRUE, FALSE)
    assert hash(core) == hash(normalize(parse(text), until))


@pytest.mark.parametrize(
    ("text", "until"),
    [
        ("A <-> (" * 60 + "B" + ")" * 60, "standard"),
        ("(" * 60 + "A W B" + ") W C" * 60, "standard"),
        ("(" * 60 + "A U B" + ") U C" * 60, "closed"),
    ],
)
def test_what_would_grow_exponentially_is_refused(text: str, until: Choice["standard", "closed"]) -> None:
    with pytest.raises(FormulaError) as refusal:
        normalize(parse(text), until)
    assert str(refusal.value) == (
        "Written with until and release only, the formula grows by more than 10000 parts.\n"
        f"  {show(parse(text))[:60]}...\n"
        "  ^\n"
        "  hint: nested <-> and W double at every level; write -> where one direction is enough"
    )


def test_ten_thousand_requirements_are_no_trouble() -> None:
    core = normalize(parse(" & ".join(f"G !cell{index}" for index in range(10_000))))
    assert core == always(conjunction(*(Literal(f"cell{index}", positive=False) for index in range(10_000))))


@pytest.mark.parametrize(
    ("text", "until", "parts"),
    [
        ("(A <-> B) & (B <-> C)", "standard", 4),
        # The inner one twice, with four copies of its sides: 1 + 3 + 3, and one more of C.
        ("(A <-> B) <-> C", "standard", 8),
        ("A W B", "standard", 2),
        ("A W B", "closed", 3),
        ("(A U B) U C", "standard", 0),
        ("(A U B) U C", "closed", 5),
        ("(A -> F[0,2] B) & G !C", "closed", 0),
    ],
)
def test_growth_is_counted_part_by_part(
    text: str, until: Choice["standard", "closed"], parts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As much as is allowed is taken, and one part more is refused."""
    monkeypatch.setattr("mitlplan.logic.normalize.MOST_COPIES", parts)
    normalize(parse(text), until)
    monkeypatch.setattr("mitlplan.logic.normalize.MOST_COPIES", parts - 1)
    with pytest.raises(FormulaError, match=f"grows by more than {parts - 1} parts"):
        normalize(parse(text), until)
