r"""Point agents in the plane or in space: the simulation of the paper.

Agents are double integrators without walls or wheels.  One step of length dt is
semi-implicit Euler with both saturations fed back into the state:

.. code-block:: text

    t ← t + dt                        the first input is computed at t = dt
    u ← sat(law(p, v, t), u_max)
    v ← sat(v + dt·u, v_max)
    p ← p + dt·v

The paper leaves the discretisation open, and it matters.  The position-based law has no
damping of relative motion of its own; the saturation that is fed back supplies it, at a
rate of about :math:`\|v\|^2 / (3 v_{max}^2\,dt)`, so that results depend on dt.  Explicit
Euler destroys alignment (γ near 0), and saturating only what is applied, or clipping hard,
reverses the paper's ranking of the models.  Flocks drift because the law is not
reciprocal: neighbours i and j may have different |N|.

A batch of flocks advances together in arrays (B, d, n), one row of random numbers each, so
that a run is the same, bit for bit, alone and in a batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import (
    PAPER_SIMULATION,
    LawParameters,
    saturate,
)
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.inputs import DenseInput, Input, OwnInput, OwnLaw, TreeInput
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS
from posflock_robotarium.freespace.sensing import Sensing, Sensors

Floats = NDArray[np.float64]
Seed = int | np.random.SeedSequence | np.random.Generator

#: Numbers in one (B, n, n) array of a batch that still fits the processor's cache.
_CACHED_NUMBERS = 20_000


#: Agents, steps and recorded coordinates of a flock beyond which nobody waits for its end.
MOST_AGENTS, MOST_STEPS, MOST_RECORDED = 100_000, 10**8, 10**9


@dataclass(frozen=True)
class FreeSpace:
    """A simulation without walls; the defaults are the paper's.

    Attributes
    ----------
    model : Model
        Which law the agents follow.
    agents : int
        n, at least 2.
    dimensions : int
        2 or 3.
    side : float
        Agents start uniformly in a square or cube of this side, metres.
    fastest_start : float
        Initial speeds are uniform from 0 to this, m/s, in random directions.
    duration : float
        Seconds.
    time_step : float
        dt, seconds.  Not in the paper; 0.05 reproduces it.
    record_interval : float
        Seconds between recorded states, rounded to whole steps.
    law : LawParameters
        δ, r, k and the limits, each possibly one per agent.
    sensing : Sensing
        Noise, dropout, delay and failures; perfect by default.
    own_law : function of (Sensed, LawParameters), optional
        Computes the input in place of `model`: what is sensed in arrays (B, d, n) and the
        parameters in, inputs (B, d, n) in m/s² out, before saturation.  The functions of
        :mod:`posflock_robotarium.flocking.law` take such arrays.  Each flock's input may
        depend on that flock alone.

    Raises
    ------
    ParameterError
        Where a value is outside its range.
    """

    model: Model = Model.POSITION
    agents: int = 50
    dimensions: int = 2
    side: float = 25.0
    fastest_start: float = 1.0
    duration: float = 100.0
    time_step: float = 0.05
    record_interval: float = 0.25
    law: LawParameters = PAPER_SIMULATION
    sensing: Sensing = field(default_factory=Sensing)
    own_law: OwnLaw | None = None

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "model", Model(self.model))
        except ValueError:
            names = ", ".join(model.value for model in Model)
            raise ParameterError(f"model: expected one of {names}, got {self.model!r}") from None
        if self.dimensions not in (2, 3):
            raise ParameterError(f"dimensions: expected 2 or 3, got {self.dimensions!r}")
        if not isinstance(self.agents, (int, np.integer)) or not 2 <= self.agents <= MOST_AGENTS:
            raise ParameterError(
                f"agents: expected a whole number from 2 to {MOST_AGENTS}, got {self.agents!r}"
            )
        for name in ("side", "duration", "time_step", "record_interval"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ParameterError(f"{name}: expected more than zero, got {value!r}")
        if not (np.isfinite(self.fastest_start) and self.fastest_start >= 0.0):
            raise ParameterError(
                f"fastest_start: expected zero or more, got {self.fastest_start!r}"
            )
        if self.duration < self.time_step:
            raise ParameterError(
                f"duration: expected at least one time step of {self.time_step} s,"
                f" got {self.duration!r}"
            )
        if self.record_interval > self.duration:
            raise ParameterError(
                f"record_interval: expected at most the duration of {self.duration} s,"
                f" got {self.record_interval!r}"
            )
        self.law.agents_must_be(self.agents)
        self._require_affordable()

    def _require_affordable(self) -> None:
        """Refuse what no machine has the time or the memory for: a slip of the pen."""
        steps, records = self.duration / self.time_step, self.duration / self.record_interval
        if steps > MOST_STEPS:
            raise ParameterError(
                f"duration: expected at most {MOST_STEPS} steps, got {steps:.3g} of"
                f" {self.time_step} s"
            )
        if records * self.agents * self.dimensions > MOST_RECORDED:
            raise ParameterError(
                f"record_interval: {records:.3g} states of {self.agents} agents are more than fit"
                f" into memory; expected at most {MOST_RECORDED} coordinates"
            )

    @property
    def steps(self) -> int:
        """Number of steps in the duration."""
        return ties.nearest_whole(self.duration / self.time_step)

    def as_dict(self) -> dict[str, Any]:
        """Return every parameter as numbers, strings and lists, ready for JSON."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        own = values.pop("own_law")
        if own is not None:
            values["own_law"] = getattr(own, "__name__", repr(own))
        return values | {
            "model": self.model.value,
            "law": self.law.as_dict(),
            "sensing": asdict(self.sensing),
        }


