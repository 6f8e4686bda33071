"""Whether the flock hangs together: groups and algebraic connectivity of the neighbour graph."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment import metrics
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import CONNECTIVITY
from posflock_robotarium.alignment.reductions import largest, smallest
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS


class Connectivity(NamedTuple):
    """What the neighbour graph says over time.

    Parameters
    ----------
    components : (T,) array
        Number of groups that no chain of neighbours connects.
    algebraic : (T,) array
        Second smallest eigenvalue of the graph's Laplacian, from 0 to N.
    """

    components: Floats
    algebraic: Floats


def _connectivity(run: MeasuredRun) -> Connectivity | None:
    """Return both, computed only where the graph changes; None without neighbours."""
    if run.recording.robots < 2 or not run.has_neighbours:
        return None
    found = np.empty((len(run.recording.t), 2))
    before: NDArray[np.bool_] | None = None
    last, seen_before = np.zeros(2), run.seen[:1]
    for stretch in run.stretches():
        positions = run.positions[stretch]
        linked = run.neighbours(stretch)
        previous = linked[:1] if before is None else before
        changed = (linked != np.concatenate([previous, linked[:-1]])).any(axis=(1, 2))
        seen = run.seen[stretch]
        changed |= (seen != np.concatenate([seen_before, seen[:-1]])).any(axis=1)
        changed[0] |= before is None
        values = _of_graphs(positions[changed], linked[changed], run.radius)
        # Row 0 is what held before this stretch, row k what holds from its k-th change on.
        found[stretch] = np.concatenate([last[np.newaxis], values])[np.cumsum(changed)]
        last, before, seen_before = found[stretch][-1], linked[-1:], seen[-1:]
    return Connectivity(*found.T)


def _of_graphs(positions: Floats, linked: NDArray[np.bool_], radius: float | Floats) -> Floats:
    """Return components and algebraic connectivity of (K, 2, N) positions, shape (K, 2)."""
    if not len(positions):
        return np.empty((0, 2))
    seen = np.isfinite(positions[:, 0])
    if positions.shape[2] >= TREE_FROM_AGENTS:
        groups = metrics.connected_components(positions, radius)
    else:
        groups = metrics.connected_components_of(linked, seen)
    components = groups.astype(float)
    found = np.stack([components, metrics.algebraic_connectivity_of(linked, seen)], axis=1)
    # Who is not seen may be what links the groups; and nobody is no group.
    unknown = ((components > 1) & ~seen.all(axis=1)) | ~seen.any(axis=1)
    found[unknown] = np.nan
    return found


def _components(run: MeasuredRun) -> Floats | None:
    found = run.once(_connectivity)
    return None if found is None else found.components


def _algebraic(run: MeasuredRun) -> Floats | None:
    found = run.once(_connectivity)
    return None if found is None else found.algebraic


def _connected(run: MeasuredRun) -> float | None:
    components = run.once(_components)
    if components is None:
        return None
    return run.mean(np.where(np.isnan(components), np.nan, components == 1))


register(
    Metric(
        "components",
        "connected components",
        "",
        "Number of groups that no chain of neighbours connects, of the robots that are seen; "
        "unknown where these have parted and others, who may link them, are not seen.",
        _components,
        "largest",
        panel=CONNECTIVITY,
        numbers=(
            Scalar(
                "components",
                "most groups at once",
                "",
                "Whole run.",
                "Cohesion",
                largest("components"),
            ),
            Scalar(
                "connected",
                "time in one group",
                "share",
                "Share of the whole run, where known, in which every robot is connected to every "
                "other.",
                "Cohesion",
                _connected,
                latex=True,
            ),
        ),
    ),
    Metric(
        "algebraic_connectivity",
        "algebraic connectivity",
        "",
        "Second smallest eigenvalue of the neighbour graph's Laplacian: 0 when the team has "
        "parted, N when every robot neighbours every other.",
        _algebraic,
        "smallest",
        panel=CONNECTIVITY,
        numbers=(
            Scalar(
                "algebraic_connectivity",
                "smallest algebraic connectivity",
                "",
                "Whole run.",
                "Cohesion",
                smallest("algebraic_connectivity"),
            ),
        ),
    ),
)
