"""Two robots swap sides, kept apart by a certificate."""
import numpy as np
from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import create_si_barrier_certificate_with_boundary
from rps.utilities.transformations import create_si_to_uni_mapping

start = np.array([[-0.4, 0.4], [0.02, -0.02], [0.0, np.pi]])
goals = -start[:2]
r = Robotarium(number_of_robots=2, show_figure=False, initial_conditions=start)
to_uni, to_si = create_si_to_uni_mapping()
certificate = create_si_barrier_certificate_with_boundary(safety_radius=0.22)
for _ in range(450):
    x = r.get_poses()
    si = to_si(x)
    u = np.clip(0.6 * (goals - si), -0.08, 0.08)
    r.set_velocities(np.arange(2), to_uni(certificate(u, si), x))
    r.step()
r.debug()
