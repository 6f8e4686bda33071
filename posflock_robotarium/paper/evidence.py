"""Every run that the reproduction draws or judges.

Three groups.  The *paper's simulation*: three models from identical starts, over seeds.
*Variations*: one parameter or one imperfection at a time, which the paper argues about and
does not measure.  *Robots*: nine of them on wheels in the arena, ideal and imperfect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.point_agents import Measures, measure, stack, summarise
from posflock_robotarium.alignment.summary import Summary
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.law import displacements, neighbours, phi
from posflock_robotarium.freespace.sensing import Sensing
from posflock_robotarium.freespace.simulation import FreeSpace, Model, Recording, simulate_batch
from posflock_robotarium.logs.run import Run
from posflock_robotarium.paper.robots import Drive, drive
from posflock_robotarium.simulation.workers import local_pool

Floats = NDArray[np.float64]

#: Flocks that advance together in one task of the pool.
_TOGETHER = 8

#: Side of the cube in which 50 agents have as many neighbours as in the paper's square, m.
CUBE_SIDE = 18.5

#: An agent without a velocity sensor takes the difference of positions so far apart, s.
DIFFERENCE_INTERVAL = 0.2

_IMPRINTED = (Model.POSITION, Model.POSITION_NO_THRESHOLD)
_POSITION_NOISE = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)


class Study(Enum):
    """What is varied.

    Parameters
    ----------
    title : str
        What tables and figures call it.
    unit : str
        Of the values that it takes; empty where they have none.
    """

    TIME_STEP = "time step", "s"
    DISTANCE_SCALE = "distance scale δ", "m"
    PERSISTENCE = "persistence k", "1/s"
    THREE_DIMENSIONS = "three dimensions", ""
    LARGER_TEAMS = "times as many agents", ""
    POSITION_NOISE = "position noise", "m"
    DROPOUT = "dropout", ""
    DELAY = "delay", "s"
    VANISHING = "vanishing agents", ""
    STOPPING = "stopping agents", ""
    DIFFERENTIATED_NOISE = "differentiated noise", "m"

    def __init__(self, title: str, unit: str) -> None:
        self.title = title
        self.unit = unit


@dataclass(frozen=True)
class Variation:
    """One parameter changed.

    Attributes
    ----------
    study : Study
        What is varied.
    value : float
        What it is set to, in the unit of the study.
    scenario : FreeSpace
        The simulation that follows.
    """

    study: Study
    value: float
    scenario: FreeSpace


@dataclass(frozen=True, eq=False)
class Robots:
    """Nine robots in the arena over seeds.

    Attributes
    ----------
    times : (T,) array
        Seconds.
    gamma_headings, gamma_motion : (B, T) array
        γ from where robots point, and from where they go.
    summaries : tuple of B Summary
        The numbers of each run.
    single : Run
        The first run, for snapshots.
    """

    times: Floats
    gamma_headings: Floats
    gamma_motion: Floats
    summaries: tuple[Summary, ...]
    single: Run

    def of(self, name: str) -> Floats:
        """Return one number of every summary.

        Parameters
        ----------
        name : str
            Attribute of `Summary`.

        Returns
        -------
        (B,) array
            The number, over seeds.
        """
        return np.array([getattr(summary, name) for summary in self.summaries], dtype=float)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What was computed.

    Attributes
    ----------
    seeds : tuple of int
        Of the paper's simulation.
    measures : dict of Model to Measures
        (B, T) over seeds.
    singles : dict of Model to Recording
        The first seed's run, for trajectories.
    imprint : dict of Model to (B,) array
        Of the position-based models: how hard the imprint pulls at the end, as a share
        of its pull at t = 1/k.
    variations : tuple of (Variation, Measures)
        In the order of :func:`variations`; fewer seeds.
    robots, imperfect_robots : Robots
        Nine robots, in the ideal arena and with actuation and tracking noise.
    """

    seeds: tuple[int, ...]
    measures: dict[Model, Measures]
    singles: dict[Model, Recording]
    imprint: dict[Model, Floats]
    variations: tuple[tuple[Variation, Measures], ...]
    robots: Robots
    imperfect_robots: Robots

    def numbers(self, model: Model) -> dict[str, Floats]:
        """Return the summary numbers of the paper's simulation over seeds.

        Parameters
        ----------
        model : Model
            Of the paper's three: which one.

        Returns
        -------
        dict of (B,) arrays
            By the key of the number, as in `summarise`; over seeds.
        """
        return summarise(self.measures[model])

    def study(self, study: Study, model: Model) -> tuple[Floats, list[dict[str, Floats]]]:
        """Return the values of a variation, and the summary numbers at each.

        Parameters
        ----------
        study : Study
            What is varied.
        model : Model
            Of the paper's three: which one.

        Returns
        -------
        values : (V,) array
            What was varied, in the study's unit.
        numbers : list of dict of (B,) arrays
            The numbers at each value, over seeds.
        """
        chosen = [
            (variation.value, summarise(measures))
            for variation, measures in self.variations
            if variation.study is study and variation.scenario.model is model
        ]
        return np.array([value for value, _ in chosen]), [numbers for _, numbers in chosen]

    def at(self, study: Study, model: Model, value: float) -> dict[str, Floats]:
        """Return the summary numbers of one variation at one value.

        Parameters
        ----------
        study : Study
            What is varied.
        model : Model
            Of the paper's three: which one.
        value : float
            One of the study's values, in its unit.

        Returns
        -------
        dict of (B,) arrays
            By the key of the number; over seeds.
        """
        values, numbers = self.study(study, model)
        return numbers[int(np.flatnonzero(values == value)[0])]


