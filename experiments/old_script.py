"""Two robots change places, as scripts of generation 1 were written.

Something to see the change of generations on: `posflock lint` lists what today's testbed no longer
has, and rewrites it; `posflock run` runs it as it is.
"""

import numpy as np

import rps.robotarium as robotarium
from rps.utilities.barrier_certificates import create_unicycle_barrier_certificate
from rps.utilities.controllers import create_clf_unicycle_pose_controller
from rps.utilities.misc import at_pose

start = np.array([[-0.5, 0.5], [0.1, -0.1], [0.0, np.pi]])
goal = np.array([[0.5, -0.5], [0.1, -0.1], [0.0, np.pi]])

r = robotarium.Robotarium(
    number_of_robots=2, show_figure=False, sim_in_real_time=False, initial_conditions=start
)
drive = create_clf_unicycle_pose_controller()
keep_apart = create_unicycle_barrier_certificate(safety_radius=0.12)

x = r.get_poses()
r.step()
while np.size(at_pose(x, goal)) != 2:
    x = r.get_poses()
    r.set_velocities(np.arange(2), keep_apart(drive(x, goal), x))
    r.step()
r.call_at_scripts_end()
