from __future__ import annotations

import io
from fractions import Fraction

import numpy as np
import pytest
from PIL import Image

from mitlplan.draw import Picture, animation, picture, rendered
from mitlplan.draw.ground import Geometry, draw_ground
from mitlplan.draw.way import even_step, robot_outline
from mitlplan.errors import WorkspaceError
from mitlplan.plan import Loop, Plan, Step
from mitlplan.trajectory import follow
from mitlplan.workspace import Move, Workspace, graph, grid
from tests.trajectory.strategies import lattice, plan_of

SQUARE = grid(2, 2, regions={"A": [(1, 0)], "B": [(0, 1)]})
PHI1 = plan_of(["r0c0", "r0c1", "r0c0", "r1c0"], [Fraction(1)] * 3)
PHI2 = plan_of(["r0c0", "r1c0"], [Fraction(1)] * 2, loop=0)


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def texts(drawn: Picture) -> set[str]:
    """What is written on a picture."""
    labels = {axis.get_ylabel() for axis in drawn.controls}
    return {text.get_text() for text in drawn.ground.texts} | {drawn.ground.get_title("left")} | labels


@pytest.mark.parametrize("plan", [PHI1, PHI2])
def test_a_trajectory_shows_cells_regions_times_and_controls(plan: Plan) -> None:
    drawn = picture(SQUARE, plan, follow(plan, SQUARE), title="a mission")
    written = texts(drawn)
    assert {"A", "B", "r0c0", "r1c1", "a mission", "speed u  [m/s]", "turn rate w  [rad/s]"} <= written
    assert {"0", "0.5", "1", "1.5"} <= written
    assert [axis.get_ylabel() for axis in drawn.controls][2] == "cell"
    assert len(drawn.controls) == 3


def test_the_strip_of_cells_is_the_plan_over_time() -> None:
    """A patch a stay, from its entry to its end, named where there is room."""
    trajectory = follow(PHI1, SQUARE)
    strip = picture(SQUARE, PHI1, trajectory).controls[2]
    begins = [float(visit.enter) for visit in trajectory.visits]
    assert [patch.get_x() for patch in strip.patches] == pytest.approx(begins)
    ends = [patch.get_x() + patch.get_width() for patch in strip.patches]
    assert ends == pytest.approx([*begins[1:], float(trajectory.end)])
    assert [text.get_text() for text in strip.texts] == ["r0c0", "r0c1\nB", "r0c0", "r1c0\nA"]


def test_a_plan_shows_when_each_cell_is_entered() -> None:
    assert {"0, 2 s", "1 s", "3 s"} <= texts(picture(SQUARE, PHI1))
    assert picture(SQUARE, PHI1).controls == ()


def test_the_controls_are_those_of_the_trajectory() -> None:
    trajectory = follow(PHI1, SQUARE)
    speed, turn_rate, _ = picture(SQUARE, None, trajectory).controls
    for axis, samples in (
        (speed, trajectory.sample(Fraction(1, 100)).course.u),
        (turn_rate, trajectory.sample(Fraction(1, 100)).course.w),
    ):
        curve = axis.lines[-1].get_ydata()
        assert np.max(curve) == pytest.approx(samples.max(), abs=0.05)
        assert np.min(curve) == pytest.approx(samples.min(), abs=0.05)


def test_the_same_picture_has_the_same_bytes() -> None:
    for kind in ("png", "svg", "pdf"):
        first, second = (rendered(picture(SQUARE, PHI1, follow(PHI1, SQUARE)), kind) for _ in range(2))
        assert first == second


