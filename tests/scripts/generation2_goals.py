"""Generation 2: drives to random poses, then to others, with everything by its new name."""
import numpy as np

from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import create_uni_barrier_certificate_with_boundary
from rps.utilities.controllers import create_pose_controller_hybrid
from rps.utilities.misc import create_at_pose, generate_random_poses

N = 6
robotarium = Robotarium(number_of_robots=N, show_figure=True, sim_in_real_time=True, initial_conditions=generate_random_poses(N))
goals = generate_random_poses(N, spacing=0.5, width=2.4, height=1.4)
controller = create_pose_controller_hybrid()
barrier = create_uni_barrier_certificate_with_boundary()
at_pose = create_at_pose()

x = robotarium.get_poses()
robotarium.step()
for _ in range(3000):
    x = robotarium.get_poses()
    done, _ = at_pose(x, goals)
    if done:
        break
    robotarium.set_velocities(np.arange(N), barrier(controller(x, goals), x))
    robotarium.step()
print("done:", done)
robotarium.debug()
