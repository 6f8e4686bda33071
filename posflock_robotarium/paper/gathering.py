"""Everything that the paper's figures and claims stand on, computed in several processes.

What it is stands in :mod:`posflock_robotarium.paper.evidence`; here it is run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.point_agents import Measures, measure, stack
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import displacements, neighbours, phi
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.simulation import FreeSpace, PointRun, simulate_batch
from posflock_robotarium.paper.default_seeds import SEEDS
from posflock_robotarium.paper.evidence import Evidence, Robots, Variation, variations
from posflock_robotarium.paper.robots import drive
from posflock_robotarium.simulation.workers import local_pool

Floats = NDArray[np.float64]

#: Flocks, and teams of robots, that advance together in one task of the pool.
_TOGETHER, _TEAMS_TOGETHER = 8, 25

_IMPRINTED = (Model.POSITION, Model.POSITION_NO_THRESHOLD)


def gather(
    seeds: int = SEEDS,
    *,
    first_seed: int = 0,
    paper: FreeSpace | None = None,
    driving: float = 120.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] = lambda done, all_: None,
) -> Evidence:
    """Run everything.

    Parameters
    ----------
    seeds : int
        Of everything that claims are judged by, at least 2; variations that are only drawn and
        tabled run a fifth as many, at least two.
    first_seed : int
        Seeds count up from here.
    paper : FreeSpace, optional
        What stands for the paper's simulation, whose model is set in turn to each of the
        three; a smaller one makes a quick rehearsal.
    driving : float
        Seconds for which the robots drive.
    workers : int, optional
        Processes; one for each processor by default.
    progress : function of (done, all)
        Called after each finished task.

    Returns
    -------
    Evidence
        The same for the same seeds, however many workers there are.

    Raises
    ------
    ParameterError
        Where there are fewer than two seeds.
    """
    if seeds < 2:
        raise ParameterError(f"seeds: expected at least 2, for a spread over them, got {seeds}")
    of_paper = tuple(range(first_seed, first_seed + seeds))
    with local_pool(workers) as pool:
        tasks = _submit(pool, paper or FreeSpace(), of_paper, driving)
        all_ = tasks.longest_first()
        for done, task in enumerate(as_completed(all_), start=1):
            task.result()
            progress(done, len(all_))
        return tasks.evidence(of_paper)


_OfPaper = tuple[Measures, PointRun, Floats]


@dataclass(frozen=True)
class _Tasks:
    """What is being computed, each group with the tasks that it is made of."""

    driven: list[Future[Robots]]
    driven_imperfectly: list[Future[Robots]]
    varied: list[tuple[Variation, list[Future[Measures]]]]
    """Variations whose scenarios are equal have the same tasks."""
    compared: dict[Model, list[Future[_OfPaper]]]

    def longest_first(self) -> list[Future[Any]]:
        """Return every task once: no processor idles at the end while another finishes one."""
        varied = [task for _, tasks in self.varied for task in tasks]
        compared = [task for tasks in self.compared.values() for task in tasks]
        tasks: list[Future[Any]] = [*self.driven, *self.driven_imperfectly, *varied, *compared]
        return list(dict.fromkeys(tasks))

    def evidence(self, seeds: tuple[int, ...]) -> Evidence:
        """Put the results together."""
        compared = {m: [task.result() for task in tasks] for m, tasks in self.compared.items()}
        return Evidence(
            seeds=seeds,
            measures={m: _joined([part[0] for part in parts]) for m, parts in compared.items()},
            singles={m: parts[0][1] for m, parts in compared.items()},
            imprint={m: np.concatenate([part[2] for part in compared[m]]) for m in _IMPRINTED},
            variations=tuple(
                (variation, _joined([task.result() for task in tasks]))
                for variation, tasks in self.varied
            ),
            robots=_robots([task.result() for task in self.driven]),
            imperfect_robots=_robots([task.result() for task in self.driven_imperfectly]),
        )


def _submit(
    pool: Executor, simulation: FreeSpace, of_paper: tuple[int, ...], driving: float
) -> _Tasks:
    """Have everything computed: what is judged for all seeds, the rest for a fifth of them."""
    fewer = of_paper[: max(2, len(of_paper) // 5)]
    driven, imperfectly = (
        [
            pool.submit(drive, part, imperfect=imperfect, duration=driving)
            for part in _parts(of_paper, _TEAMS_TOGETHER)
        ]
        for imperfect in (False, True)
    )
    # Many variations pass through the paper's own values: equal scenarios run once.
    all_ = [(each, str(each.scenario.as_dict())) for each in variations(simulation)]
    judged = {text for variation, text in all_ if variation.judged}
    once: dict[str, list[Future[Measures]]] = {}
    for variation, text in all_:
        if text not in once:
            seeds = of_paper if text in judged else fewer
            once[text] = [pool.submit(_run, variation.scenario, part) for part in _parts(seeds)]
    varied = [(variation, once[text]) for variation, text in all_]
    compared = {
        model: [
            pool.submit(_run_paper, replace(simulation, model=model), part)
            for part in _parts(of_paper)
        ]
        for model in Model
    }
    return _Tasks(driven, imperfectly, varied, compared)


def _parts(seeds: Sequence[int], together: int = _TOGETHER) -> list[Sequence[int]]:
    return [seeds[at : at + together] for at in range(0, len(seeds), together)]


def _joined(parts: Sequence[Measures]) -> Measures:
    return stack([part[flock] for part in parts for flock in range(len(part.gamma))])


def _run(scenario: FreeSpace, seeds: Sequence[int]) -> Measures:
    return measure(simulate_batch(scenario, seeds), scenario.law.radius)


def _run_paper(scenario: FreeSpace, seeds: Sequence[int]) -> _OfPaper:
    """Run some seeds of the paper's simulation; return one run to draw as well."""
    recording = simulate_batch(scenario, seeds)
    times = (1.0 / scenario.law.persistence, scenario.duration)
    pulls = np.array([_imprint_pull(scenario, recording, time) for time in times])
    return measure(recording, scenario.law.radius), recording[0], pulls[1] / pulls[0]


def _imprint_pull(scenario: FreeSpace, recording: PointRun, time: float) -> Floats:
    """Return how hard the imprint pulls, the mean of ‖φ_i·Σ_j p_ij(0)‖, m/s², shape (B,)."""
    law, at = scenario.law, ties.first_smallest(np.abs(recording.times - time))
    adjacency = neighbours(recording.positions[:, at], law.radius)
    threshold = scenario.model is not Model.POSITION_NO_THRESHOLD
    gain = phi(time, adjacency.sum(axis=-1), law.persistence if threshold else None)
    imprint = displacements(recording.positions[:, 0])
    pull = gain[:, None, :] * np.einsum("bij,bdij->bdi", adjacency.astype(float), imprint)
    return np.asarray(np.sqrt(np.square(pull).sum(axis=1)).mean(axis=-1))


def _robots(parts: Sequence[Robots]) -> Robots:
    return Robots(
        parts[0].times,
        np.concatenate([part.gamma_headings for part in parts]),
        np.concatenate([part.gamma_motion for part in parts]),
        tuple(summary for part in parts for summary in part.summaries),
        parts[0].single,
    )
