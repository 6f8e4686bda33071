"""Poses from any file that a Robotarium run may have left behind.

Each form of files is one module and one entry in the list below; `forms` says what an entry holds.
"""

from posflock_robotarium.logs.readers.bounds import Bounds
from posflock_robotarium.logs.readers.forms import (
    Form,
    Sign,
    form_of,
    known_forms,
    register,
    registered,
)
from posflock_robotarium.logs.readers.found import Found, Lengths, LogClock, ReadOptions
from posflock_robotarium.logs.readers.matlab import MATLAB
from posflock_robotarium.logs.readers.mcap_logs import MCAP
from posflock_robotarium.logs.readers.motion_capture import MOTIVE, VICON
from posflock_robotarium.logs.readers.mrclam import MRCLAM
from posflock_robotarium.logs.readers.numpy_archives import NPZ
from posflock_robotarium.logs.readers.numpy_arrays import NPY
from posflock_robotarium.logs.readers.pickles import PICKLE
from posflock_robotarium.logs.readers.pose_logs import POSE_LOG
from posflock_robotarium.logs.readers.reading import read, read_parts, read_pose_log
from posflock_robotarium.logs.readers.ros_bags import ROS_BAG
from posflock_robotarium.logs.readers.ros_csv import ROS_CSV
from posflock_robotarium.logs.readers.text import TEXT
from posflock_robotarium.logs.readers.trajectories import EUROC, KITTI, TUM
from posflock_robotarium.logs.run import LayoutError, Run

__all__ = [
    "Bounds",
    "Form",
    "Found",
    "LayoutError",
    "Lengths",
    "LogClock",
    "ReadOptions",
    "Run",
    "Sign",
    "form_of",
    "known_forms",
    "read",
    "read_parts",
    "read_pose_log",
    "register",
    "registered",
]

_BY_CONTENT = (POSE_LOG, ROS_BAG, ROS_CSV, TUM, EUROC, KITTI, MRCLAM, MOTIVE, VICON)
_BY_SIGNATURE = (NPY, NPZ, MATLAB, MCAP, PICKLE)
for _form in (*_BY_CONTENT, *_BY_SIGNATURE, TEXT):
    register(_form)
