"""Reads waypoints beside the script, which are not there."""
from pathlib import Path

import numpy as np
from rps.robotarium import Robotarium

HERE = Path(__file__).resolve().parent
WAYPOINTS = HERE / "waypoints.npy"


def main():
    goals = np.load(WAYPOINTS)  # <- file-missing
    r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
    for _ in range(60):
        r.get_poses()
        r.set_velocities([0], np.clip(goals[:, :1], -0.05, 0.05))
        r.step()
    r.debug()


main()
