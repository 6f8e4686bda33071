"""The pose log as the recorder of scripts that know nothing of it."""

from pathlib import Path
from typing import Any

from posflock_robotarium.flocking.pose_log import PoseLog

#: Rows to make room for at first: two minutes and more; the file grows as it must.
ROWS = 4096


def open_pose_log(path: Path, robots: int, about: dict[str, Any]) -> PoseLog:
    """Open the pose log of one Robotarium instance.

    Offered to ``rps_compat`` under the entry point group ``rps_compat.recorders``.

    Parameters
    ----------
    path : Path
        The log's path, without ending.
    robots : int
        Number of robots.
    about : dict
        Which script ran, on which generation, with which seed.
    """
    return PoseLog(path, robots, ROWS, about, real_time=False)
