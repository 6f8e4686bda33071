"""Read a log that has commands, drive simulated robots with them, and write what comes out."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from posflock_robotarium.calibration.increments import time_step_of
from posflock_robotarium.flocking.errors import LogError, OutputError
from posflock_robotarium.flocking.pose_log import Log, PoseLog
from rps_compat.realism import Profile


def read_commanded(path: Path | str) -> Log:
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
    rows = len(run.t)
    if run.command is None:
        raise LogError(
            f"{path}: no commands in it; a calibration compares what robots did with what they"
            " were told, which a pose log holds"
        )
    return Log(
        t=run.t,
        poses=run.poses,
        commands=run.command,
        status=np.full(rows, "none") if run.status is None else run.status,
        moved=np.full(rows, math.nan) if run.moved is None else run.moved,
        clearance=np.full(rows, math.nan) if run.clearance is None else run.clearance,
        metadata=dict(run.parameters),
    )


def resimulate(log: Log, profile: Profile, seed: int = 0) -> Log:
    """Drive simulated robots with a log's commands, under a profile, from its first poses.

    Parameters
    ----------
    log : Log
        With commands.
    profile : Profile
        Such as :meth:`Calibration.profile`.
    seed : int
        Of the profile's randomness.

    Returns
    -------
    Log
        The same times and commands, and the poses that the simulator gives.
    """
    from rps_compat.arena import Arena

    dt = time_step_of(log, None)
    start = log.poses[0].copy()
    if profile.heading_offset is not None and profile.heading_offset.radians.kind == "robots":
        # The log's first headings have the offset already, which the profile will add.
        start[2] -= profile.heading_offset.radians.draw(log.robots, np.random.default_rng(seed))
    arena = Arena(start, realism=profile.start(), rng=np.random.default_rng(seed))
    poses = np.empty_like(log.poses)
    for k, command in enumerate(log.commands):
        poses[k] = arena.observe()
        arena.commands = np.array(command)
        arena.step()
    known = {**log.metadata, "resimulated_with": profile.name, "seed": seed, "time_step": dt}
    return Log(log.t, poses, log.commands, log.status, log.moved, log.clearance, known)


def write_log(log: Log, path: Path) -> Path:
    """Write a log to ``path`` (.npy and .json) and return the array's path."""
    known = {k: v for k, v in log.metadata.items() if k not in ("ended", "format", "versions")}
    with PoseLog(path, log.robots, len(log.t), known) as out:
        for k, t in enumerate(log.t):
            out.append(float(t), log.poses[k], log.commands[k], status=str(log.status[k]))
    return out.path


def write_profile(profile: Profile, path: Path) -> None:
    """Write a profile as TOML.

    Raises
    ------
    OutputError
        Where that is not possible.
    """
    from rps_compat.profiles import profile_to_toml

    try:
        path.write_text(profile_to_toml(profile), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write the profile {path}: {error}") from error
