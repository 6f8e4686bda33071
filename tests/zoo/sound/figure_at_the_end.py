"""Draws a figure, and saves it rather than showing it."""
import matplotlib.pyplot as plt

import numpy as np
from rps.robotarium import Robotarium

r = Robotarium(number_of_robots=2, initial_conditions=np.array([[-0.5, 0.5], [0.0, 0.0], [0.0, 0.0]]))
for _ in range(60):
    r.get_poses()
    r.set_velocities(np.arange(2), np.array([[0.05, 0.05], [0.0, 0.0]]))
    r.step()
r.debug()
figure, axes = plt.subplots()
axes.plot([0, 1], [0, 1])
plt.show(block=False)
