"""One simulated trial of the flock in the arena, in memory: what studies are made of.

`experiments/robotarium_9bot.py` does the same through the Robotarium's API and onto disk;
here nothing is written, so that hundreds of trials cost no more than their computing.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import LawParameters
from posflock_robotarium.flocking.pose_log import row_type
from posflock_robotarium.logs.run import How, Run
from rps_compat.arena import Arena
from rps_compat.arena_guests import Realism
from rps_compat.testbed import GRITSBOT_X, RobotModel


@dataclass(frozen=True, eq=False)
class Trial:
    """What a trial leaves.

    Attributes
    ----------
    log : Run
        What the controller read and sent, as a pose log would hold it.
    true_poses : (T, 3, N) array
        Where the robots were when the poses of `log` were read; the same in the ideal arena.
    """

    log: Run
    true_poses: NDArray[np.float64]

    def truth(self) -> Run:
        """Return the log with true poses in place of those that tracking reported."""
        return replace(self.log, poses=self.true_poses)


def simulate(
    flock: Flock,
    start: ArrayLike,
    duration: float,
    *,
    robot: RobotModel | None = None,
    realism: Realism | None = None,
    seed: int = 0,
) -> Trial:
    """Let a flock drive in the arena for some time.

    Parameters
    ----------
    flock : Flock
        The controller; it is reset first.
    start : (3, N) array
        First poses, metres and radians.
    duration : float
        Seconds.
    robot : RobotModel, optional
        The robots and the arena that they drive in and are judged by; by default GRITSBot X in the
        arena, and with the time step, that the flock is made for.
    realism : Realism, optional
        Imperfections of motors and tracking; none in the ideal arena.
    seed : int
        What the imperfections are drawn from.

    Raises
    ------
    ParameterError
        Where the start or the duration means nothing, or the robots' time step is not the flock's.
    """
    robot = robot_for(flock, robot)
    flock.reset()
    steps = flock.steps_in(duration)
    rng = np.random.default_rng(seed)
    arena = Arena(np.asarray(start, dtype=float), robot, realism=realism, rng=rng)
    rows = np.zeros(steps, dtype=row_type(arena.number_of_robots))
    true_poses = np.empty((steps, 3, arena.number_of_robots))
    for step in range(steps):
        true_poses[step] = arena.poses
        poses = arena.observe()
        decision = flock.step(poses)
        row = rows[step]
        row["t"] = step * flock.time_step
        row["pose"] = poses
        for name, value in decision.logged().items():
            row[name] = value
        arena.commands = decision.command
        arena.step()
    log = Run(
        name="flock",
        t=rows["t"],
        poses=rows["pose"],
        commands=rows["command"],
        status=rows["status"],
        intervention=rows["intervention"],
        clearance=rows["clearance"],
        parameters=described(flock, robot, steps, seed),
    )
    return Trial(log, true_poses)


def robot_for(flock: Flock, robot: RobotModel | None) -> RobotModel:
    """Return the robots that a flock drives; refuse those of another time step.

    Parameters
    ----------
    flock : Flock
        Whose arena and time step they are to have.
    robot : RobotModel or None
        What was asked for; by default GRITSBot X in the flock's arena.

    Raises
    ------
    ParameterError
        Where the robots' time step is not the flock's.
    """
    if robot is None:
        return replace(GRITSBOT_X, boundaries=flock.arena, time_step=flock.time_step)
    if robot.time_step != flock.time_step:
        raise ParameterError(
            f"robot: its time step is {robot.time_step:g} s, and the flock's {flock.time_step:g} s;"
            " make the flock with the robot's"
        )
    return robot


def described(
    flock: Flock, robot: RobotModel, steps: int, seed: int, law: LawParameters | None = None
) -> dict[str, Any]:
    """Return what a pose log would say of a trial in its JSON.

    Parameters
    ----------
    flock : Flock
        Whose parameters decide the run.
    robot : RobotModel
        What it drove.
    steps : int
        How many.
    seed : int
        What imperfections were drawn from.
    law : LawParameters, optional
        What was followed in the place of the flock's own law.
    """
    return flock.parameters(law) | {
        "seed": seed,
        "simulated": True,
        "robot": asdict(robot),
        "ended": {"how": How.FINISHED.value, "reason": "", "rows": steps},
    }
