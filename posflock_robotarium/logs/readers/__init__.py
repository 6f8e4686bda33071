"""Poses from any file that a Robotarium run may have left behind."""

from posflock_robotarium.logs.readers.named_arrays import ReadOptions
from posflock_robotarium.logs.readers.reading import read, read_parts, read_pose_log
from posflock_robotarium.logs.run import LayoutError, Run

__all__ = ["LayoutError", "ReadOptions", "Run", "read", "read_parts", "read_pose_log"]
