"""Poses from any file that a Robotarium run may have left behind."""

from posflock_robotarium.logs.readers.named_arrays import ReadOptions
from posflock_robotarium.logs.readers.reading import read, read_parts
from posflock_robotarium.logs.readers.recording import LayoutError, Recording

__all__ = ["LayoutError", "ReadOptions", "Recording", "read", "read_parts"]
