"""The simulated testbed for many teams at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from barrier_certificates.batch.compiling import Engine, is_compiled, over_teams
from rps_compat.arena import require_finite
from rps_compat.arena_guests import Array
from rps_compat.batch.batch_effects import BatchRealism, TeamRealism, begin, move
from rps_compat.batch.batch_violations import BatchViolations, empty_tally
from rps_compat.batch.step_arrays import judged
from rps_compat.batch.step_constants import constants_of
from rps_compat.batch.step_kernel import are_within, drive_teams
from rps_compat.errors import CommandError, InitialConditionsError
from rps_compat.realism import Profile
from rps_compat.testbed import GRITSBOT_X, RobotModel

__all__ = ["BatchArena"]

_LARGEST = 1e300


class BatchArena:
    """B teams of N robots, each in an arena of its own: what B instances of `Arena` do, in arrays.

    Motion, limits, what counts as a violation, imperfections and their random numbers are those of
    the single arena. With numba, steps of the ideal arena are compiled; numpy does the rest.

    Parameters
    ----------
    poses : (B, 3, N) array
        Initial poses, m and rad. Copied.
    robot : RobotModel
        Dimensions and limits.
    realism : Profile or sequence of B Profile, Realism or None, optional
        Imperfections of motors and tracking, alike for all or of each team: a profile, or what a
        single arena would be given, an object of its own; None is the ideal arena.
    seeds : sequence of int or Generator, optional
        What each team draws from, as ``default_rng(seed)`` in a single arena; needed with realism.
    engine : {"auto", "numba", "numpy"}
        Who computes; ``"auto"`` is compiled where numba is installed.
    threads : int, optional
        How many parts of the teams are computed side by side at most; one for each processor if
        None.

    Attributes
    ----------
    poses : (B, 3, N) array
        True poses now, m and rad.
    commands : (B, 2, N) array
        Velocities commanded, m/s and rad/s; after a step those that the wheels admit, held until
        others are set.
    velocities : (B, 2, N) array
        Velocities really driven in the last step, m/s and rad/s.
    steps : int
        Steps done.
    constants, tally, realism
        What steps are made of, counted in, and disturbed by; for rollouts.

    Raises
    ------
    InitialConditionsError
        If the poses are not of shape (B, 3, N), or not finite.
    CommandError
        If there are not as many seeds or profiles as teams.
    EngineNotInstalledError
        If numba is asked for but not installed.

    Examples
    --------
    >>> import numpy as np
    >>> teams = BatchArena(np.zeros((4, 3, 1)), engine="numpy")
    >>> teams.commands = np.full((4, 2, 1), 0.1)
    >>> teams.run(10)
    >>> teams.poses.shape, round(float(teams.poses[3, 0, 0]), 3)
    ((4, 3, 1), 0.033)
    """

    def __init__(
        self,
        poses: ArrayLike,
        robot: RobotModel = GRITSBOT_X,
        *,
        realism: Profile | Sequence[TeamRealism] | None = None,
        seeds: Sequence[int | np.random.Generator] | None = None,
        engine: Engine = "auto",
        threads: int | None = None,
    ) -> None:
        self.poses: Array = np.array(poses, dtype=float, order="C")
        if self.poses.ndim != 3 or self.poses.shape[1] != 3 or not np.isfinite(self.poses).all():
            raise InitialConditionsError(
                f"poses have shape {self.poses.shape}; expected (B, 3, N), finite numbers: for each"
                " of B teams a column (x, y, theta) a robot"
            )
        teams, _, robots = self.poses.shape
        self.robot = robot
        self.threads = threads
        self.compiled = is_compiled(engine)
        self.commands: Array = np.zeros((teams, 2, robots))
        self.velocities: Array = self.commands
        self.steps = 0
        self._held = self.commands
        self.constants = constants_of(robot)
        self.tally = empty_tally(teams, robots)
        self._observed: Array | None = None
        self.realism: BatchRealism | None = None
        if realism is not None:
            given = [realism] * teams if isinstance(realism, Profile) else realism
            generators = _generators(seeds, given, teams)
            self.realism = begin(given, self.poses, robot.time_step, generators)

    @property
    def violations(self) -> BatchViolations:
        """What would be held against each team so far."""
        return BatchViolations.of(self.tally)

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self.steps * self.robot.time_step

    def observe(self) -> Array:
        """Poses (B, 3, N) as the tracking system reports them; without realism the true ones."""
        if self.realism is None:
            return self.poses
        if self._observed is None:
            self._observed = self.realism.observe(self.poses)
        return self._observed

    def step(self) -> None:
        """Count violations, cut the commands at the wheels, drive for one time step.

        Raises
        ------
        CommandError
            Commands that are not finite, or not of shape (B, 2, N). No robot has moved then.
        """
        self.run(1)

    def run(self, steps: int) -> None:
        """Do some steps with the commands held.

        Parameters
        ----------
        steps : int
            How many, 0 or more.

        Raises
        ------
        CommandError
            Commands that are not finite, or not of shape (B, 2, N), or fewer steps than none. No
            robot has moved then.
        """
        require_steps(steps)
        fresh = self.commands is not self._held
        if fresh:
            self.commands = self._checked(self.commands)
        if self.compiled and self.realism is None:
            over_teams(
                drive_teams,
                len(self.poses),
                self.threads,
                self.constants,
                self.poses,
                self.commands,
                tuple(self.tally),
                steps,
            )
            self.velocities = self.commands
        else:
            for step in range(steps):
                self._step(fresh and step == 0)
        self._held = self.commands
        self._observed = None
        self.steps += steps

    def restart(self, teams: Sequence[int] | NDArray[np.intp], poses: ArrayLike) -> None:
        """Let some teams begin anew in the ideal arena: their poses, at rest, nothing counted.

        The clock is that of all teams, and goes on.

        Parameters
        ----------
        teams : (K,) array
            Which teams.
        poses : (K, 3, N) array
            Where their robots stand now, m and rad.

        Raises
        ------
        InitialConditionsError
            If the poses are not of shape (K, 3, N), or not finite.
        CommandError
            Under a realism profile, whose motors and streams know all teams: begin another arena.
        """
        if self.realism is not None:
            raise CommandError(
                "a team cannot begin anew under a realism profile: expected the ideal arena; make"
                " another BatchArena for such teams"
            )
        fresh = np.asarray(poses, dtype=float)
        chosen = np.asarray(teams, dtype=np.intp)
        if fresh.shape != (chosen.size, *self.poses.shape[1:]) or not np.isfinite(fresh).all():
            raise InitialConditionsError(
                f"poses have shape {fresh.shape}; expected {(chosen.size, *self.poses.shape[1:])},"
                " finite numbers, for the teams that begin anew"
            )
        self.poses[chosen] = fresh
        commands = self.commands.copy()
        commands[chosen] = 0.0
        self.commands = self.velocities = commands
        self.tally.steps[:, chosen] = 0
        self.tally.by_robot[:, chosen] = 0
        self.tally.extremes[:, chosen] = [[0.0], [np.inf]]

    def step_team(self, team: int, commands: Array) -> None:
        """Do a step of one team alone, in the ideal arena; `rolled` tells when all have done it.

        Parameters
        ----------
        team : int
            Which team.
        commands : (B, 2, N) array
            Commands of all teams, of which its own are cut in place at the wheels' limits.
        """
        drive_teams(team, team + 1, self.constants, self.poses, commands, tuple(self.tally), 1)

    def rolled(self, commands: Array, steps: int) -> None:
        """Take note of steps that were done elsewhere.

        Parameters
        ----------
        commands : (B, 2, N) array
            The commands at last, m/s and rad/s.
        steps : int
            How many steps.
        """
        self.commands = self._held = self.velocities = commands.copy()
        self._observed = None
        self.steps += steps

    def _step(self, fresh: bool) -> None:
        admitted, heading = judged(self.robot, self.poses, self.commands, self.tally)
        self.commands = self.velocities = admitted
        if self.realism is None:
            move(admitted, self.poses, self.robot.time_step, heading)
        else:
            seconds = self.robot.time_step
            self.velocities = self.realism.drive(admitted, self.poses, seconds, fresh)

    def _checked(self, commands: Array) -> Array:
        """Copy commands that can be driven."""
        copy = np.array(commands, dtype=float, order="C")
        if copy.shape != (len(self.poses), 2, self.poses.shape[2]):
            teams, _, robots = self.poses.shape
            raise CommandError(
                f"velocities have shape {copy.shape}, but {teams} teams of {robots} robots need"
                f" ({teams}, 2, {robots}): forward speeds in m/s, turn rates in rad/s"
            )
        small = are_within if self.compiled else _are_within
        if not small(copy, _LARGEST):
            for team, velocities in enumerate(copy):
                try:
                    require_finite(velocities)
                except CommandError as error:
                    raise CommandError(f"team {team}: {error}") from None
        return copy


def require_steps(steps: int) -> None:
    """Refuse fewer steps than none.

    Parameters
    ----------
    steps : int
        How many are asked for.

    Raises
    ------
    CommandError
        If they are negative.
    """
    if steps < 0:
        raise CommandError(f"steps: got {steps}; expected 0 or more")


def _are_within(commands: Array, largest: float) -> bool:
    return bool(np.abs(commands).max(initial=0.0) <= largest)


def _generators(
    seeds: Sequence[int | np.random.Generator] | None,
    given: Sequence[TeamRealism],
    teams: int,
) -> list[np.random.Generator]:
    if seeds is None or len(seeds) != teams:
        got = "none" if seeds is None else len(seeds)
        raise CommandError(f"seeds: got {got}; expected {teams} with realism, one for each team")
    if len(given) != teams:
        raise CommandError(
            f"realism: got {len(given)} profiles; expected one, or {teams}, one for each team"
        )
    own = [one for one in given if one is not None and not isinstance(one, Profile)]
    objects = len({id(one) for one in own})
    if objects < len(own):  # they remember what was driven
        raise CommandError(
            f"realism: got {objects} objects for {len(own)} teams; expected one of its own for"
            " each team that is given no profile"
        )
    return [np.random.default_rng(seed) for seed in seeds]
