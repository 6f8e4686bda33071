r"""How far noise may have moved γ: a 95 % band for the γ that the same run has without noise.

Every direction of motion carries an error :math:`\epsilon_i` of known variance, so that γ, a sum of
cosines, reads

.. math:: \gamma(\varphi + \epsilon) \approx \gamma + g^\top \epsilon
          + \tfrac12 \epsilon^\top H \epsilon.

The quadratic part is what makes γ of parallel robots too small: noise can take from 1, never add to
it. A band around the reading would therefore miss the truth where it matters most. So three things
are done.

The bias is taken out: a cosine times :math:`e^{(\sigma_i^2 + \sigma_j^2)/2}` is right on average.

The spread is that of both parts: variance :math:`g^\top \Sigma g + \frac12 \mathrm{tr}(H\Sigma)^2`,
and the skewness that goes with it. Of the noisy gradient's square, :math:`\mathrm{tr}(H\Sigma)^2`
is noise and is taken off.

The band is the set of γ under which such a reading is none of the rarest 5 %. The nearer to a
summit such as 1, the smaller is the linear part; on the summit itself the reading can only be too
small, and all 5 % lie on that side (as Feldman and Cousins order them, Phys. Rev. D 57, 1998). So
the band is never empty, and never reaches beyond 1 or -1.

Who is a neighbour, and who moves, is in doubt near the thresholds: what such a change would do to γ
is added to the band.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from barrier_certificates.ties import beyond
from posflock_robotarium.alignment.gamma_band_ends import BandMoments, ends_of
from posflock_robotarium.flocking.law import neighbours
from posflock_robotarium.freespace.neighbour_search import TREE_FROM_AGENTS, pairs_within

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Integers = NDArray[np.intp]
_Product: TypeAlias = Callable[[Floats], Floats]

LARGEST_ERROR = 0.2
"""Radians: standard deviation of a direction beyond which the expansion above no longer holds."""

#: Standard deviations within which a speed, and a distance, may lie on the other side. Several
#: distances may be in doubt at once, which seldom all are what they do not seem: so fewer.
_DOUBTFUL, _DOUBTFUL_DISTANCE = 1.96, 1.28


@dataclass(frozen=True, eq=False)
class Band:
    """Ends of the band.

    Attributes
    ----------
    low, high : (T,) array
        γ, from -1 to 1; NaN where γ is undefined, or a direction too uncertain.
    """

    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of robots, and how uncertain they are.

    Attributes
    ----------
    velocities : (T, 2, N) array
        m/s, or unit headings.
    variance : (T, N) array
        Of each direction, rad².
    speed_noise : (T,) array
        Standard deviation of each coordinate of the velocities, m/s; 0 for headings.
    slowest : float
        Speed up to which a robot has no direction, m/s.
    """

    velocities: Floats
    variance: Floats
    speed_noise: Floats
    slowest: float

    def at(self, stretch: slice) -> Directions:
        """Return the same at some samples.

        Parameters
        ----------
        stretch : slice
            Which.
        """
        return Directions(
            self.velocities[stretch],
            self.variance[stretch],
            self.speed_noise[stretch],
            self.slowest,
        )


def of_motion(velocities: Floats, speed_noise: Floats, slowest: float) -> Directions:
    """Return the directions of estimated velocities.

    Parameters
    ----------
    velocities : (T, 2, N) array
        m/s.
    speed_noise : (T,) array
        Standard deviation of each of their coordinates, m/s.
    slowest : float
        Speed up to which a robot has no direction, m/s.
    """
    noise = np.square(speed_noise)[:, np.newaxis]
    squares = np.square(velocities).sum(axis=1) + noise
    # The noise is added since a velocity that noise made small would seem too uncertain: so the
    # mean of what is estimated is the variance of the angle, up to a fourth of a radian.
    variance = np.divide(noise, squares, out=np.zeros_like(squares), where=squares > 0)
    return Directions(velocities, variance, speed_noise, slowest)