def test_regions_have_their_colours_and_blocked_cells_are_dark() -> None:
    world = grid(1, 3, blocked=[(0, 1)], regions={"A": [(0, 0)]})
    data = pixels(rendered(picture(world), "png"))
    middle = data[data.shape[0] // 2]
    third = data.shape[1] // 3
    region, blocked, free = middle[third // 2], middle[third + third // 2], middle[2 * third + third // 2]
    assert blocked.max() < 100
    assert free.min() > 240
    assert region[2] < region[0] - 60


def test_a_large_grid_is_one_image_of_the_same_colours() -> None:
    large = grid(60, 60, blocked=[(0, 0)], regions={"A": [(59, 59)]})
    axes = picture(large).ground
    (image,) = axes.images
    colours = np.asarray(image.get_array())
    assert colours.shape == (60, 60, 3)
    assert colours[0, 0].max() < 0.4
    assert colours[59, 59].min() < colours[30, 30].min()
    assert not [collection for collection in axes.collections if len(collection.get_paths()) > 1]


def test_rectangles_are_drawn_where_they_lie() -> None:
    world = lattice([1.0, 2.5], [0.5, 1.0, 1.3])
    axes = picture(world, follow_plan()).ground
    assert Geometry.of(world).extent == (0.0, 3.5, 0.0, 2.8)
    assert axes.get_xlim() == (0.0, 3.5)
    assert axes.get_ylim() == (0.0, 2.8)


def follow_plan() -> Plan:
    return plan_of(["r0c0", "r0c1", "r1c1"], [Fraction(1)] * 2)


def test_parking_and_long_plans_can_be_drawn() -> None:
    parking = Plan(
        (Step("r0c0", Fraction(0), Fraction(1)), Step("r0c1", Fraction(1), None)), Fraction(1), Loop(1, None)
    )
    assert rendered(picture(SQUARE, parking), "png")
    there_and_back = [f"r0c{column}" for column in [*range(60), *range(58, -1, -1)]]
    long = plan_of(there_and_back, [Fraction(1)] * (len(there_and_back) - 1))
    assert "20" in texts(picture(grid(3, 60), long))


@pytest.mark.parametrize("world", [graph({"a": ["A"], "b": []}, [Move("a", "b")])])
def test_a_map_without_geometry_cannot_be_drawn(world: Workspace) -> None:
    with pytest.raises(WorkspaceError, match="cannot be drawn; use a grid"):
        picture(world)


def test_a_cell_of_another_map() -> None:
    with pytest.raises(WorkspaceError, match="no cell is called r5c5"):
        picture(SQUARE, plan_of(["r5c5"], [Fraction(1)]))


def test_an_animation_moves_the_robot_from_start_to_end() -> None:
    trajectory = follow(PHI1, SQUARE)
    film = Image.open(io.BytesIO(animation(SQUARE, trajectory, radius=0.2)))
    assert film.n_frames == 71
    durations, frames = [], []
    for number in (0, 35, 70):
        film.seek(number)
        durations.append(film.info["duration"])
        frames.append(np.asarray(film.convert("RGB")).astype(int))
    assert durations == [50, 50, 1200]
    assert film.info["loop"] == 0
    # The robot is the only dark thing that moves: first up on the left, at the end down on the left.
    height, width, _ = frames[0].shape
    dark = [(frame.max(axis=2) < 60)[:height, : width // 2] for frame in frames]
    first, last = dark[0] & ~dark[2], dark[2] & ~dark[0]
    assert np.argwhere(first).mean(axis=0)[0] < height / 2 < np.argwhere(last).mean(axis=0)[0]


def test_a_long_animation_is_no_longer_than_twelve_seconds() -> None:
    slow = plan_of(["r0c0", "r0c1", "r1c1"], [Fraction(50)] * 2)
    world = grid(2, 2, move_time=50)
    film = Image.open(io.BytesIO(animation(world, follow(slow, world))))
    assert film.n_frames == 241


@pytest.mark.parametrize(
    ("end", "most", "step"),
    [("7/2", 8, "1/2"), ("300", 16, "20"), ("1", 1, "1"), ("49/2", 16, "2"), ("0", 5, "1")],
)
def test_even_steps(end: str, most: int, step: str) -> None:
    assert even_step(Fraction(end), most) == Fraction(step)


def test_the_dart_points_where_the_robot_faces() -> None:
    tip = robot_outline(1.0, 2.0, np.pi / 2, 1.0)[0]
    assert tip.tolist() == pytest.approx([1.0, 3.3])


def test_the_ground_can_be_drawn_on_axes_of_ones_own() -> None:
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    draw_ground(axes, SQUARE)
    assert axes.get_xlim() == (0.0, 2.0)
