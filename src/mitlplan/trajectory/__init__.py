"""From timed way points to a trajectory that the robot can drive."""

from mitlplan.trajectory.follow import Waiting, follow, spans_of
from mitlplan.trajectory.leg import Weights
from mitlplan.trajectory.motion import Motion, Style, straight, turn_left, turn_right, u_turn
from mitlplan.trajectory.pose import Course, Pose
from mitlplan.trajectory.profile import Profile
from mitlplan.trajectory.retime import Retimed, retime
from mitlplan.trajectory.robot import DrivenTimes, Driving, Robot
from mitlplan.trajectory.timetable import Apart, Span
from mitlplan.trajectory.trajectory import Piece, Samples, Trajectory, Visit

__all__ = [
    "Apart",
    "Course",
    "DrivenTimes",
    "Driving",
    "Motion",
    "Piece",
    "Pose",
    "Profile",
    "Retimed",
    "Robot",
    "Samples",
    "Span",
    "Style",
    "Trajectory",
    "Visit",
    "Waiting",
    "Weights",
    "follow",
    "retime",
    "spans_of",
    "straight",
    "turn_left",
    "turn_right",
    "u_turn",
]
