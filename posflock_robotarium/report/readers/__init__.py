"""Poses from any file that a Robotarium run may have left behind."""

from posflock_robotarium.report.readers.named_arrays import ReadOptions
from posflock_robotarium.report.readers.reading import read, read_parts
from posflock_robotarium.report.readers.recording import LayoutError, Recording

__all__ = ["LayoutError", "ReadOptions", "Recording", "read", "read_parts"]
