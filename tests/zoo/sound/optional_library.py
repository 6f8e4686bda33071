"""Uses a library where it is there."""
import numpy as np
from rps.robotarium import Robotarium

try:
    import tqdm

    progress = tqdm.tqdm
except ImportError:
    progress = iter

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in progress(range(60)):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
