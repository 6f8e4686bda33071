"""What flies: all that goes to the testbed with the script, beside :mod:`barrier_certificates`.

==================  ==================================================================
law                 the paper's laws: pure functions of positions and velocities
paper_models        the three models that the paper compares, by name
neighbour_memory    who is a neighbour, with a margin: nobody flickers at the radius
steering            what turns the flock as a whole away from the walls
local_steering      the same by robots that know their neighbours alone, and what they tell them
local_certificate   a certificate that each robot computes by itself
checked_poses       poses as they were read, refused where they mean nothing
pose_filter         poses as they are now, out of poses as they were logged
drive_limits        what the motors can do, and velocities shortened to it
flock               the law on wheels: turned into commands, certified, once a step
attendance          who may look at a flock between two steps, and change its law
placement           starts that fit into the arena
pose_log            every pose and command on disk, whatever ends the run
row_file            rows that no kill and no full disk takes back
constants_on_board  what the script's Robotarium says of its robots and its arena
goal_view           what a robot on the way to its goal sees, as a policy takes it
trained_policy      a small network that was trained elsewhere: numbers in a file, and numpy
progress            a line that counts steps
errors              what is raised
==================  ==================================================================

numpy and scipy suffice, and Python 3.10. In an upload all files lie in one folder, so names are
unique there, and none is a library's.
"""

__all__ = [
    "attendance",
    "constants_on_board",
    "drive_limits",
    "errors",
    "flock",
    "goal_view",
    "law",
    "local_steering",
    "neighbour_memory",
    "paper_models",
    "placement",
    "pose_filter",
    "pose_log",
    "progress",
    "steering",
    "trained_policy",
]
