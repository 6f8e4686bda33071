"""The number behind each of the paper's claims, measured in the evidence.

A measurement is a function of :class:`~posflock_robotarium.paper.evidence.Evidence`; those that
serve several claims are made for one model and one number.
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
from posflock_robotarium.paper.evidence import Evidence, Varied

Floats = NDArray[np.float64]

#: Seconds after which the transient of the imprinted law is measured.
TRANSIENT = 10.0

V, P, N = Model.VELOCITY, Model.POSITION, Model.POSITION_NO_THRESHOLD


def median(model: Model, name: str) -> Callable[[Evidence], float]:
    """Return what measures the median of a number over seeds.

    Parameters
    ----------
    model : Model
        Of the paper's three: which one.
    name : str
        Key of the number in :func:`summarise`'s table.
    """
    return lambda evidence: float(np.median(evidence.numbers(model)[name]))


def share(model: Model, name: str, low: float, high: float) -> Callable[[Evidence], float]:
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

    def within(evidence: Evidence) -> float:
        values = evidence.numbers(model)[name]
        return float(np.mean((values >= low) & (values <= high)))

    return within


def pairs_less(name: str, less: Model, more: Model) -> Callable[[Evidence], float]:
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
    return lambda evidence: float(
        np.mean(evidence.numbers(less)[name] < evidence.numbers(more)[name])
    )


def median_gain(evidence: Evidence) -> float:
    """Measure the median over seeds of the settled γ, P-based less V-based.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    name = "gamma_settled"
    return float(np.median(evidence.numbers(P)[name] - evidence.numbers(V)[name]))


def distance_fluctuation(evidence: Evidence) -> float:
    """Measure the median relative deviation of the nearest-neighbour distance, t > 20 s.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[P]
    distance = measures.nearest_neighbour[:, ties.reached(measures.times, 20.0)]
    return float(np.median(distance.std(axis=-1) / distance.mean(axis=-1)))


def peak_time(evidence: Evidence) -> float:
    """Measure how far from 30 s the V-based γ is largest, s, median over seeds.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[V]
    peak = measures.times[np.nanargmax(measures.gamma, axis=-1)]
    return float(np.median(np.abs(peak - 30.0)))


def early_difference(evidence: Evidence) -> float:
    """Measure the largest difference of γ between the two P-based models until t = 1/k.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    early = ties.within(evidence.measures[P].times, 1.0 / PAPER_SIMULATION.persistence)
    with_, without = (evidence.measures[model].gamma[:, early] for model in (P, N))
    return float(np.max(np.abs(with_ - without)))


def transient_variance_change(evidence: Evidence) -> float:
    """Measure the median growth of the variance of neighbour distances until 10 s, m².

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[P]
    variance, late = measures.distance_variance, _at(measures.times, TRANSIENT)
    return float(np.median(variance[:, late] - variance[:, 0]))


def transient_change_variance(evidence: Evidence) -> float:
    """Measure the median variance of the change of neighbour distances at 10 s, m².

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    measures = evidence.measures[P]
    return float(np.median(measures.change_variance[:, _at(measures.times, TRANSIENT)]))


def _at(times: Floats, time: float) -> int:
    """Return the place of the time nearest to one, s."""
    return ties.first_smallest(np.abs(times - time))


def denser_with_smaller_scale(evidence: Evidence) -> float:
    """Measure the share of steps of δ at which the nearest-neighbour distance grows, P and V.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    grows: list[bool] = []
    for model in (V, P):
        _, numbers = evidence.study(Varied.DISTANCE_SCALE, model)
        distance = [np.median(each["nearest_neighbour_settled"]) for each in numbers]
        grows.extend(np.diff(distance) > 0.0)
    return float(np.mean(grows))


def pair_at_rest(_: Evidence) -> float:
    """Measure how far from δ·|N| = δ two V-based agents come to rest, m.

    Parameters
    ----------
    _ : Evidence
        Not used: two agents are simulated here.
    """
    scenario = FreeSpace(model=V, agents=2, side=1.0, fastest_start=0.1, duration=60.0)
    last = simulate(scenario, seed=0).positions[-1]
    delta = float(np.max(scenario.law.distance_scale))
    return float(abs(np.sqrt(np.square(last[:, 1] - last[:, 0]).sum()) - delta))


def head_on_passes(_: Evidence) -> float:
    """Measure the share of head-on meetings of two agents that end in passing through each other.

    Parameters
    ----------
    _ : Evidence
        Not used: the meetings are simulated here.
    """
    meetings = product((V, P), (0.5, 1.0, 2.0), (0.1, 0.25, 0.5, 1.0), (0.5, 1.0, 1.5, 2.0, 2.5))
    return float(np.mean([_passes_through(*meeting) for meeting in meetings]))


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


def settled_at(study: Varied, model: Model, value: float) -> Callable[[Evidence], float]:
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
    return lambda evidence: float(np.median(evidence.at(study, model, value)["gamma_settled"]))


def noise_advantage(evidence: Evidence) -> float:
    """Measure the least advantage in γ of P over V that differentiates the same noisy positions.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    return float(
        min(
            np.median(evidence.at(Varied.POSITION_NOISE, P, noise)["gamma_settled"])
            - np.median(evidence.at(Varied.DIFFERENTIATED_NOISE, V, noise)["gamma_settled"])
            for noise in (0.02, 0.05, 0.1)
        )
    )


def robots_median(name: str) -> Callable[[Evidence], float]:
    """Return what measures the median of a number over the nine-robot seeds.

    Parameters
    ----------
    name : str
        Attribute of `Summary`.
    """
    return lambda evidence: float(np.median(evidence.robots.of(name)))
