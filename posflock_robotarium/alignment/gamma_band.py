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

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import beyond
from posflock_robotarium.flocking.law import neighbours

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]

CONFIDENCE = 0.95
"""Share of the samples in which the band holds the γ without noise."""

LARGEST_ERROR = 0.2
"""Radians: standard deviation of a direction beyond which the expansion above no longer holds."""

#: Standard deviations within which a speed, and a distance, may lie on the other side. Several
#: distances may be in doubt at once, which seldom all are what they do not seem: so fewer.
_DOUBTFUL, _DOUBTFUL_DISTANCE = 1.96, 1.28
#: Halvings of the interval in which an end of the band is sought: 1e-7 of a broad band.
_HALVINGS = 24
#: Least of the linear variance on a saddle, in units of the square: noise may have hidden as much.
SADDLE = 0.25
_MOST_SKEWED = 2.0 * np.sqrt(2.0)


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
    stretches: Iterator[slice],
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

    Returns
    -------
    Band
        In which γ without noise lies, with a probability of `CONFIDENCE` at every time.
    """
    parts = [
        _spread(directions.at(stretch), positions[stretch], radius, position_noise)
        for stretch in stretches
    ]
    spread = _Spread(
        *(np.concatenate([getattr(p, each.name) for p in parts]) for each in fields(_Spread))
    )
    low, high = _ends(spread)
    low, high = low + spread.doubt_below, high + spread.doubt_above
    return Band(np.clip(low, -1.0, 1.0), np.clip(high, -1.0, 1.0))


@dataclass(frozen=True, eq=False)
class _Spread:
    """What is known of γ at each sample, all (T,): moments of the expansion, and doubts.

    `centre` is γ less its bias; `linear` is g'Σg, `square` tr (HΣ)², `bending` how fast the
    variance g'Σg changes with γ: 2 g'ΣHΣg / g'Σg. `one_sided` is 1 on a summit or in a trough,
    where all curvatures have one sign, and falls to 0 on a saddle.
    """

    centre: Floats
    linear: Floats
    square: Floats
    bending: Floats
    one_sided: Floats
    doubt_below: Floats
    doubt_above: Floats


def _spread(d: Directions, p: Floats, radius: float | Floats, noise: float) -> _Spread:
    speed = np.sqrt(np.square(d.velocities).sum(axis=1))
    moving = beyond(speed, d.slowest)
    heard = neighbours(p, radius)
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
    return _Spread(np.where(unsure, np.nan, centre), *moments, below, above)


def _weights(links: Booleans) -> tuple[Floats, NDArray[np.intp]]:
    """Return what each ordered pair contributes to γ, (T, N, N), and how many robots count."""
    number = links.sum(axis=2)
    counted = (number > 0).sum(axis=1)
    share = np.divide(1.0, number, out=np.zeros(number.shape), where=number > 0)
    share /= np.maximum(counted, 1)[:, np.newaxis]
    return links * share[:, :, np.newaxis], counted


def _moments(
    links: Booleans, c: Floats, s: Floats, variance: Floats
) -> tuple[Floats, tuple[Floats, Floats, Floats, Floats]]:
    """Return γ less its bias, and the moments of a `_Spread`."""
    weights, counted = _weights(links)
    pairs = weights + np.swapaxes(weights, 1, 2)
    lift = np.exp(variance / 2)
    sums = pairs @ np.stack([c, s, lift * c, lift * s], axis=2)
    curvature = -lift * (c * sums[:, :, 2] + s * sums[:, :, 3])  # diagonal of H, bias taken out
    centre = np.where(counted > 0, -0.5 * curvature.sum(axis=1), np.nan)
    gradient = c * sums[:, :, 1] - s * sums[:, :, 0]
    y = variance * gradient
    bent = pairs @ np.stack([c * y, s * y], axis=2)
    bent_y = curvature * y + c * bent[:, :, 0] + s * bent[:, :, 1]
    linear = (gradient * y).sum(axis=1)
    # Of tr (HΣ)² beside the diagonal: squared cosines of differences by those of twice the angle.
    twice_c, twice_s = c**2 - s**2, 2 * c * s
    columns = np.stack([variance, variance * twice_c, variance * twice_s], axis=2)
    off = np.where(variance > 0, variance, 0.0)[:, :, np.newaxis] * np.stack(
        [np.ones_like(c), twice_c, twice_s], axis=2
    )
    square = np.square(curvature * variance).sum(axis=1) + 0.5 * (
        off * (np.square(pairs) @ columns)
    ).sum(axis=(1, 2))
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
    weights, counted = _weights(links)
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
    robots = p.shape[2]
    apart = np.sqrt(np.square(p[:, :, :, np.newaxis] - p[:, :, np.newaxis, :]).sum(axis=1))
    reach = np.broadcast_to(np.asarray(radius, dtype=float), robots)[:, np.newaxis]
    near = np.abs(apart - reach) < _DOUBTFUL_DISTANCE * np.sqrt(2.0) * noise
    near &= moving[:, np.newaxis, :] & moving[:, :, np.newaxis]
    below, above = np.zeros(len(p)), np.zeros(len(p))
    t, i, j = np.nonzero(near)
    if not t.size:
        return below, above
    c, s, variance = directions
    lift = np.exp(variance / 2)

    def cosine(a: NDArray[np.intp], b: NDArray[np.intp]) -> Floats:
        return np.asarray(lift[t, a] * lift[t, b] * (c[t, a] * c[t, b] + s[t, a] * s[t, b]))

    counted = links.any(axis=2).sum(axis=1)
    lifted = np.stack([lift * c, lift * s], axis=2)
    sums = (lifted * (links.astype(float) @ lifted)).sum(axis=2)[t, i]
    number, count = links.sum(axis=2)[t, i], counted[t]
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


def _ends(spread: _Spread) -> tuple[Floats, Floats]:
    """Return the least and the greatest γ under which the reading is not too rare."""
    broad = 8 * np.sqrt(0.5 * spread.square + spread.linear) + 16 * np.abs(spread.bending)
    centre = spread.centre
    least, inside = centre - broad, centre.copy()
    for _ in range(_HALVINGS):
        middle = (least + inside) / 2
        held = _accepted(middle, spread)[1] >= centre
        least, inside = np.where(held, least, middle), np.where(held, middle, inside)
    low = inside
    # On a summit the whole reading may lie above what is accepted there: so from below it.
    inside, most = centre - broad, centre + broad
    for _ in range(_HALVINGS):
        middle = (inside + most) / 2
        held = _accepted(middle, spread)[0] <= centre
        inside, most = np.where(held, middle, inside), np.where(held, most, middle)
    return low, inside


def _accepted(gamma: Floats, spread: _Spread) -> tuple[Floats, Floats]:
    """Return between which readings 95 % lie where the truth is `gamma`: Pearson's type III."""
    from scipy.special import ndtri

    linear = spread.linear - spread.square
    shifted = np.maximum(linear + spread.bending * (gamma - spread.centre), 0.0)
    one = spread.one_sided
    # On a saddle the linear part says nothing of γ, and where it seems none, noise hides it.
    linear = one * shifted + (1 - one) * np.maximum(linear, SADDLE * spread.square)
    half = np.maximum(0.5 * spread.square, 1e-120)
    variance = half + linear
    third = one * spread.bending * (half + 1.5 * linear)
    skewness = np.clip(third / variance**1.5, -_MOST_SKEWED, _MOST_SKEWED)
    rare = 1 - CONFIDENCE
    beyond_summit = np.maximum(rare / 2 * (1 - one * np.exp(-linear / half)), 1e-9)
    summit = spread.bending < 0
    lower = np.where(summit, rare - beyond_summit, beyond_summit)
    upper = np.where(summit, beyond_summit, rare - beyond_summit)
    deviation = np.sqrt(variance)
    return (
        gamma + deviation * _quantile(ndtri(lower), skewness),
        gamma + deviation * _quantile(-ndtri(upper), skewness),
    )


def _quantile(normal: Floats, skewness: Floats) -> Floats:
    """Return the standardised gamma's quantile by the normal's (Wilson and Hilferty 1931)."""
    k = np.where(np.abs(skewness) < 1e-6, 1e-6, skewness)
    return np.asarray(2 / k * ((1 + k * normal / 6 - k**2 / 36) ** 3 - 1))
