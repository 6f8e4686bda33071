# plt comes from the star import, and draws on the arena.
from rps.robotarium import *
from rps.utilities.misc import *

r = Robotarium(number_of_robots=3, show_figure=True, sim_in_real_time=True, initial_conditions=generate_initial_conditions(3))
plt.plot([-1.6, 1.6], [0, 0], 'k--')
plt.title('three robots')
assert plt.gca() is r.axes
plt.ion()
plt.show()
for k in range(120):
    x = r.get_poses()
    plt.plot(x[0, :], x[1, :], 'r.')
    plt.scatter(x[0, 0], x[1, 0])
    r.set_velocities(np.arange(3), 0.05 * np.ones((2, 3)))
    r.step()
    plt.draw()
    plt.pause(0.001)
print(len(plt.gca().lines), len(plt.gca().collections))
plt.close(r.figure)
r.call_at_scripts_end()
