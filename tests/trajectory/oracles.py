"""Slow and independent ways to know what a unicycle does, where it is, and what is cheapest.

Integration by DOP853 from the controls alone, and direct collocation (CasADi and IPOPT), which knows nothing
of extremals: piecewise polynomial states, the equations of motion at the Legendre points, a general solver.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise, zip_longest
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from mitlplan.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]
Controls = Callable[[float], tuple[float, float]]
State = tuple[float, float, float]
Goal = tuple[float | None, float | None, float | None]


def strays(trajectory: Trajectory, step: Fraction) -> float:
    """How far outside the cell the robot ought to be in it ever is, in metres."""
    samples = trajectory.sample(step)
    grounds = [visit.ground for visit in trajectory.visits]
    x, y, width, height = np.array([(g.x, g.y, g.width, g.height) for g in grounds])[samples.visit].T
    outside = np.maximum(np.abs(samples.course.x - x) - width / 2, np.abs(samples.course.y - y) - height / 2)
    enters = np.array([float(visit.enter) for visit in trajectory.visits])
    within = samples.time < float(trajectory.end)
    assert (samples.time >= enters[samples.visit])[within].all()
    assert (samples.time < np.append(enters[1:], np.inf)[samples.visit])[within].all()
    return float(outside.max())


def clearance(trajectory: Trajectory, step: Fraction) -> float:
    """The least distance, in metres, to the border of the cell the robot is in, the doors it uses left out.

    The border is taken as many points; those in a door through which the robot came or will go are no wall.
    """
    samples = trajectory.sample(step)
    least = np.inf
    for number, visit in enumerate(trajectory.visits):
        here = samples.visit == number
        if not here.any():
            continue
        sides = np.linspace(-0.5, 0.5, 401)
        ends = np.full(sides.shape, 0.5)
        border = [(sides, ends), (sides, -ends), (ends, sides), (-ends, sides)]
        x = np.concatenate([across for across, _ in border]) * visit.ground.width + visit.ground.x
        y = np.concatenate([up for _, up in border]) * visit.ground.height + visit.ground.y
        wall = np.ones(x.shape, dtype=bool)
        # A loop goes on from its last visit to the one behind its first.
        beside = [
            *trajectory.visits[max(number - 1, 0) : number],
            *trajectory.visits[number + 1 : number + 2],
        ]
        if trajectory.repeat_from is not None and number == len(trajectory.visits) - 1:
            beside += [visit for visit in trajectory.visits if visit.enter == trajectory.repeat_from]
        for other in (one.ground for one in beside):
            inside_x = np.abs(x - other.x) < other.width / 2 - 1e-9
            inside_y = np.abs(y - other.y) < other.height / 2 - 1e-9
            shared_x = np.isclose(np.abs(x - other.x), other.width / 2)
            shared_y = np.isclose(np.abs(y - other.y), other.height / 2)
            wall &= ~((inside_x & shared_y) | (inside_y & shared_x))
        course = samples.course
        gaps = np.hypot(course.x[here, None] - x[wall], course.y[here, None] - y[wall])
        least = min(least, float(gaps.min()))
    return float(least)


def crosses_at_doors(trajectory: Trajectory) -> bool:
    """At the instant of each crossing the robot is in the middle of the edge that both cells share."""
    times = np.array([float(visit.enter) for visit in trajectory.visits[1:]])
    course = trajectory.sample_at(times).course
    for place, (before, after) in enumerate(zip(trajectory.visits, trajectory.visits[1:], strict=False)):
        a, b = before.ground, after.ground
        low = max(a.x - a.width / 2, b.x - b.width / 2), max(a.y - a.height / 2, b.y - b.height / 2)
        high = min(a.x + a.width / 2, b.x + b.width / 2), min(a.y + a.height / 2, b.y + b.height / 2)
        middle = (low[0] + high[0]) / 2, (low[1] + high[1]) / 2
        if (course.x[place], course.y[place]) != pytest.approx(middle, abs=1e-12):
            return False
    return True


def integrated(start: State, controls: Controls, times: Sequence[float]) -> State:
    """Where the controls lead; they may jump at each of `times`, which begins and ends the integration."""
    state = list(start)
    for begin, end in pairwise(times):
        # Just inside the piece: the controls at a jump are those of what follows it.
        inset = 1e-12 * (end - begin)

        def moved(
            time: float, now: Array, begin: float = begin + inset, end: float = end - inset
        ) -> list[float]:
            u, w = controls(min(max(time, begin), end))
            return [u * np.cos(now[2]), u * np.sin(now[2]), w]

        found = solve_ivp(moved, (begin, end), state, method="DOP853", rtol=1e-12, atol=1e-13)
        state = found.y[:, -1].tolist()
    return state[0], state[1], state[2]


def collocated(
    goals: Sequence[Goal],
    *,
    rho: float = 1.0,
    duration: float = 1.0,
    forward: bool = False,
    circles: Sequence[float | None] = (),
    elements: int = 12,
    degree: int = 5,
    seed: int = 0,
) -> float:
    """The least cost, in `duration` seconds, from the origin by way of all `goals`; ``None`` is free.

    The cost is the integral of ``rho * u**2 + w**2``. A phase leads to each goal, as long as is cheapest; on
    one of the `circles` the robot must go round with that radius.
    """
    import casadi

    points = np.append(0.0, casadi.collocation_points(degree, "legendre"))
    slope, close, weigh = _lagrange(points)
    problem = casadi.Opti()
    random = np.random.default_rng(seed)
    cost: Any = 0.0
    lengths = []
    now: Any = casadi.DM([0.0, 0.0, 0.0])
    guess = np.zeros(3)
    for goal, circle in zip_longest(goals, circles):
        length = problem.variable()
        problem.set_initial(length, duration / len(goals))
        problem.subject_to(length >= 0.01)
        lengths.append(length)
        wanted = np.array([random.normal() * 0.3 if value is None else value for value in goal])
        for element in range(elements):
            step = length / elements
            states = [now, *(problem.variable(3) for _ in range(degree))]
            controls = problem.variable(2, degree)
            problem.set_initial(controls, random.normal(size=(2, degree)) * 0.5 + 1)
            for place, state in enumerate(states[1:], start=1):
                share = (element + points[place]) / elements
                problem.set_initial(state, guess + (wanted - guess) * share + random.normal(size=3) * 0.05)
                u, w = controls[0, place - 1], controls[1, place - 1]
                if forward:
                    problem.subject_to(u >= 0)
                if circle is not None:
                    problem.subject_to(u == circle * w)
                motion = casadi.vertcat(u * casadi.cos(state[2]), u * casadi.sin(state[2]), w)
                problem.subject_to(
                    step * motion == sum(slope[r, place] * states[r] for r in range(degree + 1))
                )
                cost += weigh[place] * step * (rho * u**2 + w**2)
            now = problem.variable(3)
            problem.subject_to(now == sum(close[r] * states[r] for r in range(degree + 1)))
            problem.set_initial(now, guess + (wanted - guess) * (element + 1) / elements)
        for coordinate, value in enumerate(goal):
            if value is not None:
                problem.subject_to(now[coordinate] == value)
        guess = wanted
    problem.subject_to(sum(lengths) == duration)
    problem.minimize(cost)
    problem.solver(
        "ipopt", {"print_time": 0}, {"print_level": 0, "sb": "yes", "max_iter": 1000, "tol": 1e-11}
    )
    return float(problem.solve().value(cost))


def _lagrange(points: Array) -> tuple[Array, Array, Array]:
    """Derivatives at the points, values at 1 and integrals over [0, 1] of the Lagrange polynomials."""
    count = len(points)
    slope, close, weigh = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    for place in range(count):
        others = np.delete(points, place)
        polynomial = np.poly1d(others, r=True) / np.prod(points[place] - others)
        slope[place] = np.polyder(polynomial)(points)
        close[place] = polynomial(1.0)
        weigh[place] = np.polyint(polynomial)(1.0)
    return slope, close, weigh