def of_headings(unit: Floats, noise: float) -> Directions:
    """Return the directions of tracked headings.

    Parameters
    ----------
    unit : (T, 2, N) array
        Unit vectors along the headings.
    noise : float
        Standard deviation of a heading, rad.
    """
    samples, _, robots = unit.shape
    return Directions(unit, np.full((samples, robots), noise**2), np.zeros(samples), 0.0)


def gamma_band(
    directions: Directions,
    positions: Floats,
    radius: float | Floats,
    position_noise: float,
    stretches: Iterable[slice],
    heard: Callable[[slice], Booleans] | None = None,
) -> Band:
    """Return the band of γ over time.

    Parameters
    ----------
    directions : Directions
        Where robots point or go.
    positions : (T, 2, N) array
        Metres.
    radius : float or (N,) array
        Neighbour radius of each robot, m.
    position_noise : float
        Standard deviation of each coordinate, m.
    stretches : iterator of slice
        Samples that are worked on at a time, all together the whole run.
    heard : callable, optional
        Takes a stretch of K samples and returns who is whose neighbour, (K, N, N), where that is
        known already.

    Returns
    -------
    Band
        In which γ without noise lies at every time, with the probability `CONFIDENCE`.
    """
    parts = [
        _spread(
            directions.at(stretch),
            positions[stretch],
            radius,
            position_noise,
            neighbours(positions[stretch], radius) if heard is None else heard(stretch),
        )
        for stretch in stretches
    ]
    spread = BandMoments(
        *(np.concatenate([getattr(p, each.name) for p in parts]) for each in fields(BandMoments))
    )
    low, high = ends_of(spread)
    low, high = low + spread.doubt_below, high + spread.doubt_above
    return Band(np.clip(low, -1.0, 1.0), np.clip(high, -1.0, 1.0))


def _spread(
    d: Directions, p: Floats, radius: float | Floats, noise: float, heard: Booleans
) -> BandMoments:
    speed = np.sqrt(np.square(d.velocities).sum(axis=1))
    moving = beyond(speed, d.slowest)
    links = heard & moving[:, np.newaxis, :] & moving[:, :, np.newaxis]
    cosines, sines = (
        np.divide(d.velocities[:, k], speed, out=np.zeros_like(speed), where=moving) for k in (0, 1)
    )
    variance = np.where(moving, d.variance, 0.0)
    centre, moments = _moments(links, cosines, sines, variance)
    below, above = _doubtful_links(
        p, radius, noise, links, moving, (cosines, sines, variance), centre
    )
    margin = (_DOUBTFUL * d.speed_noise)[:, np.newaxis]
    doubtful = (np.abs(speed - d.slowest) < margin) & (speed > 0)
    rows = np.flatnonzero(doubtful.any(axis=1))
    for certain in (True, False) if rows.size else ():
        other = _centre_of(d, heard, moving & ~doubtful if certain else moving | doubtful, rows)
        below[rows] += np.minimum(other - centre[rows], 0.0)
        above[rows] += np.maximum(other - centre[rows], 0.0)
    counted = links.any(axis=2)
    unsure = (counted & (variance > LARGEST_ERROR**2)).any(axis=1)
    return BandMoments(np.where(unsure, np.nan, centre), *moments, below, above)


def _shares(links: Booleans) -> tuple[Floats, NDArray[np.intp]]:
    """Return what each pair of a robot contributes to γ, (T, N), and how many robots count."""
    number = links.sum(axis=2)
    counted = (number > 0).sum(axis=1)
    share = np.divide(1.0, number, out=np.zeros(number.shape), where=number > 0)
    return share / np.maximum(counted, 1)[:, np.newaxis], counted