def variations(paper: FreeSpace) -> Iterator[Variation]:
    """Yield every variation of the paper's simulation.

    Parameters
    ----------
    paper : FreeSpace
        The simulation that is varied.
    """
    base = replace(paper, record_interval=1.0)
    both = (Model.VELOCITY, Model.POSITION)
    for value in (0.0125, 0.025, 0.05, 0.1, 0.2):
        for model in Model:
            yield Variation(Study.TIME_STEP, value, replace(base, model=model, time_step=value))
    for value in (0.3, 0.4, 0.5, 0.6, 0.8):
        for model in both:
            law = replace(base.law, distance_scale=value)
            yield Variation(Study.DISTANCE_SCALE, value, replace(base, model=model, law=law))
    for value in (0.02, 0.05, 0.1, 0.2, 0.5, 1.0):
        law = replace(base.law, persistence=value)
        yield Variation(Study.PERSISTENCE, value, replace(base, law=law))
    for model in Model:
        cube = replace(base, model=model, dimensions=3, side=CUBE_SIDE)
        yield Variation(Study.THREE_DIMENSIONS, 3.0, cube)
    for model in both:
        larger = replace(base, model=model, agents=2 * base.agents, side=base.side * 2.0**0.5)
        yield Variation(Study.LARGER_TEAMS, 2.0, larger)
        for value in _POSITION_NOISE:
            blurred = replace(base, model=model, sensing=Sensing(position_noise=value))
            yield Variation(Study.POSITION_NOISE, value, blurred)
        for value in (0.0, 0.02, 0.05, 0.1, 0.2):
            lossy = replace(base, model=model, sensing=Sensing(dropout=value))
            yield Variation(Study.DROPOUT, value, lossy)
        for value in (0.0, 0.05, 0.1, 0.2):
            late = replace(base, model=model, sensing=Sensing(delay=value))
            yield Variation(Study.DELAY, value, late)
        for value in (0.0, 0.02, 0.1, 0.2, 0.4):
            stuck = Sensing(failing=value, failure="stop")
            gone = replace(stuck, failure="vanish") if value else stuck
            yield Variation(Study.VANISHING, value, replace(base, model=model, sensing=gone))
            yield Variation(Study.STOPPING, value, replace(base, model=model, sensing=stuck))
    for value in _POSITION_NOISE:
        # The error of a difference of two positions, over the time between them.
        velocity_noise = 2.0**0.5 * value / DIFFERENCE_INTERVAL
        noisy = Sensing(position_noise=value, velocity_noise=velocity_noise)
        scenario = replace(base, model=Model.VELOCITY, sensing=noisy)
        yield Variation(Study.DIFFERENTIATED_NOISE, value, scenario)


def gather(
    seeds: int = 20,
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
        Seeds of the paper's simulation, at least 2; the robots and the variations run half as
        many, at least two.
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


_OfPaper = tuple[Measures, Recording, Floats]


@dataclass(frozen=True)
class _Tasks:
    """What is being computed, each group with the tasks that it is made of."""

    driven: list[Future[Drive]]
    driven_imperfectly: list[Future[Drive]]
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
    """Have everything computed: the paper's simulation for all seeds, the rest for half of them."""
    fewer = of_paper[: max(2, len(of_paper) // 2)]
    driven, imperfectly = (
        [pool.submit(drive, seed, imperfect=imperfect, duration=driving) for seed in fewer]
        for imperfect in (False, True)
    )
    # Many variations pass through the paper's own values: equal scenarios run once.
    once: dict[str, list[Future[Measures]]] = {}
    varied = []
    for variation in variations(simulation):
        text = str(variation.scenario.as_dict())
        if text not in once:
            once[text] = [pool.submit(_run, variation.scenario, part) for part in _parts(fewer)]
        varied.append((variation, once[text]))
    compared = {
        model: [
            pool.submit(_run_paper, replace(simulation, model=model), part)
            for part in _parts(of_paper)
        ]
        for model in Model
    }
    return _Tasks(driven, imperfectly, varied, compared)


def _parts(seeds: Sequence[int]) -> list[Sequence[int]]:
    return [seeds[at : at + _TOGETHER] for at in range(0, len(seeds), _TOGETHER)]


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


def _imprint_pull(scenario: FreeSpace, recording: Recording, time: float) -> Floats:
    """Return how hard the imprint pulls, the mean of ‖φ_i·Σ_j p_ij(0)‖, m/s², shape (B,)."""
    law, at = scenario.law, ties.first_smallest(np.abs(recording.times - time))
    adjacency = neighbours(recording.positions[:, at], law.radius)
    threshold = scenario.model is not Model.POSITION_NO_THRESHOLD
    gain = phi(time, adjacency.sum(axis=-1), law.persistence if threshold else None)
    imprint = displacements(recording.positions[:, 0])
    pull = gain[:, None, :] * np.einsum("bij,bdij->bdi", adjacency.astype(float), imprint)
    return np.asarray(np.sqrt(np.square(pull).sum(axis=1)).mean(axis=-1))


def _robots(runs: Sequence[Drive]) -> Robots:
    first = runs[0].log
    return Robots(
        first.t,
        np.stack([run.gamma_headings for run in runs]),
        np.stack([run.gamma_motion for run in runs]),
        tuple(run.summary for run in runs),
        first,
    )
