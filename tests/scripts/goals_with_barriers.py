# Drives five robots to random goals. Everything comes from star imports.
import rps.robotarium as robotarium
from rps.utilities.transformations import *
from rps.utilities.barrier_certificates import *
from rps.utilities.misc import *
from rps.utilities.controllers import *

import numpy as np
import time

N = 5
initial_conditions = np.array(np.mat('1 0.5 -0.5 0 0.28; 0.8 -0.3 -0.75 0.1 0.34; 0 0 0 0 0'))
r = robotarium.Robotarium(number_of_robots=N, show_figure=True, initial_conditions=initial_conditions, sim_in_real_time=True)

goal_points = generate_initial_conditions(N, width=2.0, height=1.2)
unicycle_pose_controller = create_clf_unicycle_pose_controller()
uni_barrier_cert = create_unicycle_barrier_certificate()

x = r.get_poses()
r.step()

# While the number of robots at the required poses is less than N...
while (np.size(at_pose(x, goal_points)) != N):
    x = r.get_poses()
    dxu = unicycle_pose_controller(x, goal_points)
    dxu = uni_barrier_cert(dxu, x)
    r.set_velocities(np.arange(N), dxu)
    r.step()

print("all there", np.size(at_pose(x, goal_points)))
r.call_at_scripts_end()
