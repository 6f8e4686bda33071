"""The number behind each of the paper's claims, measured in the evidence.

A measurement is a function of :class:`~posflock_robotarium.paper.evidence.Evidence`; those that
serve several claims are made for one model and one number.  Seeds are its unit: each gives one
number, or a yes or no, and what is told is the median or the share of them, with its interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.flocking.law import (
    PAPER_SIMULATION,
    displacements,
    position_based_input,
    velocity_based_input,
)
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.simulation import FreeSpace, euler_step, simulate
from posflock_robotarium.paper.evidence import DISTANCE_SCALES, JUDGED_NOISE, Evidence, Varied
from posflock_robotarium.paper.measured import Measured, exact, median_of, share_of

Floats = NDArray[np.float64]
Measurement = Callable[[Evidence], Measured]

#: Seconds after which the transient of the imprinted law is measured.
TRANSIENT = 10.0

V, P, N = Model.VELOCITY, Model.POSITION, Model.POSITION_NO_THRESHOLD


def median(model: Model, name: str) -> Measurement:
    """Return what measures the median of a number over seeds.

    Parameters
    ----------
    model : Model
        Of the paper's three: which one.
    name : str
        Key of the number in :func:`summarise`'s table.
    """
    return lambda evidence: median_of(evidence.numbers(model)[name])


def share(model: Model, name: str, low: float, high: float) -> Measurement:
    """Return what measures the share of seeds whose number lies in a range.

    Parameters
    ----------
    model : Model
        Of the paper's three: which one.
    name : str
        Key of the number in :func:`summarise`'s table.
    low, high : float
        The range, bounds included, in the number's unit.
    """

    def within(evidence: Evidence) -> Measured:
        values = evidence.numbers(model)[name]
        return share_of((values >= low) & (values <= high))

    return within


def pairs_less(name: str, less: Model, more: Model) -> Measurement:
    """Return what measures the share of seeds at which one model's number is less than the other's.

    Parameters
    ----------
    name : str
        Key of the number in :func:`summarise`'s table.
    less : Model
        Whose number should be less.
    more : Model
        Whose should be more.
    """
    return lambda evidence: share_of(evidence.numbers(less)[name] < evidence.numbers(more)[name])


def median_gain(evidence: Evidence) -> Measured:
    """Measure the median over seeds of the settled γ, P-based less V-based.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    name = "gamma_settled"
    return median_of(evidence.numbers(P)[name] - evidence.numbers(V)[name])


def distance_fluctuation(evidence: Evidence) -> Measured:
    """Measure the median relative deviation of the nearest-neighbour distance, t > 20 s.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[P]
    distance = measures.nearest_neighbour[:, ties.reached(measures.times, 20.0)]
    return median_of(distance.std(axis=-1) / distance.mean(axis=-1))


def peak_time(evidence: Evidence) -> Measured:
    """Measure how far from 30 s the V-based γ is largest, s, median over seeds.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[V]
    peak = measures.times[np.nanargmax(measures.gamma, axis=-1)]
    return median_of(np.abs(peak - 30.0))


def equal_at_first(evidence: Evidence) -> Measured:
    """Measure the share of seeds at which both P-based models have one γ until t = 1/k.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    early = ties.within(evidence.measures[P].times, 1.0 / PAPER_SIMULATION.persistence)
    with_, without = (evidence.measures[model].gamma[:, early] for model in (P, N))
    return share_of(ties.within(np.abs(with_ - without), 0.0).all(axis=-1))


def imprint_left(evidence: Evidence) -> Measured:
    """Measure the median share of the imprint's pull that is left at the end, P-based (thr.).

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    return median_of(evidence.imprint[P])


def transient_variance_change(evidence: Evidence) -> Measured:
    """Measure the median growth of the variance of neighbour distances until 10 s, m².

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[P]
    variance, late = measures.distance_variance, _at(measures.times, TRANSIENT)
    return median_of(variance[:, late] - variance[:, 0])


def transient_change_variance(evidence: Evidence) -> Measured:
    """Measure the median variance of the change of neighbour distances at 10 s, m².

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[P]
    return median_of(measures.change_variance[:, _at(measures.times, TRANSIENT)])


