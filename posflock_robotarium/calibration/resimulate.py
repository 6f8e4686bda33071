"""Read a log that has commands, drive simulated robots with them, and write what comes out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.calibration.increments import NO_COMMANDS, held_commands
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import LayoutError, ReadOptions, read
from posflock_robotarium.logs.real_time import over_real_time
from posflock_robotarium.logs.run import Run
from rps_compat.arena import Arena
from rps_compat.distributions import DistributionKind
from rps_compat.kinematics import wrap
from rps_compat.realism import Profile
from rps_compat.whole_files import write_whole

Floats = NDArray[np.float64]


def read_commanded(path: Path | str, options: ReadOptions | None = None) -> Run:
    """Read a log that has commands from any file that the report reads.

    Parameters
    ----------
    path : path
        A pose log, with or without ``.npy``, or an archive with poses, times and commands.
    options : ReadOptions, optional
        What the user says about the file.

    Returns
    -------
    Run
        Over its real time, where it holds that: robots drove in that one.

    Raises
    ------
    LogError
        Where the file is missing, damaged, ambiguous or holds no commands.
    """
    try:
        run = read(path, options)
    except LayoutError as error:
        if options is not None:
            raise
        raise LogError(
            f"{error}; `posflock convert --to npz` with that option writes a file that says so"
        ) from error
    if run.commands is None:
        raise LogError(f"{path}: {NO_COMMANDS}")
    return run if run.real_time is None else over_real_time(run)


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
        Where the log has no commands.
    """
    if log.commands is None:
        raise LogError(f"{log.name}: {NO_COMMANDS}")
    start = log.poses[0].copy()
    if (
        profile.heading_offset is not None
        and profile.heading_offset.radians.kind is DistributionKind.ROBOTS
    ):
        # The log's first headings have the offset already, which the profile will add.
        start[2] -= profile.heading_offset.radians.draw(log.robots, np.random.default_rng(seed))
    arena = Arena(start, log.robot, realism=profile.start(), rng=np.random.default_rng(seed))
    t, (commands, _) = log.t - log.t[0], held_commands(log.commands)
    poses = _at_times(t, *_driven(arena, t, commands))
    known = {
        **{k: v for k, v in log.parameters.items() if k not in ("ended", "format", "versions")},
        "resimulated_with": profile.name,
        "seed": seed,
        "time_step": arena.robot.time_step,
        "simulated": True,
    }
    # What a certificate said of other poses says nothing of these.
    unknown = replace(log, intervention=None, clearance=None, status=None, real_time=None)
    return replace(unknown, poses=poses, parameters=known)


def _driven(arena: Arena, t: Floats, commands: Floats) -> tuple[Floats, Floats]:
    """Step an arena until the last row, at its own pace; return its times and observed poses.

    A command is given in the step nearest to its row and holds from there; robots whose next one is
    late hear nothing meanwhile, and their watchdog may brake.
    """
    step = arena.robot.time_step
    rows = np.round(t / step).astype(int)
    seen = []
    for moment in range(int(rows[-1]) + 1):
        seen.append(arena.observe().copy())
        now = int(np.searchsorted(rows, moment, side="right")) - 1
        if rows[now] == moment:
            arena.commands = np.array(commands[now])
        arena.step()
    grid: Floats = step * np.arange(len(seen), dtype=float)
    return grid, np.array(seen)


def _at_times(t: Floats, grid: Floats, poses: Floats) -> Floats:
    """Interpolate poses (S, 3, N) on a grid (S,) at other times (T,), as (T, 3, N)."""
    after = np.clip(np.searchsorted(grid, t), 1, len(grid) - 1)
    share = np.clip((t - grid[after - 1]) / (grid[after] - grid[after - 1]), 0.0, 1.0)
    change = poses[after] - poses[after - 1]
    change[:, 2] = wrap(change[:, 2])
    out: Floats = poses[after - 1] + share[:, None, None] * change
    out[:, 2] = wrap(out[:, 2])
    return out


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
