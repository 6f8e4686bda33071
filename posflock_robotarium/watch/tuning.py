"""What may be changed of a flock while it flies, and within which range."""

from __future__ import annotations

from dataclasses import dataclass

from posflock_robotarium.flocking.paper_models import Model


@dataclass(frozen=True)
class Span:
    """The range of one parameter of the law.

    Attributes
    ----------
    symbol, label : str
        As the paper writes it, and in words.
    unit : str
        Of its values.
    least, most, step : float
        Ends of the range, and by how much a slider moves.
    """

    symbol: str
    label: str
    unit: str
    least: float
    most: float
    step: float


#: By the names of `posflock_robotarium.flocking.law.LawParameters`. The radius stays above the
#: hysteresis of the neighbours, 0.15 m.
RANGES: dict[str, Span] = {
    "distance_scale": Span("δ", "distance scale", "m", 0.0, 0.30, 0.005),
    "persistence": Span("k", "persistence", "1/s", 0.01, 1.0, 0.01),
    "radius": Span("r", "neighbour radius", "m", 0.20, 2.0, 0.05),
}

#: The paper's models, in words for people.
MODELS: dict[Model, str] = {
    Model.VELOCITY: "velocity-based",
    Model.POSITION: "position-based",
    Model.POSITION_NO_THRESHOLD: "position-based, no threshold",
}
