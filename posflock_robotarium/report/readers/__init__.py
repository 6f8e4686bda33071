"""Poses from any file that a Robotarium run may have left behind."""

from posflock_robotarium.report.readers.reading import ReadOptions, read, read_parts
from posflock_robotarium.report.readers.recording import LayoutError, Recording

__all__ = ["LayoutError", "ReadOptions", "Recording", "read", "read_parts"]
