"""The exact transducers in steps, saying what is true only when they are asked.

The planner searches transducers that take one edge each at every step (:mod:`mitlplan.automata.transducer`).
Those of :mod:`mitlplan.translation.seed.exact_transducers` must say for ever what is true, so no finite plan
would do. Here a reader asks for yes or no, at the instant of a step or also for the open phase behind it
(*kept*), and a transducer that is not asked may fall silent once it owes nothing. A plan is finished when
all are silent, so it satisfies the formula whatever follows. What is owed before:

- ``p U q``: where it said yes, q; where it said no, that p and q fail together before q comes.
- ``F[0,b] p``: where it said yes, p in time. Where it said no until an instant e, no p before e+b (*owed*);
  where it said no at e itself, none at e+b either (*sworn*).
- the delay: that everything it said is replayed.

Who is asked of an instant alone goes silent behind it. If it may be asked *again*, before it has paid all it
owes, it may go on speaking instead: no value holds at an instant alone.

The locations, and what joins them, are those of the exact transducers; a promise of yes does not ask what its
operand is until it is kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction

from mitlplan.automata.timed_automaton import exactly
from mitlplan.automata.transducer import Constraint, Edge, Guard, Location, Relation, Restless, Transducer

Signals = frozenset[str]
NONE: Signals = frozenset()


@dataclass(frozen=True, slots=True)
class Value:
    """Where a truth value is asked for, or, of a propositional formula, where it is found.

    Parameters
    ----------
    yes, no, kept
        Signals. For a label, `yes` or `no` is set by the map; otherwise readers set what they ask for.
    label
        Whether the present label decides.
    """

    yes: str
    no: str
    kept: str
    label: bool = False

    @property
    def negated(self) -> Value:
        """The value of the negation: no component is needed for it."""
        return replace(self, yes=self.no, no=self.yes)


def value(number: int, *, label: bool = False) -> Value:
    """The value with that number."""
    return Value(f"{number}.yes", f"{number}.no", f"{number}.kept", label)


class Asked(Enum):
    """What all readers together ask of a transducer in a step."""

    NOTHING = "nothing"
    YES_ONCE = "yes once"
    YES_KEPT = "yes kept"
    NO_ONCE = "no once"
    NO_KEPT = "no kept"

    def seen_in(self, signal: Value) -> tuple[Signals, Signals]:
        """The signals that must be set, and those that must not."""
        match self:
            case Asked.NOTHING:
                return NONE, frozenset({signal.yes, signal.no})
            case Asked.YES_ONCE:
                return frozenset({signal.yes}), frozenset({signal.no, signal.kept})
            case Asked.YES_KEPT:
                return frozenset({signal.yes, signal.kept}), frozenset({signal.no})
            case Asked.NO_ONCE:
                return frozenset({signal.no}), frozenset({signal.yes, signal.kept})
            case Asked.NO_KEPT:
                return frozenset({signal.no, signal.kept}), frozenset({signal.yes})


NOTHING = (Asked.NOTHING,)
YES = (Asked.YES_ONCE, Asked.YES_KEPT)
NO = (Asked.NO_ONCE, Asked.NO_KEPT)


@dataclass(frozen=True, slots=True)
class _Question:
    """What a transducer asks of an operand."""

    operand: Value
    truth: bool
    kept: bool = True

    def signals(self) -> tuple[Signals, Signals]:
        """The signals required, of a label, and those emitted, to ask a transducer."""
        answer = frozenset({self.operand.yes if self.truth else self.operand.no})
        if self.operand.label:
            return answer, NONE
        return NONE, answer | {self.operand.kept} if self.kept else answer


@dataclass(frozen=True, slots=True)
class _Way:
    """Under what conditions a location may be left in a certain manner."""

    source: str
    guard: Guard = ()
    asks: tuple[_Question, ...] = ()


@dataclass(frozen=True, slots=True)
class _Move:
    """Where to, when what is asked, asking what, not where a label says `without`."""

    target: str
    asked: tuple[Asked, ...]
    asks: tuple[_Question, ...] = ()
    without: Signals = NONE
    resets: Signals = NONE
    marked: bool = False


def _edges(output: Value, ways: Iterable[_Way], move: _Move) -> Iterator[Edge]:
    for way in ways:
        questions = [question.signals() for question in (*way.asks, *move.asks)]
        found = NONE.union(*(required for required, _ in questions))
        for asked in move.asked:
            requires, excludes = asked.seen_in(output)
            yield Edge(
                source=way.source,
                target=move.target,
                guard=way.guard,
                resets=move.resets,
                requires=requires | found,
                excludes=excludes | move.without,
                emits=NONE.union(*(emitted for _, emitted in questions)),
                marked=move.marked,
            )


def _last(output: Value, ways: Iterable[_Way], asked: tuple[Asked, ...], *asks: _Question) -> Iterator[Edge]:
    """Edges of a last step: the target does not matter."""
    for way in ways:
        yield from _edges(output, [way], _Move(way.source, asked, asks))


def root(mission: Value) -> Transducer:
    """Asks for yes at time 0, and for nothing later."""
    question = _Question(mission, truth=True, kept=False)
    requires, emits = question.signals()
    start = Edge("start", "done", requires=requires, emits=emits)
    done = Edge("done", "done")
    last = (replace(start, target="start"), done)
    return Transducer("the mission", (Location("start"), Location("done")), (start, done), last, last)


def conjunction(name: str, operands: tuple[Value, ...], output: Value) -> Transducer:
    """``p & q & ...``: asked for yes it asks all operands, asked for no it asks one; it has no memory."""
    here = [_Way("and")]
    moves = [_Move("and", NOTHING)]
    for asked, kept in ((Asked.YES_ONCE, False), (Asked.YES_KEPT, True)):
        everyone = tuple(_Question(operand, True, kept) for operand in operands)
        moves.append(_Move("and", (asked,), everyone))
    for asked, kept in ((Asked.NO_ONCE, False), (Asked.NO_KEPT, True)):
        moves += [_Move("and", (asked,), (_Question(operand, False, kept),)) for operand in operands]
    edges = tuple(edge for move in moves for edge in _edges(output, here, move))
    return Transducer(name, (Location("and"),), edges, endings=edges, parkings=edges)


def _without(operand: Value, truth: bool) -> Signals:
    """Labels at which a move is of no use, because there is a better one."""
    if not operand.label:
        return NONE
    return frozenset({operand.yes if truth else operand.no})


def _choice_of_time(*operands: Value) -> Restless:
    """A promise about a label is kept when the robot moves; one about a claim, when we choose to ask."""
    return Restless.NEVER if all(operand.label for operand in operands) else Restless.ALWAYS


def until(name: str, left: Value, right: Value, output: Value, *, until_the_end: bool) -> Transducer:
    """``left U right``, unbounded and standard.

    Parameters
    ----------
    until_the_end
        Whether "never" is as good as kept when the mission ends.
    """
    free = [_Way(source) for source in ("start", "neither", "reached", "silent")]
    promised, never = [_Way("promised")], [_Way("never")]
    arrived = _Question(right, truth=True, kept=False)
    failed = (_Question(left, truth=False, kept=False), _Question(right, truth=False, kept=False))
    stays = (_Question(left, truth=True),)
    absent = (_Question(right, truth=False),)
    holds = (_Question(right, truth=True),)
    fails = (_Question(left, truth=False), _Question(right, truth=False))
    better_yes, better_no = _without(right, True), _without(left, False)
    moves = (
        ([*free, *promised], _Move("reached", (Asked.YES_KEPT,), holds, marked=True)),
        ([*free, *promised], _Move("silent", (Asked.YES_ONCE,), (arrived,), marked=True)),
        (promised, _Move("silent", NOTHING, (arrived,), marked=True)),
        ([*free, *promised], _Move("promised", YES, stays, without=better_yes)),
        (promised, _Move("promised", NOTHING, stays, without=better_yes)),
        ([*free, *never], _Move("neither", (Asked.NO_KEPT,), fails, marked=True)),
        ([*free, *never], _Move("silent", (Asked.NO_ONCE,), failed, marked=True)),
        (never, _Move("silent", NOTHING, failed, marked=True)),
        ([*free, *never], _Move("never", NO, absent, without=better_no, marked=True)),
        (never, _Move("never", NOTHING, absent, without=better_no, marked=True)),
        (free, _Move("silent", NOTHING, marked=True)),
    )
    at_end = failed[1:] if until_the_end else failed
    return Transducer(
        name,
        (
            *(Location(quiet) for quiet in ("start", "neither", "reached", "silent")),
            Location("promised", restless=_choice_of_time(left, right)),
            Location("never", restless=_choice_of_time(left, right)),
        ),
        edges=tuple(edge for ways, move in moves for edge in _edges(output, ways, move)),
        endings=(
            *_last(output, free, NOTHING),
            *_last(output, [*free, *promised], YES, arrived),
            *_last(output, promised, NOTHING, arrived),
            *_last(output, [*free, *never], NO, *at_end),
            *_last(output, never, NOTHING, *at_end),
        ),
        parkings=(
            *_last(output, free, NOTHING),
            *_last(output, [*free, *promised], YES, *holds),
            *_last(output, promised, NOTHING, *holds),
            *_last(output, [*free, *never], NO, *absent),
            *_last(output, never, NOTHING, *absent),
        ),
        acceptance=True,
    )


def eventually_within(
    name: str, most: Fraction, operand: Value, output: Value, clock: str, *, again: bool = False
) -> Transducer:
    """``F_[0,most] operand``, for most > 0, with one clock; `again`: it is asked of more than one instant."""
    past = (Constraint(clock, Relation.GREATER, most),)
    over = (Constraint(clock, Relation.AT_LEAST, most),)
    in_time = (Constraint(clock, Relation.AT_MOST, most),)
    here_now = _Question(operand, truth=True, kept=False)
    none_now = _Question(operand, truth=False, kept=False)
    here, none = (_Question(operand, truth=True),), (_Question(operand, truth=False),)
    free = [
        *(_Way(source) for source in ("start", "now", "silent")),
        _Way("owed", over),
        _Way("sworn", past),
        _Way("sworn", exactly(clock, most), (none_now,)),
    ]
    hoping = [_Way("soon", in_time), _Way("due", exactly(clock, most))]
    denying = [_Way(source) for source in ("far", "owed", "sworn")]
    soon, due, far, owed, sworn = ([_Way(source)] for source in ("soon", "due", "far", "owed", "sworn"))
    started = frozenset({clock})
    moves = (
        ([*free, *hoping], _Move("now", (Asked.YES_KEPT,), here)),
        ([*free, *hoping], _Move("silent", (Asked.YES_ONCE,), (here_now,))),
        (hoping, _Move("silent", NOTHING, (here_now,))),
        (free, _Move("soon", YES, without=_without(operand, True), resets=started)),
        (soon, _Move("soon", NOTHING + YES, without=_without(operand, True))),
        ([*free, *denying], _Move("far", NO if again else (Asked.NO_KEPT,), none)),
        ([*free, *denying], _Move("sworn", (Asked.NO_ONCE,), none, resets=started)),
        (far, _Move("far", NOTHING, none)),
        (far, _Move("due", YES, none, resets=started)),
        (due, _Move("due", NOTHING + YES, none)),
        (far, _Move("owed", NOTHING, none, resets=started)),
        (owed, _Move("owed", NOTHING, none)),
        (sworn, _Move("sworn", NOTHING, none)),
        (free, _Move("silent", NOTHING)),
    )
    return Transducer(
        name,
        (
            *(Location(quiet) for quiet in ("start", "now", "silent", "owed", "sworn")),
            Location("soon", in_time, restless=_choice_of_time(operand)),
            Location("due", in_time, restless=_choice_of_time(operand)),
            Location("far", restless=Restless.ALWAYS),
        ),
        edges=tuple(edge for ways, move in moves for edge in _edges(output, ways, move)),
        endings=(
            *_last(output, free, NOTHING),
            *_last(output, [*free, *hoping], YES, here_now),
            *_last(output, hoping, NOTHING, here_now),
        ),
        parkings=(
            *_last(output, free, NOTHING),
            *_last(output, [*free, *hoping], YES, *here),
            *_last(output, hoping, NOTHING, *here),
            *_last(output, [*free, *denying], NO, *none),
            *_last(output, denying, NOTHING, *none),
        ),
    )


@dataclass(frozen=True, slots=True)
class _Line:
    """A state of the delay.

    Parameters
    ----------
    before
        Whether the first `seconds` of what is said are not over.
    head, waiting
        The number of the oldest outstanding edge of the guess, and how many there are.
    ended
        ``""`` while it still speaks; ``"open"`` or ``"closed"`` once it has fallen silent, before or after
        the value at that instant.
    """

    before: bool
    head: int
    waiting: int
    ended: str = ""

    @property
    def name(self) -> str:
        """The name of its location."""
        return f"{'start' if self.before else 'replay'}{self.head}.{self.waiting}{self.ended}"

    @property
    def replayed(self) -> bool:
        """The value that the operand must have now."""
        return self.head % 2 == 1

    @property
    def guessed(self) -> bool:
        """The value that is said now."""
        return (self.head + self.waiting) % 2 == 1


@dataclass(frozen=True, slots=True)
class DelayClocks:
    """The clocks of a delay: of the first seconds, of each outstanding edge, and since it fell silent."""

    start: str
    edges: tuple[str, ...]
    end: str


def delay(
    name: str, seconds: Fraction, operand: Value, output: Value, clocks: DelayClocks, *, again: bool = False
) -> Transducer:
    """The value of `operand` after `seconds`, guessed and then replayed.

    As :func:`mitlplan.translation.seed.exact_transducers.delay`, but it may begin late and fall silent.
    """
    return _Delay(seconds, operand, output, clocks, again).build(name)


class _Delay:
    def __init__(
        self, seconds: Fraction, operand: Value, output: Value, clocks: DelayClocks, again: bool
    ) -> None:
        self._seconds = seconds
        self._operand = operand
        self._output = output
        self._clocks = clocks
        self._again = again

    def build(self, name: str) -> Transducer:
        size = len(self._clocks.edges)
        states = [
            _Line(before, head, waiting, ended)
            for before, head in [(True, 0), (True, 1), *((False, head) for head in range(size))]
            for waiting in range(size + 1)
            for ended in ("", "open", "closed")
        ]
        edges = [*self._beginnings(), *(edge for state in states for edge in self._moves(state))]
        return Transducer(
            name,
            (Location("silent"), *(self._location(state) for state in states)),
            edges=tuple(edges),
            endings=tuple(edge for edge in edges if edge.target == "silent"),
            parkings=tuple(self._parkings(states)),
        )

    def _location(self, state: _Line) -> Location:
        if state.before:
            oldest = self._clocks.start
        elif state.waiting:
            oldest = self._clocks.edges[state.head]
        elif state.ended:
            oldest = self._clocks.end
        else:
            return Location(state.name, restless=Restless.ALWAYS)
        in_time = (Constraint(oldest, Relation.AT_MOST, self._seconds),)
        return Location(state.name, in_time, restless=Restless.ALWAYS)

    def _beginnings(self) -> Iterator[Edge]:
        silent = [_Way("silent")]
        yield from _edges(self._output, silent, _Move("silent", NOTHING))
        for head in (0, 1):
            begun = _Line(before=True, head=head, waiting=0)
            for ended, asked in (("", self._says(begun)), ("closed", self._once(begun))):
                resets = frozenset({self._clocks.start} | ({self._clocks.end} if ended else set()))
                move = _Move(replace(begun, ended=ended).name, asked, resets=resets)
                yield from _edges(self._output, silent, move)

    def _says(self, state: _Line) -> tuple[Asked, ...]:
        if self._again:
            return YES if state.guessed else NO
        return (Asked.YES_KEPT if state.guessed else Asked.NO_KEPT,)

    def _once(self, state: _Line) -> tuple[Asked, ...]:
        return (Asked.YES_ONCE if state.guessed else Asked.NO_ONCE,)

    def _moves(self, state: _Line) -> Iterator[Edge]:
        """First the oldest edge is replayed, or not; then the guess goes on, changes, or ends."""
        if state.before:
            yield from self._goes_on(_Way(state.name), state)
            due = exactly(self._clocks.start, self._seconds)
            yield from self._replays(state, replace(state, before=False), due)
        else:
            yield from self._replays(state, state, ())
        if state.waiting and not state.before:
            due = exactly(self._clocks.edges[state.head], self._seconds)
            following = (state.head + 1) % len(self._clocks.edges)
            shorter = replace(state, head=following, waiting=state.waiting - 1)
            yield from self._replays(state, shorter, due)
            if state.ended == "closed" and state.waiting == 1:
                yield from self._finishes(state, shorter, due)
        if state.ended and not state.waiting:
            yield from self._finishes(state, state, ())

    def _replays(self, source: _Line, state: _Line, guard: Guard) -> Iterator[Edge]:
        """The operand has the value that is replayed, until the next step at least."""
        compared = (_Question(self._operand, state.replayed),)
        yield from self._goes_on(_Way(source.name, guard, compared), state)

    def _goes_on(self, way: _Way, state: _Line) -> Iterator[Edge]:
        for move in self._guesses(state):
            yield from _edges(self._output, [way], move)

    def _guesses(self, state: _Line) -> Iterator[_Move]:
        if state.ended:
            yield _Move(state.name, NOTHING)
            return
        ended = frozenset({self._clocks.end})
        yield _Move(state.name, self._says(state) + NOTHING)
        yield _Move(replace(state, ended="closed").name, self._once(state), resets=ended)
        yield _Move(replace(state, ended="open").name, NOTHING, resets=ended)
        if state.waiting < len(self._clocks.edges):
            started = frozenset({self._clocks.edges[(state.head + state.waiting) % len(self._clocks.edges)]})
            longer = replace(state, waiting=state.waiting + 1)
            yield _Move(longer.name, self._says(longer) + NOTHING, resets=started)
            closed = replace(longer, ended="closed")
            yield _Move(closed.name, self._once(longer), resets=started | ended)

    def _finishes(self, source: _Line, state: _Line, guard: Guard) -> Iterator[Edge]:
        """Everything has been replayed; if the value at the end was said as well, it is checked now."""
        guard += exactly(self._clocks.end, self._seconds)
        if state.before:
            guard += exactly(self._clocks.start, self._seconds)
        last = (_Question(self._operand, state.replayed, kept=False),) if state.ended == "closed" else ()
        yield from _edges(self._output, [_Way(source.name, guard, last)], _Move("silent", NOTHING))

    def _parkings(self, states: list[_Line]) -> Iterator[Edge]:
        """If the operand never changes again, the guess is its value, and nothing else is outstanding."""
        silent = [_Way("silent")]
        yield from _last(self._output, silent, NOTHING)
        for truth in (False, True):
            constant = _Question(self._operand, truth)
            asked = YES if truth else NO
            yield from _last(self._output, silent, asked, constant)
            for state in states:
                if state.waiting == 0 and state.replayed == truth:
                    way = _Way(state.name)
                elif state.waiting == 1 and not state.before and state.replayed != truth:
                    way = _Way(state.name, exactly(self._clocks.edges[state.head], self._seconds))
                else:
                    continue
                may_ask = NOTHING if state.ended else NOTHING + asked
                yield from _last(self._output, [way], may_ask, constant)
