"""Certificates for robots that go where they are told: ẋ = v."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

from barrier_certificates import checks
from barrier_certificates.array_types import FloatArray
from barrier_certificates.certificate import Certificate
from barrier_certificates.per_robot import PerRobot, check_limit
from barrier_certificates.projection import ProjectionInfo
from barrier_certificates.rows import (
    LimitRows,
    Margin,
    Obstacle,
    Scene,
    UnequalLimitRows,
    VelocityPolygon,
)

__all__ = ["SingleIntegratorCertificate"]


@dataclass(frozen=True)
class SingleIntegratorCertificate(Certificate):
    """The safe velocities nearest to the desired ones, for a team of single integrators.

    All other parameters are those of `barrier_certificates.certificate.Certificate`.

    Parameters
    ----------
    speed_limit : float or (N,) array-like or None
        Largest speed, m/s: an octagon inscribed in the circle of the limit (for another shape, see
        ``limits``); None means no limit. Of all robots, or of each.

    Examples
    --------
    >>> certificate = SingleIntegratorCertificate(boundary=(-1.6, 1.6, -1.0, 1.0))
    >>> velocity, info = certificate([[0.2, -0.2], [0.0, 0.0]], [[-0.1, 0.1], [0.0, 0.0]])
    >>> print(info.status, info.active)
    optimal ('robots 0 and 1',)
    """

    may_differ: ClassVar[tuple[str, ...]] = (*Certificate.may_differ, "speed_limit")

    _: KW_ONLY
    speed_limit: PerRobot | None = 0.2

    def check(self) -> None:
        """Refuse parameters that make no sense."""
        super().check()
        check_limit("speed_limit", self.speed_limit, "of m/s")

    def _motor_limits(self) -> LimitRows | None:
        if self.speed_limit is None:
            return None
        if isinstance(self.speed_limit, tuple):
            return UnequalLimitRows([VelocityPolygon.octagon(s) for s in self.speed_limit])
        return VelocityPolygon.octagon(self.speed_limit).rows()  # type: ignore[arg-type]

    def __call__(
        self, desired: Any, positions: Any, obstacles: Sequence[Obstacle] | None = None
    ) -> tuple[FloatArray, ProjectionInfo]:
        """Return the safe velocities nearest to the desired ones.

        Parameters
        ----------
        desired : (2, N) array
            Commands, m/s.
        positions : (2, N) array
            Positions, m.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, instead of those of the certificate.

        Returns
        -------
        velocity : (2, N) array
            Safe velocities, m/s.
        info : ProjectionInfo
            What was done.

        Raises
        ------
        ShapeError
            If the shapes do not fit.
        InfeasibleError, NotFiniteError
            Under the policy ``"raise"``.
        """
        desired, positions = checks.team(desired, positions, "positions", 2, self.team_size)
        if not checks.finite(desired, positions):
            return self._refuse(desired)
        return self._certify(desired, Scene(positions), obstacles)

    def margins(
        self, positions: Any, within: float = 0.1, obstacles: Sequence[Obstacle] | None = None
    ) -> list[Margin]:
        """Return every pair, wall, obstacle and link that is near to its limit, the nearest first.

        Parameters
        ----------
        positions : (2, N) array
            Positions, m.
        within : float
            Leave out what is clear by more than this, m.
        obstacles : sequence of Disc or Segment, optional
            Obstacles as they are now, instead of those of the certificate.
        """
        positions = checks.columns("positions", positions, 2, self.team_size)
        return self._margins(Scene(positions), within, obstacles)
