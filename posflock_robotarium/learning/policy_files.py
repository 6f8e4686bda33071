"""What a training leaves: weights that travel, all that is known of the search, and its curve."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.trained_policy import TrainedPolicy
from posflock_robotarium.learning.training import Training
from rps_compat.whole_files import written_together

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["read_policy", "save_training"]


def save_training(
    training: Training, folder: Path, name: str, curve: Figure | None = None
) -> list[Path]:
    """Write what a training found, all files or none; return their paths.

    ``NAME_weights.npy`` is what a script loads, and the testbed takes; ``NAME_training.npz`` has
    the same weights by name, the scores of every generation and the search's settings;
    ``NAME_curve.png`` is the figure.

    Parameters
    ----------
    training : Training
        What was found, and how.
    folder : Path
        Where the files are put; made if it is not there.
    name : str
        NAME of the files.
    curve : Figure, optional
        The learning curve.

    Raises
    ------
    OutputError
        Where the files cannot be written.
    """
    search, evolution = training.search, training.evolution
    about: dict[str, Any] = {
        "scores": evolution.scores,
        "spread": evolution.spread,
        **{field: getattr(search, field) for field in search.__dataclass_fields__},
        "episodes": training.episodes,
    }
    names = [f"{name}_weights.npy", f"{name}_training.npz"]
    if curve is not None:
        names.append(f"{name}_curve.png")
    with written_together(folder) as draft:
        np.save(draft / names[0], training.policy.stored(), allow_pickle=False)
        np.savez(draft / names[1], **(training.policy.named() | about))
        if curve is not None:
            curve.savefig(draft / names[2], dpi=200, metadata={"Software": None})
    return [folder / written for written in names]


def read_policy(path: Path | str) -> TrainedPolicy:
    """Read the weights of a policy from `.npy` or `.npz`.

    Parameters
    ----------
    path : Path or str
        What `save_training` has written, or `numpy.save` of `TrainedPolicy.stored`.

    Raises
    ------
    ParameterError
        Where it cannot be read, or holds no policy.
    """
    try:
        stored = np.load(path, allow_pickle=False)
        if not isinstance(stored, np.ndarray):
            with stored as archive:
                stored = dict(archive)
    except (OSError, ValueError, EOFError) as error:
        raise ParameterError(f"{path}: cannot be read as weights ({error})") from error
    return TrainedPolicy.of(stored)
