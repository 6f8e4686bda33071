"""What agents sense instead of the truth: noise, dropout, delay; and agents that fail.

The paper argues that a law without velocity sensing is robust: it "enhances robustness to
noise" and "enables fault-tolerant alignment under sensing or communication failures".  It
measures neither.  The effects here stand between the true state and the law's input, for
the position-based models and the velocity-based baseline alike:

=================  =========================================================================
position noise     every agent's position is measured by one tracking system, with an
                   independent Gaussian error per coordinate and step
velocity noise     the same for velocities, which only the velocity-based model reads
dropout            agent i misses neighbour j with a fixed probability, at every step anew
delay              everything sensed is a fixed time old
failures           at a given time a share of the agents stops dead (and is still sensed as
                   an obstacle to alignment), or vanishes (and is sensed no more)
=================  =========================================================================
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import neighbours

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Sensing:
    """How far what agents sense is from the truth; the default is perfect sensing.

    Attributes
    ----------
    position_noise : float
        Standard deviation per coordinate, metres.
    velocity_noise : float
        Standard deviation per coordinate, m/s.
    dropout : float
        Probability, from 0 to 1, that agent i misses neighbour j at one step.
    delay : float
        Age in seconds of what is sensed, rounded to whole steps.
    failing : float
        Share of the agents that fail, from 0 to below 1, rounded down to whole agents.
    failure_time : float
        When they fail, seconds.
    failure : {"stop", "vanish"}
        Whether a failed agent stands still where it is, or is gone.

    Raises
    ------
    ParameterError
        Where a value is outside its range.
    """

    position_noise: float = 0.0
    velocity_noise: float = 0.0
    dropout: float = 0.0
    delay: float = 0.0
    failing: float = 0.0
    failure_time: float = 30.0
    failure: Literal["stop", "vanish"] = "stop"

    def __post_init__(self) -> None:
        for name in ("position_noise", "velocity_noise", "delay", "failure_time"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ParameterError(f"{name}: expected zero or more, got {value!r}")
        if not 0.0 <= self.dropout <= 1.0:
            raise ParameterError(f"dropout: expected a probability, got {self.dropout!r}")
        if not 0.0 <= self.failing < 1.0:
            raise ParameterError(
                f"failing: expected a share of the agents from 0 to below 1, got {self.failing!r}"
            )
        if self.failure not in ("stop", "vanish"):
            raise ParameterError(f'failure: expected "stop" or "vanish", got {self.failure!r}')


@dataclass(frozen=True, eq=False)
class Sensed:
    """What a law is told at one step, of every flock b of a batch and every agent i.

    Attributes
    ----------
    positions, velocities : (B, d, n) array
        As they are sensed, metres and m/s.
    first_positions : (B, d, n) array
        As they were sensed at the first step: what an imprint is made of.
    time : float
        Seconds; the first input is computed at t = dt.
    detected : (B, n, n) boolean array or None
        Row i marks the agents that i does not miss; None where no one is missed.
    """

    positions: Floats
    velocities: Floats
    first_positions: Floats
    time: float
    detected: Booleans | None = None

    def neighbours(self, radius: float | Floats) -> Booleans:
        """Tell who is whose neighbour: within the radius, and not missed.

        Parameters
        ----------
        radius : float or (n,) array
            Interaction radius, m.

        Returns
        -------
        (B, n, n) boolean array
            Row i marks the neighbours of i.
        """
        near = neighbours(self.positions, radius)
        return near if self.detected is None else near & self.detected


class Sensors:
    """What the agents of a batch of flocks sense, step after step.

    Each flock draws from its own generator, so that its run is the same alone and in a batch.

    Parameters
    ----------
    sensing : Sensing
        How wrong, how late and how seldom they sense, and who fails.
    generators : sequence of Generator
        One for each flock.
    agents : int
        n.
    time_step : float
        Seconds.
    """

    def __init__(
        self,
        sensing: Sensing,
        generators: Sequence[np.random.Generator],
        agents: int,
        time_step: float,
    ) -> None:
        self.sensing = sensing
        self._generators = generators
        self._past: deque[tuple[Floats, Floats]] = deque(
            maxlen=1 + ties.nearest_whole(sensing.delay / time_step)
        )
        self.failing = np.zeros((len(generators), agents), dtype=bool)
        for row, generator in zip(self.failing, generators, strict=True):
            chosen = generator.permutation(agents)[: ties.whole(sensing.failing * agents)]
            row[chosen] = True

    def read(self, positions: Floats, velocities: Floats) -> tuple[Floats, Floats]:
        """Return positions and velocities as they are sensed at this step.

        Parameters
        ----------
        positions : (B, d, n) array
            True positions, m.
        velocities : (B, d, n) array
            True velocities, m/s.

        Returns
        -------
        positions : (B, d, n) array
            Sensed positions, m.
        velocities : (B, d, n) array
            Sensed velocities, m/s.
        """
        self._past.append((positions, velocities))
        p, v = self._past[0]
        return self._noisy(p, self.sensing.position_noise), self._noisy(
            v, self.sensing.velocity_noise
        )

    def failed(self, time: float) -> Booleans | None:
        """Return who has failed, or None where no one has.

        Parameters
        ----------
        time : float
            Seconds since the imprint.

        Returns
        -------
        (B, n) boolean array or None
            True for an agent that has.
        """
        started = self.sensing.failing > 0.0 and ties.reached(time, self.sensing.failure_time)
        return self.failing if started else None

    def detected(self, time: float) -> Booleans | None:
        """Return who senses whom at this step, or None where nothing is hidden.

        Parameters
        ----------
        time : float
            Seconds since the imprint.

        Returns
        -------
        (B, n, n) boolean array or None
            Row i marks whom i senses.
        """
        agents = self.failing.shape[-1]
        hidden = self._hidden(time)
        if self.sensing.dropout == 0.0 and hidden is None:
            return None
        seen = np.stack([self._keep(flock, agents * agents) for flock in range(len(self.failing))])
        seen = seen.reshape(-1, agents, agents)
        return seen if hidden is None else seen & ~hidden[:, None, :]

    def detected_among(self, flock: int, other: NDArray[np.intp], time: float) -> Booleans | None:
        """Return which pairs of a list are sensed: the same effects for sparse flocks.

        Parameters
        ----------
        flock : int
            Number of the flock in the batch.
        other : (M,) integer array
            Whom the agent of each pair may sense.
        time : float
            Seconds since the imprint.

        Returns
        -------
        (M,) boolean array or None
            True for a pair that is sensed; None where nothing is hidden.
        """
        hidden = self._hidden(time)
        if self.sensing.dropout == 0.0 and hidden is None:
            return None
        seen = self._keep(flock, len(other))
        return seen if hidden is None else seen & ~hidden[flock, other]

    def _keep(self, flock: int, pairs: int) -> Booleans:
        """Draw which of so many pairs of one flock escape dropout."""
        if self.sensing.dropout == 0.0:
            return np.ones(pairs, dtype=bool)
        return np.asarray(self._generators[flock].random(pairs) >= self.sensing.dropout)

    def _hidden(self, time: float) -> Booleans | None:
        return self.failed(time) if self.sensing.failure == "vanish" else None

    def _noisy(self, states: Floats, deviation: float) -> Floats:
        if deviation == 0.0:
            return states
        errors = [generator.standard_normal(states.shape[1:]) for generator in self._generators]
        return states + deviation * np.stack(errors)