def _products_of_pairs(links: Booleans, share: Floats) -> tuple[_Product, _Product]:
    """Return products with each sample's weights of unordered pairs, and with their squares."""
    if links.shape[2] < TREE_FROM_AGENTS:
        weights = links * share[:, :, np.newaxis]
        pairs = weights + np.swapaxes(weights, 1, 2)
        return partial(np.matmul, pairs), lambda columns: np.square(pairs) @ columns
    sparse = []
    for linked, shares in zip(links, share, strict=True):
        one, other = np.nonzero(linked)
        weights_of_one = csr_array((shares[one], (one, other)), shape=linked.shape)
        sparse.append(weights_of_one + weights_of_one.T)
    squares = [pairs.power(2) for pairs in sparse]
    return partial(_each, sparse), partial(_each, squares)


def _each(matrices: list[csr_array], columns: Floats) -> Floats:
    """Return the products of each sample's matrix with its columns, (T, N, M)."""
    return np.stack([m @ x for m, x in zip(matrices, columns, strict=True)])


def _moments(
    links: Booleans, c: Floats, s: Floats, variance: Floats
) -> tuple[Floats, tuple[Floats, Floats, Floats, Floats]]:
    """Return γ less its bias, and the moments of a `BandMoments`."""
    share, counted = _shares(links)
    times, times_squares = _products_of_pairs(links, share)
    lift = np.exp(variance / 2)
    sums = times(np.stack([c, s, lift * c, lift * s], axis=2))
    curvature = -lift * (c * sums[:, :, 2] + s * sums[:, :, 3])  # diagonal of H, bias taken out
    centre = np.where(counted > 0, -0.5 * curvature.sum(axis=1), np.nan)
    gradient = c * sums[:, :, 1] - s * sums[:, :, 0]
    y = variance * gradient
    bent = times(np.stack([c * y, s * y], axis=2))
    bent_y = curvature * y + c * bent[:, :, 0] + s * bent[:, :, 1]
    linear = (gradient * y).sum(axis=1)
    # Of tr (HΣ)² beside the diagonal: squared cosines of differences by those of twice the angle.
    twice_c, twice_s = c**2 - s**2, 2 * c * s
    columns = np.stack([variance, variance * twice_c, variance * twice_s], axis=2)
    off = np.where(variance > 0, variance, 0.0)[:, :, np.newaxis] * np.stack(
        [np.ones_like(c), twice_c, twice_s], axis=2
    )
    square = np.square(curvature * variance).sum(axis=1) + 0.5 * (off * times_squares(columns)).sum(
        axis=(1, 2)
    )
    trace = (curvature * variance).sum(axis=1)
    # Where the gradient is nothing but rounding, it has no direction: the mean curvature stands in.
    upright, steep = np.abs(trace) > 0, linear > 1e-9 * square
    bending = 2 * np.divide(square, trace, out=np.zeros_like(trace), where=upright)
    bending = np.where(steep, 2 * (y * bent_y).sum(axis=1) / np.where(steep, linear, 1), bending)
    one_sided = np.divide(trace**2, square, out=np.ones_like(square), where=square > 0)
    return centre, (linear, square, bending, np.minimum(one_sided, 1.0))


def _centre_of(d: Directions, heard: Booleans, moving: Booleans, rows: NDArray[np.intp]) -> Floats:
    """Return γ less its bias at some samples, were these robots the ones that move."""
    v, moves = d.velocities[rows], moving[rows]
    speed = np.sqrt(np.square(v).sum(axis=1))
    links = heard[rows] & moves[:, np.newaxis, :] & moves[:, :, np.newaxis]
    unit = np.divide(v, speed[:, np.newaxis], out=np.zeros_like(v), where=moves[:, np.newaxis])
    share, counted = _shares(links)
    weights = links * share[:, :, np.newaxis]
    lifted = np.exp(np.where(moves, d.variance[rows], 0.0) / 2)[:, np.newaxis] * unit
    around = lifted @ np.swapaxes(weights, 1, 2)
    return np.where(counted > 0, (lifted * around).sum(axis=(1, 2)), np.nan)


