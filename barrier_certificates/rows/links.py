r"""Rows that keep robots within range of each other, so that a team stays able to communicate.

A *link* is an edge of the communication graph: two robots no farther apart than the range R. Its
barrier is that of a pair turned round, ``h = R² − ‖D‖²`` with ``D = xᵢ − xⱼ``, and so is its row:
``2D·vᵢ − 2D·vⱼ ≤ γ h³``, along the unit vector ``u = D/ρ`` with ``ρ = ‖D‖``

    u·(vᵢ − vⱼ) ≤ b,    b = γ h³ / 2ρ.

**In steps of dt** a link differs from a pair: robots that pass each other sideways end a step
farther apart than the row along u knows, not nearer. So there are two rows, along u turned by ±φ,

    u(±φ)·(vᵢ − vⱼ) ≤ b cos φ,    b = min(γ h³ / 2ρ, (R − ρ) / 2dt),    sin φ = w dt / R,

where w is the largest speed at which two robots part. They keep ρ ≤ R exactly. Where R − ρ ≥ w dt
a step cannot reach R. Otherwise let q be what leads from the point R u to D after the step, so
that ‖q‖ ≤ R − ρ + w dt ≤ 2R sin φ. Both rows together say u(±φ)·q ≤ 0, and so u·q ≤ −‖q‖ sin φ:

    ‖R u + q‖² = R² + 2R u·q + ‖q‖² ≤ R² − ‖q‖ (2R sin φ − ‖q‖) ≤ R².

At most half of what is left is given away in a step, whatever the gain is; and b is never negative:
robots that stand still keep every link. Of a link that is lost already (ρ > R) the row asks that it
gets no longer, b = 0, which holds in steps by the same argument with ρ in the place of R. It does
not pull: where the way back leads is for who commands.

References
----------
Wang, Ames and Egerstedt, Multi-objective compositions for collision-free connectivity maintenance
in teams of mobile robots, IEEE Conference on Decision and Control (2016): barriers of edges, in
continuous time. The rows in steps are ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from barrier_certificates.array_types import FloatArray, IntArray
from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.pairs import COINCIDENT
from barrier_certificates.rows.row_family import NOTHING_NEAR, Barrier, RowFamily, Scene

_SQRT2 = math.sqrt(2.0)


class LinkBarrier(NamedTuple):
    """What is kept of every link, and how firmly.

    Attributes
    ----------
    communication_range : float
        Largest distance R between two linked positions, m.
    gain : float
        γ, in 1/(m⁴ s): how fast a link may lengthen.
    time_step : float
        For how long velocities are held, s; zero: not at all, time is continuous.
    parting_speed : float
        No two robots part faster, m/s; of no meaning without a time step.
    disturbance : WheelDisturbance, optional
        What the wheels may do on their own; rows then hold for the worst of it.
    """

    communication_range: float
    gain: float
    time_step: float
    parting_speed: float
    disturbance: WheelDisturbance | None

    @property
    def sine(self) -> float:
        """By how much rows are turned off the link, sin φ; zero in continuous time."""
        if not self.time_step:
            return 0.0
        return self.parting_speed * self.time_step / self.communication_range

    def room(self, distance: FloatArray) -> FloatArray:
        """Return how fast links may lengthen, b above.

        Parameters
        ----------
        distance : (m,) array
            Their lengths, m, none of them zero.

        Returns
        -------
        (m,) array
            Speeds, m/s, none of them negative.
        """
        left = np.maximum(self.communication_range - distance, 0.0)
        h = left * (self.communication_range + distance)
        room: FloatArray = 0.5 * self.gain * h * h * h / distance
        if self.time_step:
            np.minimum(room, 0.5 * left / self.time_step, out=room)
        return room


class LinkRows(RowFamily):
    """Linked robots stay within range of each other: 2D·vᵢ − 2D·vⱼ ≤ γ h³, h = R² − ‖D‖².

    Parameters
    ----------
    links : (2, m) integer array
        The two robots of each link.
    barrier : LinkBarrier
        What is kept of them.
    weight : float
        Cost of giving a row up when no velocity satisfies all rows: that of a wall's. Two robots
        that have to part are never held together by it.

    Attributes
    ----------
    longest : (float, int)
        What was left of the range at the longest link when rows were written last, m, and its row.
    """

    longest: tuple[float, int]

    def __init__(self, links: IntArray, barrier: LinkBarrier, weight: float = 1e4) -> None:
        self.links = links
        self.barrier = barrier
        self.weight = weight
        sine = barrier.sine
        self._cosine = math.sqrt(1.0 - sine * sine)
        self._sines = (sine, -sine) if sine else (0.0,)

    def partners(self, number: int) -> IntArray:
        """Return which robots each row joins: link by link, in steps of time twice."""
        return np.tile(self.links, len(self._sines))

    def prepare(self, number: int, coefficient: FloatArray, bound: FloatArray) -> None:
        """Write nothing: all of it changes with the positions."""

    def update(self, scene: Scene, coefficient: FloatArray, bound: FloatArray) -> Barrier:
        """Write the rows for the present positions; nothing is near, since nothing can collide."""
        first, second = self.links
        offset = scene.positions.take(first, axis=1)
        offset -= scene.positions.take(second, axis=1)
        distance = np.hypot(offset[0], offset[1])
        longest = int(distance.argmax())
        self.longest = self.barrier.communication_range - float(distance[longest]), longest
        # Of robots at one point the direction says nothing, and their row asks nothing.
        distance = np.maximum(distance, COINCIDENT)
        # Two unit vectors make a row of norm √2.
        x, y = offset / (_SQRT2 * distance)
        room = self.barrier.room(distance)
        room *= self._cosine / _SQRT2
        number = first.shape[0]
        for turn, sine in enumerate(self._sines):
            rows = slice(turn * number, (turn + 1) * number)
            bound[rows] = room
            coefficient[0, rows] = self._cosine * x - sine * y
            coefficient[1, rows] = self._cosine * y + sine * x
        np.negative(coefficient[:2], out=coefficient[2:])
        disturbance = self.barrier.disturbance
        if disturbance is not None:
            first, second = self.partners(0)
            bound -= disturbance.worst(scene, first, coefficient[:2])
            bound -= disturbance.worst(scene, second, coefficient[2:])
        return NOTHING_NEAR

    def measure(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return barrier, and what is left of the range in metres, once for each link."""
        offset = scene.positions[:, self.links[0]] - scene.positions[:, self.links[1]]
        distance = np.hypot(offset[0], offset[1])
        left: FloatArray = self.barrier.communication_range - distance
        return left * (self.barrier.communication_range + distance), left

    def label(self, number: int, row: int) -> str:
        """Say which two robots."""
        first, second = self.links[:, row % self.links.shape[1]]
        return f"robots {first} and {second} in range"