def _at(times: Floats, time: float) -> int:
    """Return the place of the time nearest to one, s."""
    return ties.first_smallest(np.abs(times - time))


def denser_with_smaller_scale(evidence: Evidence) -> Measured:
    """Measure the share of seeds whose nearest-neighbour distance grows at each step of δ, P and V.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    distances = [
        [
            evidence.at(Varied.DISTANCE_SCALE, model, value)["nearest_neighbour_settled"]
            for value in DISTANCE_SCALES
        ]
        for model in (V, P)
    ]
    grows = np.diff(distances, axis=1) > 0.0
    return share_of(np.asarray(grows.all(axis=(0, 1))))


def pair_at_rest(_: Evidence) -> Measured:
    """Measure how far from δ·|N| = δ two V-based agents come to rest, m.

    Parameters
    ----------
    _ : Evidence
        Not used: two agents are simulated here.
    """
    scenario = FreeSpace(model=V, agents=2, side=1.0, fastest_start=0.1, duration=60.0)
    last = simulate(scenario, seed=0).positions[-1]
    delta = float(np.max(scenario.law.distance_scale))
    return exact(abs(np.sqrt(np.square(last[:, 1] - last[:, 0]).sum()) - delta))


def head_on_passes(_: Evidence) -> Measured:
    """Measure the share of head-on meetings of two agents that end in passing through each other.

    Parameters
    ----------
    _ : Evidence
        Not used: the meetings are simulated here.
    """
    meetings = product((V, P), (0.5, 1.0, 2.0), (0.1, 0.25, 0.5, 1.0), (0.5, 1.0, 1.5, 2.0, 2.5))
    return exact(float(np.mean([_passes_through(*meeting) for meeting in meetings])))


def _passes_through(model: Model, distance: float, delta: float, speed: float) -> bool:
    """Let two agents at some distance drive at each other; tell whether they change sides."""
    law = replace(PAPER_SIMULATION, distance_scale=delta)
    positions = np.array([[0.0, distance], [0.0, 0.0]])
    velocities = np.array([[speed, -speed], [0.0, 0.0]])
    imprint, time_step = displacements(positions), 0.05
    for step in range(1, 101):
        inputs = (
            velocity_based_input(positions, velocities, law)
            if model is V
            else position_based_input(positions, imprint, step * time_step, law)
        )
        positions, velocities = euler_step(positions, velocities, inputs, time_step, law)
        if ties.reached(positions[0, 0], positions[0, 1]):
            return True
    return False


def settled_at(study: Varied, model: Model, value: float) -> Measurement:
    """Return what measures the median settled γ at one value of a study.

    Parameters
    ----------
    study : Varied
        What is varied.
    model : Model
        Of the paper's three: which one.
    value : float
        One of the study's values, in its unit.
    """
    return lambda evidence: median_of(evidence.at(study, model, value)["gamma_settled"])


def noise_advantage(evidence: Evidence) -> Measured:
    """Measure the median of the least advantage in γ of P over V that differentiates.

    Both see equally noisy positions, and the least is that of three levels of noise, at one seed.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    name = "gamma_settled"
    advantages = [
        evidence.at(Varied.POSITION_NOISE, P, noise)[name]
        - evidence.at(Varied.DIFFERENTIATED_NOISE, V, noise)[name]
        for noise in JUDGED_NOISE
    ]
    return median_of(np.min(advantages, axis=0))


def robots_median(name: str) -> Measurement:
    """Return what measures the median of a number over the nine-robot seeds.

    Parameters
    ----------
    name : str
        Attribute of `Summary`.
    """
    return lambda evidence: median_of(evidence.robots.of(name))


def robots_consistent(evidence: Evidence) -> Measured:
    """Measure the share of seeds whose nine noisy robots keep a mean γ from motion of 0.85.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    return share_of(ties.reached(evidence.imperfect_robots.of("gamma_motion"), 0.85))


def robots_safe(evidence: Evidence) -> Measured:
    """Measure the share of seeds without a collision or a step outside, ideal and noisy.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    faults = [
        robots.of(name)
        for robots in (evidence.robots, evidence.imperfect_robots)
        for name in ("collisions", "steps_outside")
    ]
    return share_of(np.sum(faults, axis=0) == 0.0)
