"""From logged poses to an alignment report.

`analyse` turns a log (ours, or any array, table or MATLAB file of poses) into an `Analysis`: curves
over time, numbers with units and definitions, faults by the testbed's own tests, and verdicts in
words. Everything else here draws, writes or compares analyses.
"""

from posflock_robotarium.report.analysis import Analysis, AnalysisOptions, analyse, load
from posflock_robotarium.report.readers import (
    LayoutError,
    ReadOptions,
    Recording,
    read,
    read_parts,
)

__all__ = [
    "Analysis",
    "AnalysisOptions",
    "LayoutError",
    "ReadOptions",
    "Recording",
    "analyse",
    "load",
    "read",
    "read_parts",
]
