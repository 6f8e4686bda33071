import rps.robotarium as robotarium
from rps.utilities.graph import *
from rps.utilities.transformations import *
from rps.utilities.barrier_certificates import *
import numpy as np

N = 12
r = robotarium.Robotarium(number_of_robots=N, show_figure=True, sim_in_real_time=False)
_, uni_to_si_states = create_si_to_uni_mapping()
si_to_uni_dyn = create_si_to_uni_dynamics()
si_barrier_cert = create_single_integrator_barrier_certificate_with_boundary()
L = cycle_GL(N)

for k in range(400):
    x = r.get_poses()
    x_si = uni_to_si_states(x)
    si_velocities = np.zeros((2, N))
    for i in range(N):
        j = topological_neighbors(L, i)
        si_velocities[:, i] = np.sum(x_si[:, j] - x_si[:, i, None], 1)
    si_velocities = si_barrier_cert(si_velocities, x_si)
    r.set_velocities(np.arange(N), si_to_uni_dyn(si_velocities, x))
    r.step()

print("errors", sorted(k for k in r._errors if not k.endswith("_string")))
r.call_at_scripts_end()
