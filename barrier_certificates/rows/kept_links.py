"""Which links of a team are kept, so that its communication graph stays connected.

A graph is connected as long as one of its spanning trees is there, so N − 1 links are enough. Which
tree that is may be decided afresh at every step: any spanning tree of the graph as it is now, kept
for this step, is a spanning tree of the graph after it. The *shortest* one, of which the longest
link is as short as possible, leaves most room.

Where two trees are all but equally short, the choice would go to and fro, and the robots with it.
So links of the last tree count as shorter by a part (*hysteresis*), as long as they are in range.

A team that is not connected has no such tree. Then the links between its parts are those of the
shortest tree of all, beyond range as they are: by Kruskal's algorithm it takes links within range
first, so that what is connected stays so.

The other way, a barrier on the second eigenvalue of the graph's Laplacian (Capelli and Sabattini,
Connectivity maintenance: global and optimized approach through control barrier functions, IEEE
International Conference on Robotics and Automation (2020)), is a row only where that eigenvalue is
simple, which in regular formations it is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, Literal, get_args

import numpy as np

from barrier_certificates import checks, ties
from barrier_certificates.array_types import BoolArray, FloatArray, IntArray
from barrier_certificates.certificate_errors import ParameterError, ShapeError
from barrier_certificates.per_robot import PerRobot, as_numbers
from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.links import LinkBarrier

Choice = Literal["tree", "all"]

_LARGEST_SINE = 0.5
"""Rows turned by more than 30° would hold robots back that are nowhere near the range."""


@dataclass(frozen=True)
class ConnectivityParameters:
    """How far robots communicate, and which of their links are kept.

    Parameters
    ----------
    communication_range : float
        Largest distance between two linked positions, m. Of unicycles these are projection points:
        the centres' less 2 d keeps centres within range.
    links : {"tree", "all"} or sequence of pairs
        ``"tree"``: at each call those of the shortest spanning tree, so that the team stays
        connected; ``"all"``: those that are in range at the first call; or pairs of robots.
    gain : float
        γ, in 1/(m⁴ s): larger lets links reach the range faster. Zero: never any longer.
    hysteresis : float
        By which part links of the last tree count as shorter: 0 is the shortest tree at each call,
        1 that of the first call as long as it is in range.
    time_step : float, optional
        For how long velocities are held, s; zero promises for continuous time alone. That of the
        certificate if None, or zero where it has none.

    Raises
    ------
    ParameterError
        If a parameter makes no sense; the message names it.

    Examples
    --------
    >>> from barrier_certificates.single_integrator import SingleIntegratorCertificate
    >>> parameters = ConnectivityParameters(0.5, time_step=0.033)
    >>> connected = SingleIntegratorCertificate(connectivity=parameters)
    >>> velocity, info = connected([[-0.2, 0.2], [0.0, 0.0]], [[-0.24, 0.24], [0.0, 0.0]])
    >>> print(info.status, set(info.active))
    optimal {'robots 0 and 1 in range'}
    >>> print(f"{info.range_left:.2f} m are left of the range")
    0.02 m are left of the range
    """

    communication_range: float
    links: Choice | Sequence[tuple[int, int]] = "tree"
    _: KW_ONLY
    gain: float = 100.0
    hysteresis: float = 0.1
    time_step: float | None = None

    def __post_init__(self) -> None:
        checks.positive("communication_range", self.communication_range, "of metres")
        checks.not_negative("gain", self.gain)
        checks.not_negative("hysteresis", self.hysteresis)
        if self.hysteresis > 1.0:
            raise ParameterError(f"hysteresis is {self.hysteresis!r}; expected a part, 0 to 1")
        if self.time_step is not None:
            checks.not_negative("time_step", self.time_step, "of seconds")
        if not isinstance(self.links, str) or self.links not in get_args(Choice):
            object.__setattr__(self, "links", _pairs(self.links))

    def reach(self) -> float:
        """Return how far a robot has to see to know its links, m: for a tree the whole team."""
        return np.inf if self.links == "tree" else self.communication_range

    def barrier(
        self, time_step: float, top_speed: float, disturbance: WheelDisturbance | None
    ) -> LinkBarrier:
        """Return what is kept of every link.

        Parameters
        ----------
        time_step : float
            That of the certificate, s; zero if it has none.
        top_speed : float
            No robot is told to be faster, m/s.
        disturbance : WheelDisturbance, optional
            What the wheels may do on their own.

        Raises
        ------
        ParameterError
            If robots are too fast for the time step.
        """
        step = time_step if self.time_step is None else self.time_step
        speed = top_speed + (0.0 if disturbance is None else disturbance.top_speed())
        barrier = LinkBarrier(self.communication_range, self.gain, step, 2.0 * speed, disturbance)
        if ties.beyond(barrier.sine, _LARGEST_SINE):
            raise ParameterError(
                f"communication_range is {self.communication_range:g} m; expected at least"
                f" {2.0 * speed * step / _LARGEST_SINE:.3g} m for robots that drive at up to"
                f" {speed:.3g} m/s for {step:g} s, or a speed limit, or a shorter time_step"
            )
        return barrier


class KeptLinks:
    """Decides which links are kept, and remembers it.

    Parameters
    ----------
    connectivity : ConnectivityParameters
        How far robots communicate, and what is asked for.
    """

    def __init__(self, connectivity: ConnectivityParameters) -> None:
        self._wanted = connectivity
        self._given: IntArray | None = None
        if not isinstance(connectivity.links, str):
            self._given = np.array(connectivity.links, dtype=np.intp).T
        self.forget()

    def forget(self) -> None:
        """Forget what was kept: the next team is the first."""
        self._kept: IntArray | None = None
        self._number = 0

    def keep(self, positions: FloatArray) -> IntArray:
        """Return which links are kept from these positions on; the same array if the same ones are.

        Parameters
        ----------
        positions : (2, N) array
            Where the robots are, m.

        Returns
        -------
        (2, m) integer array
            The two robots of each link, the smaller number first, in order.

        Raises
        ------
        ShapeError
            If links were given for a larger team.
        """
        links = self.choose(positions)
        if self._kept is None or not np.array_equal(links, self._kept):
            self._kept, self._number = links, positions.shape[1]
        return self._kept

    def choose(self, positions: FloatArray) -> IntArray:
        """Return which links would be kept; nothing is remembered.

        Parameters
        ----------
        positions : (2, N) array
            Where the robots are, m.

        Returns
        -------
        (2, m) integer array
            As `keep` returns them.

        Raises
        ------
        ShapeError
            If links were given for a larger team.
        """
        number = positions.shape[1]
        if self._given is not None:
            if self._given.max() >= number:
                raise ShapeError(
                    f"links name robot {self._given.max()}, but the team has {number}; expected"
                    f" numbers from 0 to {number - 1}"
                )
            return self._given
        kept = self._kept if self._number == number else None
        if kept is not None and self._wanted.links == "all":
            return kept
        length = np.hypot(*(positions[:, :, None] - positions[:, None, :]))
        in_range: BoolArray = ties.within(length, self._wanted.communication_range)
        tree = self._tree(length, in_range, kept)
        if self._wanted.links == "all":
            in_range[tree[0], tree[1]] = True
            return np.stack(np.triu(in_range, 1).nonzero())
        return tree

    def _tree(self, length: FloatArray, in_range: BoolArray, kept: IntArray | None) -> IntArray:
        """Return the shortest spanning tree, its links in order."""
        if kept is not None and kept.shape[1]:
            there = kept[:, in_range[kept[0], kept[1]]]
            length = length.copy()
            for one, other in (there, there[::-1]):
                length[one, other] *= 1.0 - self._wanted.hysteresis
        # Of links that are equally long, the first is taken.
        tree = np.sort(spanning_tree(np.round(length / ties.TIE)), axis=0)
        return tree[:, np.lexsort(tree[::-1])]


def spanning_tree(length: FloatArray) -> IntArray:
    """Return the shortest spanning tree of a complete graph, by Prim's algorithm.

    Parameters
    ----------
    length : (N, N) array
        How long each edge is, the same both ways; of equals the first is taken.

    Returns
    -------
    (2, N − 1) integer array
        Where edges begin and end.
    """
    number = length.shape[0]
    tree = np.empty((2, number - 1), dtype=np.intp)
    outside = np.ones(number, dtype=bool)
    nearest, distance, new = np.zeros(number, dtype=np.intp), np.full(number, np.inf), 0
    for edge in range(number - 1):
        outside[new], distance[new] = False, np.inf
        closer = (length[new] < distance) & outside
        distance[closer] = length[new][closer]
        nearest[closer] = new
        new = int(distance.argmin())
        tree[:, edge] = nearest[new], new
    return tree


def require_connectivity(connectivity: Any, safety_radius: PerRobot) -> None:
    """Refuse what is no connectivity, and a range within which robots must not come.

    Parameters
    ----------
    connectivity : ConnectivityParameters
        What was given.
    safety_radius : float or (N,) array-like
        What is kept between two positions, m; of unequal robots half of the one's and half of the
        other's.

    Raises
    ------
    ParameterError
        If it is something else, or its range is not larger than the radius.
    """
    if not isinstance(connectivity, ConnectivityParameters):
        raise ParameterError(
            f"connectivity is {connectivity!r}; expected ConnectivityParameters or None"
        )
    apart = _closest(connectivity.links, safety_radius)
    if not connectivity.communication_range > apart:
        raise ParameterError(
            f"communication_range is {connectivity.communication_range:g} m; expected more than"
            f" the {apart:g} m that robots are kept apart"
        )


def _closest(links: Choice | Sequence[tuple[int, int]], safety_radius: PerRobot) -> float:
    """Return how far apart robots that have to be linked are kept at least, m."""
    half = 0.5 * as_numbers(safety_radius)
    if not isinstance(half, np.ndarray):
        return 2.0 * half
    if isinstance(links, str):  # the largest robot has a link, be it to the smallest
        return float(half.max() + half.min())
    named = [float(half[i] + half[j]) for i, j in links if j < half.shape[0]]
    return max(named, default=0.0)  # who names robots that there are not is refused by the team


def _pairs(links: Any) -> tuple[tuple[int, int], ...]:
    """Return links as pairs of numbers, the smaller one first, in order."""
    try:
        given = np.asarray(links)
    except ValueError:
        raise _no_links(links) from None
    whole = given.ndim == 2 and given.shape[0] > 0 and np.issubdtype(given.dtype, np.integer)
    if not (whole and given.shape[1] == 2 and (given >= 0).all()):
        raise _no_links(links)
    pairs = sorted({(min(pair), max(pair)) for pair in given.tolist()})
    if any(one == other for one, other in pairs):
        raise _no_links(links)
    return tuple(pairs)


def _no_links(links: Any) -> ParameterError:
    return ParameterError(
        f"links are {links!r}; expected one of {', '.join(get_args(Choice))}, or pairs of two"
        " different robots' numbers"
    )
