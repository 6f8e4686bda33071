"""Everything by star, as many scripts do."""
from rps.robotarium import *
from rps.utilities.barrier_certificates import *
from rps.utilities.misc import *
from rps.utilities.transformations import *

N = 4
start = np.array([[-0.6, -0.2, 0.2, 0.6], [0.0, 0.1, 0.0, 0.1], [0.0, 0.0, 0.0, 0.0]])
r = Robotarium(number_of_robots=N, show_figure=False, initial_conditions=start)
to_uni, to_si = create_si_to_uni_mapping()
certificate = create_si_barrier_certificate_with_boundary()
for _ in range(200):
    x = r.get_poses()
    si = to_si(x)
    u = 0.1 * np.array([np.cos(x[2]), np.sin(x[2])])
    r.set_velocities(np.arange(N), to_uni(certificate(u, si), x))
    r.step()
r.debug()
