"""From logged poses to an alignment report.

`analyse` turns a log (ours, or any array, table or MATLAB file of poses) into an `Analysis`: curves
over time, numbers with units and definitions, faults by the testbed's own tests, and verdicts in
words. `compare` puts several side by side, `write_report` makes the page, figures and tables.
"""

from posflock_robotarium.alignment.analysis import Analysis, analyse, load
from posflock_robotarium.alignment.comparison import Comparison, compare
from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.alignment.own_metrics import metric, own_metrics
from posflock_robotarium.alignment.questions import Questions
from posflock_robotarium.logs.readers import (
    LayoutError,
    ReadOptions,
    Run,
    read,
    read_parts,
)
from posflock_robotarium.report.outputs import write_report

__all__ = [
    "Analysis",
    "AnalysisOptions",
    "Comparison",
    "LayoutError",
    "Questions",
    "ReadOptions",
    "Run",
    "analyse",
    "compare",
    "load",
    "metric",
    "own_metrics",
    "read",
    "read_parts",
    "write_report",
]
