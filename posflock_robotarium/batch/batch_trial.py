"""Trials of many teams at once in the simulated arena: what studies are made of.

Each trial is what `simulation.flock_trial.simulate` returns for the same start and seed: the same
law, arena, imperfections and random numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.batch import Engine
from posflock_robotarium.batch.batch_flock import WORDS, BatchFlock
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import LawParameters
from posflock_robotarium.logs.run import Run
from posflock_robotarium.simulation.flock_trial import Trial, described, robot_for
from rps_compat.arena_guests import Realism
from rps_compat.batch import BatchArena
from rps_compat.realism import Profile
from rps_compat.testbed import RobotModel

__all__ = ["simulate_teams"]


def simulate_teams(
    flock: Flock,
    starts: ArrayLike,
    duration: float,
    *,
    seeds: Sequence[int],
    robot: RobotModel | None = None,
    realism: Profile | Sequence[Profile | Realism | None] | None = None,
    laws: Sequence[LawParameters] | None = None,
    engine: Engine = "auto",
    threads: int | None = None,
) -> list[Trial]:
    """Let B flocks drive for some time, each in an arena of its own.

    All trials are kept in memory: about 0.6 kB a step and team of nine.

    Parameters
    ----------
    flock : Flock
        What every team follows. Its state is neither used nor changed.
    starts : (B, 3, N) array
        First poses, metres and radians.
    duration : float
        Seconds.
    seeds : sequence of B int
        What the imperfections of each team are drawn from.
    robot : RobotModel, optional
        The robots and the arena that they drive in and are judged by; by default GRITSBot X in the
        arena, and with the time step, that the flock is made for.
    realism : Profile or sequence of B Profile, Realism or None, optional
        Imperfections of motors and tracking, alike for all or of each team; none in the ideal
        arena.
    laws : sequence of B LawParameters, optional
        What each team follows in the place of the flock's law.
    engine : {"auto", "numba", "numpy"}
        Who computes certificate and arena; ``"auto"`` is compiled where numba is installed.
    threads : int, optional
        How many parts of the teams are computed side by side at most; one for each processor if
        None.

    Returns
    -------
    list of Trial
        One for each team.

    Raises
    ------
    ParameterError
        Where starts, seeds, laws or the duration mean nothing, or the robots' time step is not the
        flock's.
    CommandError
        Where there are not as many profiles as teams.
    EngineNotInstalledError
        If numba is asked for but not installed.
    """
    poses = np.asarray(starts, dtype=float)
    if poses.ndim != 3 or len(seeds) != len(poses):
        raise ParameterError(
            f"starts have shape {poses.shape} and there are {len(seeds)} seeds; expected (B, 3, N),"
            " and a seed for each of B teams"
        )
    robot = robot_for(flock, robot)
    steps = flock.steps_in(duration)
    flocks = BatchFlock(flock, len(poses), engine=engine, threads=threads, laws=laws)
    arena = BatchArena(poses, robot, realism=realism, seeds=seeds, engine=engine, threads=threads)
    rows = _Rows(steps, *poses.shape[::2])
    for step in range(steps):
        rows.true_poses[:, step] = arena.poses
        seen = arena.observe()
        decision = flocks.step(seen)
        rows.poses[:, step], rows.commands[:, step] = seen, decision.command
        rows.status[:, step] = decision.status
        rows.intervention[:, step], rows.clearance[:, step] = (
            decision.intervention,
            decision.clearance,
        )
        arena.commands = decision.command
        arena.step()
    followed = [flock.law] * len(poses) if laws is None else laws
    return [
        rows.trial(team, described(flock, robot, steps, int(seed), law))
        for team, (seed, law) in enumerate(zip(seeds, followed, strict=True))
    ]


class _Rows:
    """What all trials leave, team by team."""

    def __init__(self, steps: int, teams: int, robots: int) -> None:
        self.true_poses = np.empty((teams, steps, 3, robots))
        self.poses = np.empty((teams, steps, 3, robots))
        self.commands = np.empty((teams, steps, 2, robots))
        self.status: NDArray[np.intp] = np.empty((teams, steps), dtype=np.intp)
        self.intervention = np.empty((teams, steps))
        self.clearance = np.empty((teams, steps))

    def trial(self, team: int, parameters: dict[str, Any]) -> Trial:
        """Return the trial of one team, of which a log says so much."""
        steps = np.arange(self.status.shape[1])
        times = np.asarray(steps * parameters["time_step"], dtype=np.float64)
        log = Run(
            name="flock",
            t=times,
            poses=self.poses[team],
            commands=self.commands[team],
            status=WORDS[self.status[team]],
            intervention=self.intervention[team],
            clearance=self.clearance[team],
            parameters=parameters,
        )
        return Trial(log, self.true_poses[team])
