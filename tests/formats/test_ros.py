from __future__ import annotations

import json
import math
import time
from fractions import Fraction
from pathlib import Path

import pytest

from mitlplan.errors import OutputError
from mitlplan.formats.plan_json import plan_to_mapping
from mitlplan.formats.ros import PLAN_TOPIC, TRAJECTORY_TOPIC, Storage, write_bag
from mitlplan.plan import Plan
from mitlplan.trajectory import Trajectory, follow
from mitlplan.workspace import grid
from tests.trajectory.strategies import plan_of

rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")

STEP = Fraction(1, 10)
START = Fraction(3_500_000_001, 2)


@pytest.fixture
def driven() -> tuple[Plan, Trajectory]:
    plan = plan_of(["r0c0", "r0c1", "r1c1", "r1c0"], [Fraction(1)] * 3)
    return plan, follow(plan, grid(2, 2))


@pytest.mark.parametrize("storage", Storage)
def test_its_own_reader_reads_it(storage: Storage, driven: tuple[Plan, Trajectory], tmp_path: Path) -> None:
    plan, trajectory = driven
    write_bag(tmp_path / "bag", trajectory, plan, STEP, storage=storage, frame="depot", start=START)
    types = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    with rosbag2.Reader(tmp_path / "bag") as bag:
        assert {c.topic: c.msgtype for c in bag.connections} == {
            TRAJECTORY_TOPIC: "nav_msgs/msg/Path",
            PLAN_TOPIC: "std_msgs/msg/String",
        }
        for connection in bag.connections:
            (qos,) = connection.ext.offered_qos_profiles
            assert (qos.durability.name, qos.reliability.name) == ("TRANSIENT_LOCAL", "RELIABLE")
            assert (qos.history.name, qos.depth) == ("KEEP_LAST", 1)
        found = {c.topic: types.deserialize_cdr(raw, c.msgtype) for c, _, raw in bag.messages()}
    path = found[TRAJECTORY_TOPIC]
    samples = trajectory.sample(STEP)
    assert path.header.frame_id == "depot"
    assert len(path.poses) == len(samples.time) == 36
    for place, pose in enumerate(path.poses):
        assert pose.header.frame_id == "depot"
        stamp = pose.header.stamp.sec + Fraction(pose.header.stamp.nanosec, 10**9)
        assert float(stamp - START) == pytest.approx(samples.time[place], abs=1e-9)
        assert pose.pose.position.x == samples.course.x[place]
        assert pose.pose.position.y == samples.course.y[place]
        turn = pose.pose.orientation
        heading = 2 * math.atan2(turn.z, turn.w)
        assert math.remainder(heading - samples.course.heading[place], 2 * math.pi) == pytest.approx(
            0, abs=1e-12
        )
    assert json.loads(found[PLAN_TOPIC].data) == plan_to_mapping(plan)


def test_mcap_ros2_support_reads_it(driven: tuple[Plan, Trajectory], tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap_ros2.reader")
    plan, trajectory = driven
    write_bag(tmp_path / "bag", trajectory, plan, STEP, storage=Storage.MCAP)
    (file,) = (tmp_path / "bag").glob("*.mcap")
    found = {message.channel.topic: message.ros_msg for message in reader.read_ros2_messages(file)}
    path = found[TRAJECTORY_TOPIC]
    assert [pose.header.stamp.sec for pose in path.poses][::10] == [0, 1, 2, 3]
    assert path.poses[-1].pose.position.x == pytest.approx(0.5)
    assert json.loads(found[PLAN_TOPIC].data)["makespan"] == "3"


@pytest.mark.parametrize("storage", Storage)
def test_the_metadata_says_the_same(
    storage: Storage, driven: tuple[Plan, Trajectory], tmp_path: Path
) -> None:
    plan, trajectory = driven
    write_bag(tmp_path / "bag", trajectory, plan, STEP, storage=storage)
    text = (tmp_path / "bag" / "metadata.yaml").read_text()
    assert f"storage_identifier: {storage.value}" in text
    assert "durability: 1" in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bag"]


def test_what_exists_is_left_alone(driven: tuple[Plan, Trajectory], tmp_path: Path) -> None:
    plan, trajectory = driven
    with pytest.raises(OutputError, match="it exists; a bag is a new folder"):
        write_bag(tmp_path, trajectory, plan, STEP)
    (tmp_path / "file").write_text("kept")
    with pytest.raises(OutputError, match="it exists"):
        write_bag(tmp_path / "file", trajectory, plan, STEP)
    assert (tmp_path / "file").read_text() == "kept"
    with pytest.raises(OutputError, match="there is no folder"):
        write_bag(tmp_path / "nowhere" / "bag", trajectory, plan, STEP)


@pytest.mark.parametrize("storage", Storage)
@pytest.mark.parametrize("stopped", ["at the second message", "at the end"])
def test_a_bag_is_written_whole_or_not_at_all(
    storage: Storage,
    stopped: str,
    driven: tuple[Plan, Trajectory],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan, trajectory = driven
    written: list[object] = []
    write = rosbag2.Writer.write

    def interrupted(self: object, *message: object) -> None:
        if written:
            raise KeyboardInterrupt
        written.append(message)
        write(self, *message)

    def no_space(*_: object) -> None:
        raise OSError(28, "No space left on device")

    if stopped == "at the end":
        monkeypatch.setattr(Path, "rename", no_space)
        with pytest.raises(OutputError, match="cannot write .*bag: No space left on device"):
            write_bag(tmp_path / "bag", trajectory, plan, STEP, storage=storage)
    else:
        monkeypatch.setattr(rosbag2.Writer, "write", interrupted)
        with pytest.raises(KeyboardInterrupt):
            write_bag(tmp_path / "bag", trajectory, plan, STEP, storage=storage)
        assert written
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_appears_meanwhile_is_left_alone(
    driven: tuple[Plan, Trajectory], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan, trajectory = driven
    close = rosbag2.Writer.close

    def slow(self: object) -> None:
        close(self)
        (tmp_path / "bag").mkdir()
        (tmp_path / "bag" / "kept").touch()

    monkeypatch.setattr(rosbag2.Writer, "close", slow)
    with pytest.raises(OutputError, match="cannot write"):
        write_bag(tmp_path / "bag", trajectory, plan, STEP)
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]
    assert [path.name for path in (tmp_path / "bag").iterdir()] == ["kept"]


def test_twenty_thousand_poses_take_little_time(driven: tuple[Plan, Trajectory], tmp_path: Path) -> None:
    plan, trajectory = driven
    begin = time.perf_counter()
    write_bag(tmp_path / "bag", trajectory, plan, Fraction(35, 200_000))
    assert time.perf_counter() - begin < 10
