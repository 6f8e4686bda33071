import csv
import os
import sys
import numpy as np
import rps.robotarium as robotarium

folder = sys.argv[1] if len(sys.argv) > 1 else "."
N = 3
r = robotarium.Robotarium(number_of_robots=N, show_figure=True, sim_in_real_time=False)
data = np.zeros((50, 3, N))
for k in range(50):
    x = r.get_poses()
    data[k] = x
    r.set_velocities(np.arange(N), np.array([[0.03] * N, [0.2] * N]))
    r.step()
np.save(os.path.join(folder, "poses.npy"), data)
np.savetxt(os.path.join(folder, "x.csv"), data[:, 0], delimiter=",")
with open(os.path.join(folder, "y.csv"), "w", newline="") as f:
    csv.writer(f).writerows(data[:, 1].tolist())
r.figure.savefig(os.path.join(folder, "end.png"))
print("saved to", folder)
r.call_at_scripts_end()
