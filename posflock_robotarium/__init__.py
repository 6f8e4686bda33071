"""Position-based flocking on the Robotarium, kept safe by control barrier functions (CBF).

The law, the experiment, and what became of it.
"""

__version__ = "1.0.0"

__all__ = [
    "alignment",
    "batch",
    "calibration",
    "event_calibration",
    "examples",
    "figures",
    "flocking",
    "freespace",
    "learning",
    "logs",
    "new_script",
    "paper",
    "report",
    "simulation",
    "submission",
    "sweep",
    "verify",
]
