"""Several voices on one random case, and what they must agree on.

* The **engine** (compact construction): every plan is a walk on the map, ends when it says, and satisfies the
  mission according to the **judge**; where it says "infeasible", no other voice has a plan.
* The **tick oracle**: where every stay has a given length it is exact: same answer, same least makespan, as
  few moves, and an infimum where the oracle needs half a tick. Elsewhere the engine is at least as fast.
* The **seed construction** with the same search: the same least makespan wherever it can say the formula.
* **A robot without a choice** shows one signal: the engine has a plan exactly if the judge says that it
  satisfies the mission.
* On a random signal, which no planner chose and which may well violate the mission, judge, progression and
  (of closed, bounded formulas) **rtamt** say the same. So a judge that is too lenient is heard of too.
* A formula means the same as what it is rewritten as, has the signals that the judge says it has, and none if
  it is unsatisfiable.

Every opinion that was given is counted: a voice that never votes would agree with anything.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import compress, permutations, product
from math import floor, lcm

from mitlplan.errors import MitlplanError, TranslationError
from mitlplan.logic.formula import Formula, Iff, Not, Release, Until
from mitlplan.logic.interval import ALWAYS
from mitlplan.logic.semantics import satisfies
from mitlplan.logic.signal import Segment, Signal
from mitlplan.mission import Mission, Requirement
from mitlplan.plan import Infeasible, LimitReached, Outcome, Plan
from mitlplan.planner import Satisfiable, Unsatisfiable, equivalent, plan, satisfiable, valid
from mitlplan_fuzz.formulas import UntilKind, parts, text_of
from mitlplan_fuzz.missions import Case, FormulaCase, Horizon, MissionCase, SmallMission
from mitlplan_fuzz.oracles.path_checker import fault_in_path
from mitlplan_fuzz.oracles.progression import (
    OPEN,
    POINT,
    Cycle,
    Progression,
    TooLargeError,
    co_safe,
    holds_at_the_end,
    need_of,
)
from mitlplan_fuzz.oracles.rtamt_voice import monitored, reach, rtamt_is_there, speaks_of
from mitlplan_fuzz.oracles.tick_planner import Answer, Least, NoneUpTo, least_by_progression

LONGEST = 20.0
"""Seconds that the engine gets for a mission: most take a hundredth of one."""

LONGEST_FOR_SEED = 1.0
"""Seconds for the seed construction, whose automata are larger: if it is not done by then, it has no say."""

LONGEST_FOR_FORMULA = 5.0
"""Seconds for each question on a formula alone."""

SIGNALS = 3
"""Random signals on each case."""


@dataclass
class Verdict:
    """What came of one case.

    Parameters
    ----------
    disagreements
        A sentence on each.
    gave_up
        Whether the engine reached a limit where another voice had an answer: no error, but worth a look.
    votes
        How often each voice gave an opinion.
    """

    disagreements: list[str] = field(default_factory=list)
    gave_up: bool = False
    votes: Counter[str] = field(default_factory=Counter)


def verdict_on(case: Case, *, longest: float = LONGEST, seed: int = 0) -> Verdict:
    """Ask every voice about a case; `seed` draws the signals."""
    verdict = Verdict()
    stream = random.Random(seed)
    match case:
        case MissionCase(mission, factor):
            asked = mission_of(mission.scaled(factor))
            outcome = _in_seconds(plan(asked, time_limit=longest), factor)
            verdict.disagreements += _on_mission(mission, outcome, verdict)
            verdict.disagreements += _by_seed_construction(asked, factor, outcome, verdict)
            verdict.disagreements += _conflict(asked, outcome, longest, verdict)
            formula, until, names = mission.formula, mission.until, ("A", "B", "C")
        case FormulaCase(formula, _, names, until):
            verdict.disagreements += _on_formula(case, stream, verdict)
    for _ in range(SIGNALS):
        verdict.disagreements += _on_signal(formula, until, _random_word(stream, names), verdict)
    return verdict


def disagreements(small: SmallMission, *, longest: float = LONGEST, may_give_up: bool = False) -> list[str]:
    """Every sentence on which engine, oracle and judge differ on a mission; empty if all is well."""
    verdict = Verdict()
    outcome = plan(mission_of(small), time_limit=longest)
    found = list(_on_mission(small, outcome, verdict))
    if verdict.gave_up and not may_give_up:
        found.append(f"the engine gives up, the oracle does not: {outcome}")
    return found


# --- The engine and the tick oracle ------------------------------------------------------------------------


def mission_of(small: SmallMission) -> Mission:
    """The mission as the product reads it."""
    return Mission(
        workspace=small.workspace(),
        start=small.start_index,
        spec=tuple(Requirement(name, text_of(part), part) for name, part in small.requirements),
        horizon=small.horizon,
        until=small.until,
    )


def bound_for(small: SmallMission) -> int:
    """How far the oracle looks, in seconds: freedom in time multiplies the plans."""
    return 8 if small.tick_timed else 6 if small.waiting else 5


def instants_decide(small: SmallMission) -> bool:
    """Whether a single instant may decide, so that an infimum may not be attained.

    It may where an interval leaves out one of its finite ends, and under a standard until or release that
    begins later: ``p`` is asked for up to the instant at which ``q`` holds, which may be its last.
    """
    for part in parts(small.formula):
        interval = getattr(part, "interval", ALWAYS)
        if interval.lower_open or (interval.upper_open and interval.upper is not None):
            return True
        if isinstance(part, (Until, Release)) and interval.lower > 0 and small.until == "standard":
            return True
    return False


def oracle(small: SmallMission, bound: int) -> Answer | None:
    """What the oracle answers, ``None`` if the formula is too large for it."""
    try:
        return least_by_progression(
            small.workspace(),
            small.start_index,
            small.formula,
            bound=bound,
            until=small.until,
            horizon=small.horizon,
            resolution=2 if instants_decide(small) else 1,
        )
    except TooLargeError:
        return None


def _in_seconds(outcome: Outcome, factor: Fraction) -> Outcome:
    """The answer to a mission whose times were multiplied, in the times of the mission itself."""

    def own(time: Fraction | None) -> Fraction | None:
        return None if time is None else time / factor

    match outcome:
        case Plan(steps=steps, makespan=makespan, loop=loop, epsilon=epsilon, bound=bound):
            return replace(
                outcome,
                steps=tuple(
                    replace(step, enter=step.enter / factor, leave=own(step.leave), slack=own(step.slack))
                    for step in steps
                ),
                makespan=makespan / factor,
                loop=None if loop is None else replace(loop, period=own(loop.period)),
                epsilon=own(epsilon),
                bound=own(bound),
            )
        case LimitReached(bound=bound):
            return replace(outcome, bound=own(bound))
        case Infeasible():
            return outcome


def _on_mission(small: SmallMission, outcome: Outcome, verdict: Verdict) -> Iterator[str]:
    verdict.votes["engine"] += not isinstance(outcome, LimitReached)
    answer = oracle(small, bound_for(small))
    verdict.votes["oracle"] += answer is not None
    if isinstance(outcome, LimitReached):
        verdict.gave_up = isinstance(answer, Least) or small.forced
        return
    match outcome:
        case Plan():
            yield from faults(small, outcome)
            yield from _rtamt_on_plan(small, outcome, verdict)
            if answer is not None:
                yield from _against_oracle(small, outcome, answer)
        case Infeasible():
            if isinstance(answer, Least):
                yield f"the engine says infeasible, the oracle has {answer}"
    if small.forced and small.horizon == "infinite":
        verdict.votes["one walk"] += 1
        holds = satisfies(small.formula, _only_signal(small), until=small.until)
        if holds != isinstance(outcome, Plan):
            yield f"on the only walk the judge says {holds}, the engine {type(outcome).__name__}"


def faults(small: SmallMission, found: Plan) -> Iterator[str]:
    """What is wrong with a plan by itself."""
    stays = [(step.cell, step.enter) for step in found.steps]
    end = found.steps[-1].leave
    target = None
    if found.loop is not None and found.loop.period is not None:
        target = found.steps[found.loop.start].cell
    fault = fault_in_path(small, stays, end, target)
    if fault is not None:
        yield fault
        return
    if any(step.leave != after.enter for step, after in zip(found.steps, found.steps[1:], strict=False)):
        yield "a step does not end where the next begins"
    labels = dict(small.cells)
    if any(step.holds != tuple(sorted(labels[step.cell])) for step in found.steps):
        yield "a step shows other propositions than its cell carries"
    yield from _faults_in_time(small, found, found.steps[-1].enter if end is None else end)
    signal = signal_of_plan(small, found)
    if not satisfies(small.formula, signal, until=small.until, horizon=small.horizon):
        yield "the judge rejects the plan"
    word = _word_of(signal)
    if word is not None and not _progressed(small.formula, word, small.until, small.horizon):
        yield "progression rejects the plan"


def _faults_in_time(small: SmallMission, found: Plan, end: Fraction) -> Iterator[str]:
    if found.attained and end != found.makespan:
        yield f"the plan ends at {end}, not at its makespan"
    if not found.attained and not found.makespan < end <= found.makespan + (found.epsilon or 0):
        yield f"the plan ends at {end}, which is no answer to an infimum of {found.makespan}"
    finite_only = small.horizon == "finite" or co_safe(small.formula)
    if finite_only and found.loop is not None:
        yield "a finite plan was asked for"


def signal_of_plan(small: SmallMission, found: Plan) -> Signal:
    """What the robot shows, by the labels of the mission itself."""
    labels = dict(small.cells)
    segments = tuple(Segment(step.enter, frozenset(labels[step.cell])) for step in found.steps)
    end = found.steps[-1].leave
    match found.loop:
        case None:
            assert end is not None
            return Signal(segments, end)
        case loop if end is None:
            return Signal(segments, segments[-1].start + 1, repeat_from=segments[-1].start)
        case loop:
            return Signal(segments, end, repeat_from=found.steps[loop.start].enter)


def _moves(found: Plan) -> int:
    """The moves up to the makespan, the one that closes a loop included."""
    return len(found.steps) - (found.loop is None or found.loop.period is None)


def _against_oracle(small: SmallMission, found: Plan, answer: Answer) -> Iterator[str]:
    bound = found.makespan if found.bound is None else found.bound
    match answer:
        case Least(makespan) if not small.tick_timed:
            if bound > makespan or (found.makespan > makespan and bound == found.makespan):
                yield f"the engine is slower than the oracle: {answer}"
            elif found.makespan == bound == makespan and not found.attained:
                yield f"the engine takes for an infimum what is attained: {answer}"
        case Least(makespan):
            least, attained = Fraction(floor(makespan)), makespan.denominator == 1
            proved = bound == found.makespan
            if proved and (found.makespan, found.attained) != (least, attained):
                yield f"another least makespan: {answer}"
            elif proved and attained and _moves(found) != answer.moves:
                yield f"not the fewest moves: {answer}"
            if not bound <= least <= found.makespan:
                yield f"the least makespan is not where the engine says: {answer}"
        case NoneUpTo(limit) if small.tick_timed:
            if found.makespan < limit or (found.makespan == limit and found.attained):
                yield f"the oracle finds nothing up to {limit}"


def _only_signal(small: SmallMission) -> Signal:
    """What a robot without a choice shows."""
    labels, way = dict(small.cells), {origin: (target, time) for origin, target, time, _ in small.moves}
    entered: dict[str, Fraction] = {}
    cell, now = small.start, Fraction(0)
    segments = []
    while cell not in entered:
        entered[cell] = now
        segments.append(Segment(now, frozenset(labels[cell])))
        cell, stay = way[cell]
        now += stay
    return Signal(tuple(segments), now, repeat_from=entered[cell])


# --- The seed construction, and conflicts ------------------------------------------------------------------


def _by_seed_construction(
    asked: Mission, factor: Fraction, outcome: Outcome, verdict: Verdict
) -> Iterator[str]:
    if isinstance(outcome, LimitReached):
        return
    try:
        other = _in_seconds(plan(asked, construction="seed", time_limit=LONGEST_FOR_SEED), factor)
    except TranslationError:
        return
    if isinstance(other, LimitReached):
        return
    verdict.votes["seed construction"] += 1
    match outcome, other:
        case (Infeasible(), Infeasible()):
            return
        case (Plan(), Plan()):
            proved = all(each.bound == each.makespan for each in (outcome, other))
            answers = {(each.makespan, each.attained) for each in (outcome, other)}
            if proved and len(answers) == 1:
                return
            if not proved and max(one.bound or Fraction(0) for one in (outcome, other)) <= min(
                one.makespan for one in (outcome, other)
            ):
                return
    yield f"the seed construction answers {_summary(other)}, the engine {_summary(outcome)}"


def _summary(outcome: Outcome) -> str:
    match outcome:
        case Plan(makespan=makespan, attained=attained, bound=bound):
            return f"a plan of {makespan} (attained: {attained}, bound: {bound})"
        case other:
            return type(other).__name__.lower()


def _conflict(asked: Mission, outcome: Outcome, longest: float, verdict: Verdict) -> Iterator[str]:
    """The requirements that are said to exclude each other do, and no fewer of them."""
    if not isinstance(outcome, Infeasible) or len(asked.spec) < 2:
        return
    if sum(outcome.statistics.seconds.values()) >= longest:
        # It was stopped before it had left out all that it can.
        verdict.gave_up = True
        return
    verdict.votes["conflict"] += 1
    named = tuple(requirement for requirement in asked.spec if requirement.name in outcome.conflict)
    if len(named) != len(outcome.conflict) or not named:
        yield f"the conflict {outcome.conflict} is not made of requirements"
    for dropped in (None, *named) if len(named) > 1 else (None,):
        spec = tuple(requirement for requirement in named if requirement is not dropped)
        answer = plan(replace(asked, spec=spec), time_limit=LONGEST_FOR_SEED)
        if dropped is None and isinstance(answer, Plan):
            yield f"the conflict {outcome.conflict} is none: {_summary(answer)}"
        if dropped is not None and isinstance(answer, Infeasible):
            yield f"the conflict {outcome.conflict} needs no {dropped.name}"


# --- Random signals ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Word:
    """A signal on ticks: one label a tick; it goes on at `repeat`, or is unknown after its last point.

    Parameters
    ----------
    labels
        Of each tick; of a word without `repeat` the last label is known at its first instant only.
    ticks
        How many make a second.
    """

    labels: tuple[frozenset[str], ...]
    repeat: int | None
    ticks: int = 1

    def signal(self) -> Signal:
        """As the judge takes it."""
        tick = Fraction(1, self.ticks)
        segments = tuple(Segment(number * tick, label) for number, label in enumerate(self.labels))
        if self.repeat is None:
            return Signal(segments, (len(self.labels) - 1) * tick)
        return Signal(segments, len(self.labels) * tick, repeat_from=self.repeat * tick)

    def at(self, tick: int) -> frozenset[str]:
        """The label of a tick, however far away."""
        if tick < len(self.labels):
            return self.labels[tick]
        assert self.repeat is not None
        return self.labels[self.repeat + (tick - self.repeat) % (len(self.labels) - self.repeat)]


MOST_TICKS = 60


def _word_of(signal: Signal) -> Word | None:
    """The signal on ticks, if a second has few of them and it is short."""
    times = [*(segment.start for segment in signal.segments), signal.end]
    times += [] if signal.repeat_from is None else [signal.repeat_from]
    ticks = lcm(*(time.denominator for time in times))
    last = int(signal.end * ticks)
    if last > MOST_TICKS:
        return None
    known = last + (signal.repeat_from is None)
    labels = []
    for tick in range(known):
        time = Fraction(tick, ticks)
        labels.append([segment.holds for segment in signal.segments if segment.start <= time][-1])
    repeat = None if signal.repeat_from is None else int(signal.repeat_from * ticks)
    return Word(tuple(labels), repeat, ticks)


def _random_word(stream: random.Random, names: Sequence[str]) -> Word:
    length = stream.randrange(1, 7)
    labels = [frozenset(name for name in names if stream.random() < 0.5) for _ in range(length)]
    repeat = None if stream.random() < 0.3 else stream.randrange(length)
    return Word(tuple(labels), repeat)


def _progressed(formula: Formula, word: Word, until: UntilKind, horizon: Horizon = "infinite") -> bool | None:
    """What progression says of a word; ``None`` if the formula is too large for it."""
    progression = Progression(need_of(formula, until=until, scale=Fraction(word.ticks)))
    owed = progression.initial
    known = len(word.labels) - 1 if word.repeat is None else word.repeat
    try:
        for label in word.labels[:known]:
            owed = progression.step(progression.step(owed, label, POINT), label, OPEN)
        if word.repeat is not None:
            return Cycle(word.labels[word.repeat :]).pays(progression, owed)
        after = progression.step(owed, word.labels[-1], POINT)
    except TooLargeError:
        return None
    return after == 1 or (horizon == "finite" and holds_at_the_end(progression.residual(after)))


def _on_signal(formula: Formula, until: UntilKind, word: Word, verdict: Verdict) -> Iterator[str]:
    judged = satisfies(formula, word.signal(), until=until)
    verdict.votes["judge"] += 1
    progressed = _progressed(formula, word, until)
    verdict.votes["progression"] += progressed is not None
    if progressed is not None and progressed != judged:
        yield f"the judge says {judged}, progression {progressed} of {word}"
    if word.repeat is not None and rtamt_is_there() and speaks_of(formula, until):
        verdict.votes["rtamt"] += 1
        heard = _heard(formula, [word.at(tick) for tick in range(reach(formula) + 2)], until)
        if heard != judged:
            yield f"the judge says {judged}, rtamt {heard} of {word}"


def _heard(formula: Formula, labels: Sequence[frozenset[str]], until: str) -> bool:
    names = sorted({name for label in labels for name in label} | set("ABC"))
    return monitored(formula, labels, names, until)


def _rtamt_on_plan(small: SmallMission, found: Plan, verdict: Verdict) -> Iterator[str]:
    """Rtamt must be content with a plan, whatever follows a finite one."""
    if not (rtamt_is_there() and speaks_of(small.formula, small.until)):
        return
    word = _word_of(signal_of_plan(small, found))
    if word is None or word.ticks > 1:
        return
    verdict.votes["rtamt"] += 1
    ahead = range(reach(small.formula) + 2)
    if word.repeat is not None:
        runs = [[word.at(tick) for tick in ahead]]
    else:
        follow: tuple[frozenset[str], ...] = (frozenset(), frozenset("ABC"))
        runs = [
            [*word.labels, *([label] * len(ahead))][: max(len(ahead), len(word.labels))] for label in follow
        ]
    for labels in runs:
        if not _heard(small.formula, labels, small.until):
            yield f"rtamt rejects the plan, of which it sees {labels}"


# --- Formulas alone ----------------------------------------------------------------------------------------


def _on_formula(case: FormulaCase, stream: random.Random, verdict: Verdict) -> Iterator[str]:
    for question in (satisfiable, valid):
        try:
            answer = question(case.formula, until=case.until, time_limit=LONGEST_FOR_FORMULA)
        except MitlplanError:
            # The negation may ask for instants again and again, which is no MITL.
            continue
        name = question.__name__
        asked = case.formula if question is satisfiable else Not(case.formula)
        match answer:
            case LimitReached():
                verdict.gave_up = True
            case Satisfiable(signal):
                verdict.votes[name] += 1
                word = _word_of(signal)
                if word is not None and _progressed(asked, word, case.until) is False:
                    yield f"{name}: progression rejects the witness {word}"
            case Unsatisfiable():
                verdict.votes[name] += 1
                yield from _no_signal(asked, case, stream, name)
    both = Iff(case.formula, case.rewritten)
    try:
        answer = equivalent(case.formula, case.rewritten, until=case.until, time_limit=LONGEST_FOR_FORMULA)
    except MitlplanError:
        answer = LimitReached("no MITL")
    match answer:
        case Satisfiable(signal):
            yield f"not equivalent to what it is rewritten as: {signal}"
        case Unsatisfiable():
            verdict.votes["equivalent"] += 1
    for _ in range(SIGNALS):
        word = _random_word(stream, case.names)
        if word.repeat is not None and not satisfies(both, word.signal(), until=case.until):
            yield f"the judge tells it from what it is rewritten as, by {word}"


def _no_signal(asked: Formula, case: FormulaCase, stream: random.Random, name: str) -> Iterator[str]:
    """Signals that should not be there: random ones, and whatever brute force finds on ticks."""
    for _ in range(5 * SIGNALS):
        word = _random_word(stream, case.names)
        if satisfies(asked, word.signal(), until=case.until):
            yield f"{name}: the engine says that there is no signal, the judge accepts {word}"
            return
    for mission in _anything(asked, case):
        answer = oracle(mission, 3)
        if isinstance(answer, Least):
            yield f"{name}: the engine says that there is no signal, the oracle has {answer}"
            return


def _anything(asked: Formula, case: FormulaCase) -> Iterator[SmallMission]:
    """Maps on which anything may happen at any whole time, one for each label to begin with."""
    rows = product((False, True), repeat=len(case.names))
    labels = [tuple(compress(case.names, row)) for row in rows]
    cells = tuple((f"c{index}", label) for index, label in enumerate(labels))
    one = Fraction(1)
    moves = tuple((origin, target, one, one) for (origin, _), (target, _) in permutations(cells, 2))
    for start, _ in cells:
        yield SmallMission(cells, moves, waiting=True, start=start, formula=asked, until=case.until)
