"""A function of generation 1, behind a star."""
from rps.robotarium import *
from rps.utilities.barrier_certificates import *

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
certificate = create_single_integrator_barrier_certificate()  # <- generation
for _ in range(60):
    x = r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
