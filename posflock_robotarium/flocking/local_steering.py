r"""Arena steering without a mean over the flock: each robot keeps estimates of its own.

`steering` turns the flock's common velocity, which nobody in the flock can see. Here every robot
estimates what it needs from its own numbers and from one `Message` that each neighbour sent at the
last step; whom it neither sees nor hears changes nothing that it does in this step.

- *Common velocity and common input* by dynamic average consensus: an estimate moves towards those
  of neighbours, and by as much as the robot's own value :math:`x_i` changed,

  .. math:: \hat x_i \leftarrow \hat x_i + \sum_j a_{ij} (\hat x_j - \hat x_i)
            + x_i - x_i^{\text{before}}.

  Metropolis weights, :math:`a_{ij} = 1/(1 + \max(d_i, d_j))` with the degrees that were sent, are
  the same in both directions, so that the mean of all estimates stays the mean of all values. A
  robot's input counts smoothed: what it changes by at once is its own business, and an estimate
  that follows it would, once the flock is turned half around, drive the formation's springs the
  wrong way.
- *The call of the walls* is a maximum and not a mean: how far any robot is within reach of a wall.
  It goes from neighbour to neighbour and fades on the way, faster than a flock leaves a wall, so
  that nobody hears an old call of his own for ever.
- *Which way to turn* has to be one way for all. It is a count that only grows: 3 k while the flock
  has turned k times and goes straight on, then 3 k + 1 for a turn to the right or 3 k + 2 for one
  to the left, then 3 (k + 1). Whoever finds that a turn has to begin or to end counts on; everybody
  takes over the largest count that he hears. So two that begin at once, one to either side, agree
  within as many steps as the flock is wide (left wins), and a turn that has ended does not come
  back from a robot that hears of its end later. A turn begins a little later than it might and
  is not taken up again at once, so that robots whose estimates differ a little agree on that, too.
- *By how much the flock has been turned* is counted by each robot, and drawn to its neighbours'.

Metropolis weights: Xiao, Boyd and Lall, *A scheme for robust distributed sensor fusion based on
average consensus* (2005). Dynamic average consensus: Zhu and Martínez, *Discrete-time dynamic
average consensus* (2010); Kia et al., *Tutorial on dynamic average consensus* (2019).
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.steering import SteeringParameters, WallSteering, added_by_turning

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

_STRAIGHT, _RIGHT, _LEFT = 0, 1, 2


@dataclass(frozen=True)
class LocalSteeringParameters(SteeringParameters):
    """How a flock is turned away from a wall by robots that know their neighbours alone.

    Attributes
    ----------
    smoothing : float
        Time constant with which a robot's own input enters its estimate of the common one, s.
    fading : float
        By how much the call of a wall fades on its way through the flock, m/s.
    onset : float
        Metres of call from which on a turn begins, so that all have heard of it; any keeps it up.
    band : float
        By how much the cosine at which a turn begins is less than `clear`, at which it ends.

    Raises
    ------
    ParameterError
        Where a value is out of its range.
    """

    smoothing: float = 2.0
    fading: float = 0.1
    onset: float = 0.015
    band: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("smoothing", "fading"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(f"{name}: expected finite and more than zero, got {value!r}")
        for name, most in (("onset", self.reach), ("band", 1.0 + self.clear)):
            value = getattr(self, name)
            if not 0.0 <= value < most:
                raise ParameterError(
                    f"{name}: expected from 0 to less than {most:g}, got {value!r}"
                )


def as_local(parameters: SteeringParameters) -> LocalSteeringParameters:
    """Return parameters of steering with what robots need besides that know neighbours alone.

    Parameters
    ----------
    parameters : SteeringParameters
        How to steer; local ones stay as they are.
    """
    if isinstance(parameters, LocalSteeringParameters):
        return parameters
    return LocalSteeringParameters(**asdict(parameters))


class Message(NamedTuple):
    """What each robot tells its neighbours once a step, for all robots.

    Attributes
    ----------
    degree : (N,) array
        How many neighbours it had.
    velocity, input : (2, N) array
        Its estimates of the common velocity, m/s, and the common input, m/s².
    call : (4, N) array
        How far it knows the flock to be within reach of the walls at the least x, greatest x, least
        y and greatest y, m.
    angle : (N,) array
        By how much the flock has been turned, rad.
    turns : (N,) integer array
        The count of turns.
    """

    degree: Integers
    velocity: Floats
    input: Floats
    call: Floats
    angle: Floats
    turns: Integers


class LocalSteering(WallSteering):
    """What turns a flock off the walls where each robot knows its neighbours alone.

    Parameters
    ----------
    parameters : LocalSteeringParameters
        How to steer.
    arena, margin, time_step
        See `WallSteering`.
    """

    parameters: LocalSteeringParameters

    def __init__(
        self,
        parameters: LocalSteeringParameters,
        arena: tuple[float, float, float, float],
        margin: float,
        time_step: float,
    ) -> None:
        super().__init__(parameters, arena, margin, time_step)
        self._smoothing = min(1.0, time_step / parameters.smoothing)
        self.reset()

    def reset(self) -> None:
        """Forget every estimate and message: the next step is the first."""
        self._sent: Message | None = None
        self._velocity: Floats = np.zeros((2, 0))  # a robot's own, as they counted last
        self._input: Floats = np.zeros((2, 0))

    @property
    def sent(self) -> Message | None:
        """What robots told their neighbours at the last step; None before the first."""
        return self._sent

    def steer(
        self, time: float, points: Floats, inputs: Floats, velocities: Floats, linked: Booleans
    ) -> tuple[Floats, Floats, Floats]:
        """Turn the common velocity, as each robot knows it, away from near walls.

        Parameters
        ----------
        time : float
            Seconds since the imprint.
        points, inputs, velocities : (2, N) array
            Look-ahead points in metres; the law's inputs in m/s²; velocities in m/s.
        linked : (N, N) boolean array
            Row i marks the neighbours of robot i; the same both ways.

        Returns
        -------
        inputs : (2, N) array
            The turned inputs, m/s².
        velocities : (2, N) array
            The turned velocities, m/s.
        turning : (N,) array
            By how much each robot turned its velocity, rad.
        """
        heard = self._heard(linked, inputs, velocities)
        call = self._call(points, linked, heard)
        turns: Integers = heard.turns
        turning: Floats = np.zeros(points.shape[1])
        if ties.beyond(time, self.parameters.start):
            turns = self._turns(turns, heard.velocity, call)
            turning = np.choose(turns % 3, (0.0, -1.0, 1.0)) * (
                self.parameters.turn_rate * self.time_step
            )
        angle = heard.angle + turning
        self._sent = heard._replace(degree=linked.sum(axis=1), call=call, turns=turns, angle=angle)
        return (
            inputs + added_by_turning(heard.input, angle),
            velocities + added_by_turning(heard.velocity, turning),
            turning,
        )

    def _heard(self, linked: Booleans, inputs: Floats, velocities: Floats) -> Message:
        """Return what each robot knows once it has heard its neighbours."""
        sent = self._sent
        if sent is None:  # the first step: everybody knows himself
            self._velocity, self._input = velocities.copy(), inputs.copy()
            none = np.zeros(linked.shape[0])
            count = none.astype(np.int64)
            return Message(count, velocities, inputs, np.zeros((4, none.shape[0])), none, count)
        weight = linked / (1.0 + np.maximum(sent.degree[:, None], sent.degree))
        own = 1.0 - weight.sum(axis=1)
        calm = self._input + self._smoothing * (inputs - self._input)
        velocity = own * sent.velocity + _over(weight, sent.velocity)
        common = own * sent.input + _over(weight, sent.input)
        heard = sent._replace(
            velocity=velocity + (velocities - self._velocity),
            input=common + (calm - self._input),
            angle=own * sent.angle + _over(weight, sent.angle),
            turns=np.maximum(sent.turns, np.where(linked, sent.turns, 0).max(axis=1)),
        )
        self._velocity, self._input = velocities.copy(), calm
        return heard

    def _call(self, points: Floats, linked: Booleans, heard: Message) -> Floats:
        """Return how far each robot knows the flock to be within reach of each wall, m."""
        own = self.call(points, points)
        told = np.where(linked, heard.call[:, None, :], 0.0).max(axis=2)
        fainter = np.maximum(told, heard.call) - self.parameters.fading * self.time_step
        call: Floats = np.maximum(own, fainter)
        return call

    def _turns(self, turns: Integers, common: Floats, call: Floats) -> Integers:
        """Return the counts of turns now that each robot has judged by what it knows."""
        inward = np.array([call[0] - call[1], call[2] - call[3]])
        along = (common * inward).sum(axis=0)
        lengths = np.hypot(*common) * np.hypot(*inward)
        clear, moving = self.parameters.clear, lengths > 0.0
        calm = moving & (along >= clear * lengths) | ~ties.beyond(call, 0.0).any(axis=0)
        near = ties.beyond(call, self.parameters.onset).any(axis=0)
        near &= ~moving | (along < (clear - self.parameters.band) * lengths)
        across = common[0] * inward[1] - common[1] * inward[0]
        side = np.where(ties.reached(across, 0.0), _LEFT, _RIGHT)
        straight = turns % 3 == _STRAIGHT
        begun = np.where(straight & near, turns + side, turns)
        ended: Integers = np.where(~straight & calm, turns - turns % 3 + 3, begun)
        return ended


def _over(weight: Floats, values: Floats) -> Floats:
    """Return Σ_j weight[i, j]·values[..., j] for each robot i."""
    summed: Floats = (weight * values[..., None, :]).sum(axis=-1)
    return summed