@dataclass(frozen=True, eq=False)
class PointRun:
    """States of one flock, or of a batch of flocks, over time.

    Attributes
    ----------
    times : (T,) array
        Seconds; the first is 0.
    positions, velocities : (T, d, n) or (B, T, d, n) array
        True states, metres and m/s.
    failing : (n,) or (B, n) boolean array
        Agents that fail at some time of the run.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    failing: NDArray[np.bool_]

    def __getitem__(self, flock: int) -> PointRun:
        """Return one flock of a batch."""
        return PointRun(
            self.times, self.positions[flock], self.velocities[flock], self.failing[flock]
        )


def simulate(scenario: FreeSpace, seed: Seed) -> PointRun:
    """Run one flock.

    Parameters
    ----------
    scenario : FreeSpace
        What to simulate.
    seed : int, SeedSequence or Generator
        Initial states first, then whatever noise `scenario` asks for, are drawn from it.  The
        models therefore start identically from equal seeds.

    Returns
    -------
    PointRun
        States (T, d, n) every ``record_interval``, the first at t = 0.

    Raises
    ------
    ParameterError
        Where a parameter does not fit the others.

    Examples
    --------
    >>> run = simulate(FreeSpace(agents=10, side=10.0, duration=5.0), seed=1)
    >>> run.positions.shape
    (21, 2, 10)
    """
    return simulate_batch(scenario, [seed])[0]


def simulate_batch(scenario: FreeSpace, seeds: Sequence[Seed]) -> PointRun:
    """Run one flock for each seed, several at a time in one array.

    Parameters
    ----------
    scenario : FreeSpace
        What to simulate.
    seeds : sequence of seeds
        One for each flock, see :func:`simulate`.

    Returns
    -------
    PointRun
        States (B, T, d, n); flock b is what ``simulate(scenario, seeds[b])`` returns.

    Raises
    ------
    ParameterError
        Where there is no seed.
    """
    together = max(1, _CACHED_NUMBERS // scenario.agents**2)
    parts = [
        _simulate(scenario, [np.random.default_rng(seed) for seed in seeds[at : at + together]])
        for at in range(0, len(seeds), together)
    ]
    if not parts:
        raise ParameterError("seeds: expected at least one, got none")
    return PointRun(
        parts[0].times,
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.velocities for part in parts]),
        np.concatenate([part.failing for part in parts]),
    )


def initial_states(scenario: FreeSpace, generator: np.random.Generator) -> tuple[Floats, Floats]:
    """Draw positions in the square or cube, and velocities of random direction.

    Parameters
    ----------
    scenario : FreeSpace
        Number of agents, dimensions, side, fastest start.
    generator : Generator
        Where they are drawn from.

    Returns
    -------
    positions : (d, n) array
        Positions, m.
    velocities : (d, n) array
        Velocities, m/s.
    """
    shape = (scenario.agents, scenario.dimensions)
    positions = generator.uniform(0.0, scenario.side, shape).T
    direction = generator.standard_normal(shape).T
    speed = generator.uniform(0.0, scenario.fastest_start, scenario.agents)
    return positions, direction * (speed / np.sqrt(np.square(direction).sum(axis=0)))


def euler_step(
    positions: Floats, velocities: Floats, inputs: Floats, time_step: float, law: LawParameters
) -> tuple[Floats, Floats]:
    """Advance (..., d, n) states by one semi-implicit Euler step, saturations fed back.

    Parameters
    ----------
    positions, velocities : (..., d, n) array
        Metres and m/s.
    inputs : (..., d, n) array
        What the law asks for, before saturation, m/s².
    time_step : float
        Seconds.
    law : LawParameters
        v_max and u_max are used.

    Returns
    -------
    positions, velocities : (..., d, n) array
        One step later.
    """
    applied = saturate(inputs, law.input_limit)
    v = saturate(velocities + time_step * applied, law.speed_limit)
    return positions + time_step * v, v


def _simulate(scenario: FreeSpace, generators: Sequence[np.random.Generator]) -> PointRun:
    """Advance a batch of flocks from start to end."""
    starts = [initial_states(scenario, generator) for generator in generators]
    # stack would keep the transposed layout of the draws, and every later step pay for it.
    p, v = (np.ascontiguousarray(np.stack(states)) for states in zip(*starts, strict=True))
    sensors = Sensors(scenario.sensing, generators, scenario.agents, scenario.time_step)
    wanted = _law(scenario, sensors)
    every = max(1, ties.nearest_whole(scenario.record_interval / scenario.time_step))
    recorded = [(p, v)]
    for step in range(1, scenario.steps + 1):
        time = step * scenario.time_step
        inputs = wanted(p, v, time)
        failed = sensors.failed(time)
        p_next, v = euler_step(p, v, inputs, scenario.time_step, scenario.law)
        if failed is not None:
            v = np.where(failed[:, None, :], 0.0, v)
            p_next = np.where(failed[:, None, :], p, p_next)
        p = p_next
        if step % every == 0:
            recorded.append((p, v))
    return PointRun(
        times=np.arange(len(recorded), dtype=float) * (every * scenario.time_step),
        positions=np.stack([positions for positions, _ in recorded], axis=1),
        velocities=np.stack([velocities for _, velocities in recorded], axis=1),
        failing=sensors.failing,
    )


def _law(scenario: FreeSpace, sensors: Sensors) -> Input:
    if scenario.own_law is not None:
        return OwnInput(scenario.own_law, scenario.law, sensors)
    kind = TreeInput if scenario.agents >= TREE_FROM_AGENTS else DenseInput
    return kind(
        scenario.law,
        sensors,
        velocity_based=scenario.model is Model.VELOCITY,
        threshold=scenario.model is Model.POSITION,
    )
