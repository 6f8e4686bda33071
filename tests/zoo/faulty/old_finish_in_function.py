"""The old finishing call on a robotarium that was handed to a function."""
import numpy as np
from rps.robotarium import Robotarium


def finish(arena):
    arena.call_at_scripts_end()  # <- generation


r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(60):
    r.get_poses()
    r.set_velocities([0], np.zeros((2, 1)))
    r.step()
finish(r)
