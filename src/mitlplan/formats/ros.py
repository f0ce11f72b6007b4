"""Plans and trajectories as ROS 2 bags, written and readable without ROS.

Two topics: ``/trajectory``, a ``nav_msgs/msg/Path`` whose poses are stamped with the time at which the robot
is there, and ``/plan_json``, a ``std_msgs/msg/String`` that holds the plan as ``plan --format json`` writes
it. Both are offered as reliable and transient local with a depth of 1: a subscriber that comes late still
gets the one message. The bag has the metadata of version 8, which ROS 2 reads from Iron on.
"""

from __future__ import annotations

import tempfile
from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from mitlplan.errors import OutputError
from mitlplan.formats.output import check_writable
from mitlplan.formats.plan_json import plan_to_json
from mitlplan.plan import Plan
from mitlplan.trajectory import Samples, Trajectory

if TYPE_CHECKING:
    from rosbags.interfaces import Qos
    from rosbags.typesys.store import Typestore

TRAJECTORY_TOPIC = "/trajectory"
PLAN_TOPIC = "/plan_json"

_METADATA_VERSION: Final = 8
_NANO = 10**9


class Storage(Enum):
    """How a bag is stored."""

    SQLITE3 = "sqlite3"
    MCAP = "mcap"


def write_bag(
    folder: Path,
    trajectory: Trajectory,
    plan: Plan,
    step: Fraction,
    *,
    storage: Storage = Storage.MCAP,
    frame: str = "map",
    start: Fraction = Fraction(0),
    until: Fraction | None = None,
) -> None:
    """Write a bag, which is a folder; whole or not at all.

    Parameters
    ----------
    folder
        The bag; it must not exist.
    trajectory, plan
        What it holds.
    step, until
        Seconds between poses, and where to stop, as in :meth:`mitlplan.trajectory.Trajectory.sample`.
    storage
        How it is stored.
    frame
        The coordinate frame of the map.
    start
        The time of the clock, in seconds since 1970, at which the robot starts.

    Raises
    ------
    OutputError
        If the folder exists or cannot be written, or the package rosbags is missing.
    ValueError
        If there are no samples at such a step, or too many.
    """
    check_new(folder)
    samples = trajectory.sample(step, until)
    try:
        with tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent) as beside:
            written = Path(beside) / folder.name
            _write(written, samples, plan, storage, frame, start)
            written.rename(folder)
    except OSError as error:
        raise OutputError(f"cannot write {folder}: {error.strerror}") from None


def check_new(folder: Path) -> None:
    """Raise a sentence now if a bag could not be written there later.

    Raises
    ------
    OutputError
        If it exists, or its own folder does not.
    """
    if folder.exists():
        raise OutputError(f"cannot write {folder}: it exists; a bag is a new folder, name another")
    check_writable(folder)


def _write(folder: Path, samples: Samples, plan: Plan, storage: Storage, frame: str, start: Fraction) -> None:
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise OutputError("bags need the package rosbags: pip install 'mitlplan[ros]'") from None
    types = get_typestore(Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.SQLITE3 if storage is Storage.SQLITE3 else StoragePlugin.MCAP
    now = int(start * _NANO)
    messages = (
        (TRAJECTORY_TOPIC, "nav_msgs/msg/Path", _path(types, samples, frame, now)),
        (PLAN_TOPIC, "std_msgs/msg/String", types.types["std_msgs/msg/String"](data=plan_to_json(plan))),
    )
    with Writer(folder, version=_METADATA_VERSION, storage_plugin=plugin) as bag:
        for topic, kind, message in messages:
            connection = bag.add_connection(topic, kind, typestore=types, offered_qos_profiles=[_latched()])
            bag.write(connection, now, types.serialize_cdr(message, kind))


def _latched() -> Qos:
    """For whoever comes late: reliable, kept for later subscribers, one message."""
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    without_end = QosTime(2147483647, 4294967295)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL,
        deadline=without_end,
        lifespan=without_end,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=without_end,
        avoid_ros_namespace_conventions=False,
    )


def _path(types: Typestore, samples: Samples, frame: str, start: int) -> Any:
    kinds = types.types
    point, turn = kinds["geometry_msgs/msg/Point"], kinds["geometry_msgs/msg/Quaternion"]
    pose, stamped = kinds["geometry_msgs/msg/Pose"], kinds["geometry_msgs/msg/PoseStamped"]
    header, time = kinds["std_msgs/msg/Header"], kinds["builtin_interfaces/msg/Time"]
    course = samples.course
    # A turn by theta about the vertical is the quaternion (0, 0, sin theta/2, cos theta/2).
    rows = (samples.time, course.x, course.y, np.sin(course.heading / 2), np.cos(course.heading / 2))
    poses = []
    for seconds, x, y, sine, cosine in zip(*(row.tolist() for row in rows), strict=True):
        stamp = time(*divmod(start + round(seconds * _NANO), _NANO))
        place = pose(point(x, y, 0.0), turn(0.0, 0.0, sine, cosine))
        poses.append(stamped(header(stamp, frame), place))
    return kinds["nav_msgs/msg/Path"](header(time(*divmod(start, _NANO)), frame), poses)
