import rps.robotarium as robotarium
from rps.utilities.transformations import *
from rps.utilities.controllers import *
from rps.utilities.misc import *
from matplotlib import patches
import numpy as np

N = 4
x0 = np.array([[-0.6, 0.6, -0.6, 0.6], [-0.4, -0.4, 0.4, 0.4], [0, 0, 0, 0]])
r = robotarium.Robotarium(number_of_robots=N, show_figure=True, sim_in_real_time=False, initial_conditions=x0)

goal = x0[:2, ::-1]
si_to_uni, uni_to_si = create_si_to_uni_mapping()
controller = create_si_position_controller()

# markers, labels, a region, an arrow and a picture below it all
marker_size = determine_marker_size(r, 0.2)
font_size = determine_font_size(r, 0.1)
line_width = 5
r.axes.imshow(np.linspace(0, 1, 100).reshape(10, 10), extent=(-1.6, 1.6, -1, 1), alpha=0.2)
g = r.axes.scatter(goal[0, :], goal[1, :], s=marker_size, marker='s', facecolors='none', edgecolors='k', linewidth=line_width, zorder=-2)
robot_markers = [r.axes.scatter(x0[0, i], x0[1, i], s=marker_size, marker='o', facecolors='none', edgecolors='b', linewidth=line_width) for i in range(N)]
labels = [r.axes.text(x0[0, i], x0[1, i], 'Robot ' + str(i), fontsize=font_size, color='k', fontweight='bold', horizontalalignment='center', verticalalignment='center') for i in range(N)]
r.axes.add_patch(patches.Circle((0, 0), 0.2, fill=False))
r.axes.arrow(0, 0, 0.2, 0.1, head_width=0.05)
trail, = r.axes.plot([], [], 'r-')
seen = []

for t in range(200):
    x = r.get_poses()
    seen.append(x[:2, 0].copy())
    trail.set_data([p[0] for p in seen], [p[1] for p in seen])
    for i in range(N):
        robot_markers[i].set_offsets(x[:2, i].T)
        labels[i].set_position([x[0, i], x[1, i] + 0.15])
        # This updates the marker sizes if the figure window size is changed.
        robot_markers[i].set_sizes([determine_marker_size(r, 0.2)])
    r.axes.plot(x[0, 1], x[1, 1], 'g.', markersize=2)
    r.set_velocities(np.arange(N), si_to_uni(controller(uni_to_si(x), goal), x))
    r.step()

print(len(r.axes.lines), "lines", len(r.axes.texts), "texts")
r.call_at_scripts_end()
