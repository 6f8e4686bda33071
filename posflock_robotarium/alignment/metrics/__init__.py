"""What a flock does at one time: alignment, distances, cohesion, one definition each.

Every function takes states with any leading axes, ``(..., d, N)``, typically ``(T, d, N)``
for a whole run, and returns one value for each of them.  Positions are in metres,
velocities in m/s.  The definitions are the paper's (Jond et al., Section "Simulation"),
made exact where it leaves room.  An agent whose state is NaN is not there: every value
is of those that are, and NaN where that is nobody.

``directions``    whether agents go one way: γ, polarisation, the common heading
``velocities``    velocities from positions, speeds, wheels
``distances``     from each other and from the walls
``cohesion``      how close together, and how much of the formation is kept
``connectivity``  whether the graph of neighbours holds the flock together
"""

from posflock_robotarium.alignment.metrics.cohesion import (
    cohesive_radius,
    pairwise_change_variance,
    pairwise_distance_variance,
    spread,
)
from posflock_robotarium.alignment.metrics.connectivity import (
    algebraic_connectivity,
    algebraic_connectivity_of,
    connected_components,
    connected_components_of,
)
from posflock_robotarium.alignment.metrics.directions import (
    Alignment,
    alignment,
    alignment_without_each,
    common_heading,
    heading_vectors,
    polarisation,
)
from posflock_robotarium.alignment.metrics.distances import (
    distances_to_nearest,
    mean_to_nearest,
    nearest_neighbour_distance,
    pairwise_distances,
    smallest_distance,
    wall_distance,
)
from posflock_robotarium.alignment.metrics.velocities import (
    SLOWEST,
    SMOOTHING_POINTS,
    fastest_wheel,
    mean_speed,
    smoothed_velocities,
    velocities_by_differences,
)

__all__ = [
    "SLOWEST",
    "SMOOTHING_POINTS",
    "Alignment",
    "algebraic_connectivity",
    "algebraic_connectivity_of",
    "alignment",
    "alignment_without_each",
    "cohesive_radius",
    "common_heading",
    "connected_components",
    "connected_components_of",
    "distances_to_nearest",
    "fastest_wheel",
    "heading_vectors",
    "mean_speed",
    "mean_to_nearest",
    "nearest_neighbour_distance",
    "pairwise_change_variance",
    "pairwise_distance_variance",
    "pairwise_distances",
    "polarisation",
    "smallest_distance",
    "smoothed_velocities",
    "spread",
    "velocities_by_differences",
    "wall_distance",
]
