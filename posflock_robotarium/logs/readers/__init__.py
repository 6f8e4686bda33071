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
from posflock_robotarium.logs.readers.found import Clock, Found, Lengths, ReadOptions
from posflock_robotarium.logs.readers.matlab import MATLAB
from posflock_robotarium.logs.readers.numpy_archives import NPZ
from posflock_robotarium.logs.readers.numpy_arrays import NPY
from posflock_robotarium.logs.readers.pickles import PICKLE
from posflock_robotarium.logs.readers.pose_logs import POSE_LOG
from posflock_robotarium.logs.readers.reading import read, read_parts, read_pose_log
from posflock_robotarium.logs.readers.text import TEXT
from posflock_robotarium.logs.run import LayoutError, Run

__all__ = [
    "Bounds",
    "Clock",
    "Form",
    "Found",
    "LayoutError",
    "Lengths",
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

for _form in (POSE_LOG, NPY, NPZ, MATLAB, PICKLE, TEXT):
    register(_form)
