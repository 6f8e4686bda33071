"""Bound methods in locals for speed, the robotarium in a dict, finishing through getattr."""
import numpy as np
from rps.robotarium import Robotarium

world = {"r": Robotarium(number_of_robots=1, show_figure=False, initial_conditions=np.zeros((3, 1)))}
get, put, step = (getattr(world["r"], n) for n in ("get_poses", "set_velocities", "step"))
with open("log.txt", "w") as log:
    for k in range(60):
        log.write(str(get()[0, 0]) + "\n")
        put([0], np.array([[0.02], [0.1]]))
        step()
for name in ("debug", "call_at_scripts_end"):
    finish = getattr(world["r"], name, None)
    if callable(finish):
        finish()
