"""Calibration without poses: speed gain and delay from the times of the lines that a script prints.

`logs.event_lines` finds events in what was printed, `trials` simulates the script under candidates,
`times` fits both numbers to the logged times, and `event_calibration` makes a profile of them.
"""

from posflock_robotarium.event_calibration.event_calibration import (
    EventCalibration,
    calibrate_events,
)

__all__ = ["EventCalibration", "calibrate_events"]
