"""Every run that the reproduction draws or judges.

Three groups.  The *paper's simulation*: three models from identical starts, over seeds.
*Variations*: one parameter or one imperfection at a time, which the paper argues about and
does not measure.  *Robots*: nine of them on wheels in the arena, ideal and imperfect.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.point_agents import Measures, summarise
from posflock_robotarium.alignment.summary import Summary
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.sensing import Sensing
from posflock_robotarium.freespace.simulation import FreeSpace, PointRun
from posflock_robotarium.logs.run import Run

Floats = NDArray[np.float64]

#: Side of the cube in which 50 agents have as many neighbours as in the paper's square, m.
CUBE_SIDE = 18.5

#: An agent without a velocity sensor takes the difference of positions so far apart, s.
DIFFERENCE_INTERVAL = 0.2

#: Values of δ that are compared, m.
DISTANCE_SCALES = (0.3, 0.4, 0.5, 0.6, 0.8)

#: Position noise under which P-based is compared with V-based that differentiates, m.
JUDGED_NOISE = (0.02, 0.05, 0.1)

_POSITION_NOISE = (0.0, 0.01, *JUDGED_NOISE, 0.2, 0.5)


class Varied(Enum):
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


#: The values of each study, by model, that claims are judged by: these run over all seeds, the
#: rest, which are drawn and tabled, over a fifth of them.
_JUDGED: dict[tuple[Varied, Model], tuple[float, ...]] = {
    (Varied.DISTANCE_SCALE, Model.VELOCITY): DISTANCE_SCALES,
    (Varied.DISTANCE_SCALE, Model.POSITION): DISTANCE_SCALES,
    (Varied.THREE_DIMENSIONS, Model.POSITION): (3.0,),
    (Varied.LARGER_TEAMS, Model.POSITION): (2.0,),
    (Varied.POSITION_NOISE, Model.POSITION): JUDGED_NOISE,
    (Varied.DIFFERENTIATED_NOISE, Model.VELOCITY): JUDGED_NOISE,
    (Varied.DROPOUT, Model.POSITION): (0.1,),
    (Varied.VANISHING, Model.POSITION): (0.1,),
    (Varied.STOPPING, Model.POSITION): (0.02,),
}


@dataclass(frozen=True)
class Variation:
    """One parameter changed.

    Attributes
    ----------
    study : Varied
        What is varied.
    value : float
        What it is set to, in the unit of the study.
    scenario : FreeSpace
        The simulation that follows.
    """

    study: Varied
    value: float
    scenario: FreeSpace

    @property
    def judged(self) -> bool:
        """Whether a claim is judged by it."""
        return self.value in _JUDGED.get((self.study, self.scenario.model), ())


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
        Over which claims are judged.
    measures : dict of Model to Measures
        (B, T) over seeds.
    singles : dict of Model to PointRun
        The first seed's run, for trajectories.
    imprint : dict of Model to (B,) array
        Of the position-based models: how hard the imprint pulls at the end, as a share
        of its pull at t = 1/k.
    variations : tuple of (Variation, Measures)
        In the order of :func:`variations`; those by which no claim is judged over fewer seeds.
    robots, imperfect_robots : Robots
        Nine robots, in the ideal arena and with actuation and tracking noise, over all seeds.
    """

    seeds: tuple[int, ...]
    measures: dict[Model, Measures]
    singles: dict[Model, PointRun]
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
        return self._numbers[model]

    @cached_property
    def _numbers(self) -> dict[Model, dict[str, Floats]]:
        """Computed once: most claims and every row of a table ask for one of them."""
        return {model: summarise(measures) for model, measures in self.measures.items()}

    def study(self, study: Varied, model: Model) -> tuple[Floats, list[dict[str, Floats]]]:
        """Return the values of a variation, and the summary numbers at each.

        Parameters
        ----------
        study : Varied
            What is varied.
        model : Model
            Of the paper's three: which one.

        Returns
        -------
        values : (V,) array
            What was varied, in the study's unit.
        numbers : list of dict of (B,) arrays
            The numbers at each value, over the seeds that it was run with.
        """
        chosen = [
            (variation.value, summarise(measures))
            for variation, measures in self.variations
            if variation.study is study and variation.scenario.model is model
        ]
        return np.array([value for value, _ in chosen]), [numbers for _, numbers in chosen]

    def at(self, study: Varied, model: Model, value: float) -> dict[str, Floats]:
        """Return the summary numbers of one variation at one value.

        Parameters
        ----------
        study : Varied
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
            yield Variation(Varied.TIME_STEP, value, replace(base, model=model, time_step=value))
    for value in DISTANCE_SCALES:
        for model in both:
            law = replace(base.law, distance_scale=value)
            yield Variation(Varied.DISTANCE_SCALE, value, replace(base, model=model, law=law))
    for value in (0.02, 0.05, 0.1, 0.2, 0.5, 1.0):
        law = replace(base.law, persistence=value)
        yield Variation(Varied.PERSISTENCE, value, replace(base, law=law))
    for model in Model:
        cube = replace(base, model=model, dimensions=3, side=CUBE_SIDE)
        yield Variation(Varied.THREE_DIMENSIONS, 3.0, cube)
    for model in both:
        larger = replace(base, model=model, agents=2 * base.agents, side=base.side * 2.0**0.5)
        yield Variation(Varied.LARGER_TEAMS, 2.0, larger)
        for value in _POSITION_NOISE:
            blurred = replace(base, model=model, sensing=Sensing(position_noise=value))
            yield Variation(Varied.POSITION_NOISE, value, blurred)
        for value in (0.0, 0.02, 0.05, 0.1, 0.2):
            lossy = replace(base, model=model, sensing=Sensing(dropout=value))
            yield Variation(Varied.DROPOUT, value, lossy)
        for value in (0.0, 0.05, 0.1, 0.2):
            late = replace(base, model=model, sensing=Sensing(delay=value))
            yield Variation(Varied.DELAY, value, late)
        for value in (0.0, 0.02, 0.1, 0.2, 0.4):
            stuck = Sensing(failing=value, failure="stop")
            gone = replace(stuck, failure="vanish") if value else stuck
            yield Variation(Varied.VANISHING, value, replace(base, model=model, sensing=gone))
            yield Variation(Varied.STOPPING, value, replace(base, model=model, sensing=stuck))
    for value in _POSITION_NOISE:
        # The error of a difference of two positions, over the time between them.
        velocity_noise = 2.0**0.5 * value / DIFFERENCE_INTERVAL
        noisy = Sensing(position_noise=value, velocity_noise=velocity_noise)
        scenario = replace(base, model=Model.VELOCITY, sensing=noisy)
        yield Variation(Varied.DIFFERENTIATED_NOISE, value, scenario)