def _doubtful_links(
    p: Floats,
    radius: float | Floats,
    noise: float,
    links: Booleans,
    moving: Booleans,
    directions: tuple[Floats, Floats, Floats],
    centre: Floats,
) -> tuple[Floats, Floats]:
    """Return how far γ may fall and rise where noise decides who is a neighbour, (T,) each."""
    below, above = np.zeros(len(p)), np.zeros(len(p))
    t, i, j = _near_the_radius(p, radius, _DOUBTFUL_DISTANCE * np.sqrt(2.0) * noise)
    both = moving[t, i] & moving[t, j]
    t, i, j = t[both], i[both], j[both]
    if not t.size:
        return below, above
    c, s, variance = directions
    lift = np.exp(variance / 2)

    def cosine(a: NDArray[np.intp], b: NDArray[np.intp]) -> Floats:
        return np.asarray(lift[t, a] * lift[t, b] * (c[t, a] * c[t, b] + s[t, a] * s[t, b]))

    of_each = links.sum(axis=2)
    lifted = np.stack([lift * c, lift * s], axis=2)
    sums = (lifted * _around(links, lifted)).sum(axis=2)[t, i]
    number, count = of_each[t, i], (of_each > 0).sum(axis=1)[t]
    change = np.where(links[t, i, j], -1, 1)
    own = np.divide(sums, number, out=np.zeros(t.size), where=number > 0)
    after = number + change
    new = np.divide(sums + change * cosine(i, j), after, out=np.zeros(t.size), where=after > 0)
    robots_after = count + np.where(number == 0, 1, 0) - np.where(after == 0, 1, 0)
    total = np.where(count > 0, np.nan_to_num(centre[t]) * count, 0.0) - own + new
    gamma = np.divide(total, robots_after, out=np.full(t.size, np.nan), where=robots_after > 0)
    effect = gamma - centre[t]
    np.add.at(below, t, np.minimum(effect, 0.0))
    np.add.at(above, t, np.maximum(effect, 0.0))
    return below, above


def _around(links: Booleans, directions: Floats) -> Floats:
    """Return the sums of the neighbours' directions, (T, N, 2)."""
    if links.shape[2] < TREE_FROM_AGENTS:
        return np.asarray(links.astype(float) @ directions)
    return np.stack([csr_array(a) @ x for a, x in zip(links, directions, strict=True)])


def _near_the_radius(p: Floats, radius: float | Floats, margin: float) -> tuple[Integers, ...]:
    """Return sample, robot and other robot where their distance is nearly the robot's radius."""
    robots = p.shape[2]
    reach = np.broadcast_to(np.asarray(radius, dtype=float), robots)
    if robots >= TREE_FROM_AGENTS:
        return _near_by_tree(p, reach, margin)
    # Half of the pairs, since distances are mutual; all robots at once where radii are alike.
    first, second = np.triu_indices(robots, 1)
    squares = np.square(p[:, 0, first] - p[:, 0, second])
    squares += np.square(p[:, 1, first] - p[:, 1, second])
    apart = np.sqrt(squares, out=squares)
    t, pair = np.nonzero(np.abs(apart - reach[first]) < margin)
    found = [(t, first[pair], second[pair])]
    if np.ndim(radius):
        t, pair = np.nonzero(np.abs(apart - reach[second]) < margin)
    found.append((t, second[pair], first[pair]))
    where = [np.concatenate(each) for each in zip(*found, strict=True)]
    order = np.lexsort(where[::-1])
    return tuple(each[order] for each in where)


def _near_by_tree(p: Floats, reach: Floats, margin: float) -> tuple[Integers, ...]:
    """Return the same of many robots, most of whose pairs are far apart."""
    found = []
    for at, places in enumerate(p):
        first, second = pairs_within(places, float(reach.max()) + margin)
        apart = np.sqrt(np.square(places[:, first] - places[:, second]).sum(axis=0))
        for one, other in ((first, second), (second, first)):
            near = np.abs(apart - reach[one]) < margin
            found.append((np.full(int(near.sum()), at), one[near], other[near]))
    where = [np.concatenate(each) for each in zip(*found, strict=True)]
    order = np.lexsort(where[::-1])
    return tuple(each[order] for each in where)
