"""Read a log that has commands, drive simulated robots with them, and write what comes out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from posflock_robotarium.calibration.increments import NO_COMMANDS, time_step_of
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.run import Run
from rps_compat.distributions import DistributionKind
from rps_compat.realism import Profile
from rps_compat.whole_files import write_whole


def read_commanded(path: Path | str) -> Run:
    """Read a log that has commands from any file that the report reads.

    Parameters
    ----------
    path : path
        A pose log, with or without ``.npy``, or an archive with poses, times and commands.

    Raises
    ------
    LogError
        Where the file is missing, damaged, ambiguous or holds no commands.
    """
    from posflock_robotarium.logs.readers import LayoutError, read

    try:
        run = read(path)
    except LayoutError as error:
        raise LogError(
            f"{error}; `posflock convert --to npz` with that option writes a file that says so"
        ) from error
    if run.commands is None:
        raise LogError(f"{path}: {NO_COMMANDS}")
    return run


def resimulate(log: Run, profile: Profile, seed: int = 0) -> Run:
    """Drive simulated robots with a log's commands, under a profile, from its first poses.

    Parameters
    ----------
    log : Run
        With commands.
    profile : Profile
        Such as :meth:`Calibration.profile`.
    seed : int
        Of the profile's randomness.

    Returns
    -------
    Run
        The same times and commands, and the poses that the simulator gives.

    Raises
    ------
    LogError
        Where the log has no commands, or rows that are not evenly spaced.
    """
    from rps_compat.arena import Arena

    dt = time_step_of(log, None)
    start = log.poses[0].copy()
    if (
        profile.heading_offset is not None
        and profile.heading_offset.radians.kind is DistributionKind.ROBOTS
    ):
        # The log's first headings have the offset already, which the profile will add.
        start[2] -= profile.heading_offset.radians.draw(log.robots, np.random.default_rng(seed))
    arena = Arena(start, log.robot, realism=profile.start(), rng=np.random.default_rng(seed))
    if log.commands is None:
        raise LogError(f"{log.name}: {NO_COMMANDS}")
    poses = np.empty_like(log.poses)
    for k, command in enumerate(log.commands):
        poses[k] = arena.observe()
        arena.commands = np.array(command)
        arena.step()
    known = {
        **{k: v for k, v in log.parameters.items() if k not in ("ended", "format", "versions")},
        "resimulated_with": profile.name,
        "seed": seed,
        "time_step": dt,
        "simulated": True,
    }
    # What a certificate said of other poses says nothing of these.
    return replace(
        log, poses=poses, intervention=None, clearance=None, status=None, parameters=known
    )


def write_profile(profile: Profile, path: Path) -> None:
    """Write a profile as TOML.

    Parameters
    ----------
    profile : Profile
        What is written.
    path : Path
        Where the file is written.

    Raises
    ------
    OutputError
        Where that is not possible.
    """
    from rps_compat.profiles import profile_to_toml

    write_whole(path, profile_to_toml(profile))
