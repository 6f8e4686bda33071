"""The paper's comparison in numbers: its qualitative table, and every quantity over seeds."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from posflock_robotarium.alignment.point_agents import summarise
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.paper.evidence import Evidence, Floats
from posflock_robotarium.paper.measured import median_of

#: What a table over seeds shows, in order: the key of a summary, a title, a unit.
QUANTITIES: tuple[tuple[str, str, str], ...] = (
    ("gamma_settled", "mean γ, t > 20 s", ""),
    ("gamma_5s", "γ at 5 s", ""),
    ("gamma_30s", "γ at 30 s", ""),
    ("gamma_end", "γ at 100 s", ""),
    ("gamma_change", "mean γ on [80, 100] s less that on [10, 30] s", ""),
    ("alignment_time", "time to γ ≥ 0.9", "s"),
    ("nearest_neighbour_end", "nearest neighbour at 100 s", "m"),
    ("cohesive_radius_end", "cohesive radius at 100 s", "m"),
    ("cohesive_radius_ratio", "cohesive radius, largest/smallest, t > 10 s", ""),
    ("heading_spread", "spread of the centroid's heading, t > 20 s", "°"),
    ("speed_end", "mean speed at 100 s", "m/s"),
    ("distance_variance_start", "variance of pairwise distances at 0 s", "m²"),
    ("distance_variance_end", "variance of pairwise distances at 100 s", "m²"),
    ("change_variance_settled", "variance of their change, t > 20 s", "m²"),
    ("components_end", "connected groups at 100 s", ""),
)

#: What stands in a cell over seeds.
_CELLS = "median [95 % interval] (quartiles; extremes)"

#: The paper's Table 2: characteristic, its words for V-based and P-based, and what we measure:
#: the key of a summary, a title, a unit.
_QUALITATIVE: tuple[tuple[str, str, str, str, str, str], ...] = (
    (
        "Alignment strength & persistence",
        "Strong, with minor variation",
        "Very strong & persistent",
        "gamma_settled",
        "mean γ, t > 20 s",
        "",
    ),
    (
        "Formation structure",
        "Flexible, spatially adaptive",
        "Less flexible, directionally stable",
        "change_variance_settled",
        "variance of the change of pairwise distances, t > 20 s",
        " m²",
    ),
    (
        "Inter-agent separation",
        "Wider",
        "Narrower",
        "nearest_neighbour_settled",
        "nearest neighbour, t > 20 s",
        " m",
    ),
    (
        "Cohesion & directional consensus",
        "Moderate",
        "Superior",
        "heading_spread",
        "spread of the centroid's heading, t > 20 s",
        "°",
    ),
)


@dataclass(frozen=True)
class PaperTable:
    """A table of text.

    Attributes
    ----------
    title : str
        What it shows.
    header : sequence of str
        Column titles.
    rows : sequence of rows
        Cells.
    """

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]

    def markdown(self) -> str:
        """Return the table as Markdown, with its title as a heading."""
        lines = [self.header, ["---"] * len(self.header), *self.rows]
        return "\n".join(
            [f"## {self.title}", "", *("| " + " | ".join(r) + " |" for r in lines), ""]
        )

    def csv(self) -> str:
        """Return the table as CSV."""
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([self.header, *self.rows])
        return text.getvalue()


def over_seeds(evidence: Evidence) -> PaperTable:
    """Return median, interval, quartiles and extremes over seeds of every quantity and model.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    rows = []
    for key, title, unit in QUANTITIES:
        if any(key not in evidence.numbers(model) for model in Model):
            continue  # runs that end before it
        cells = [_spread(evidence.numbers(model)[key]) for model in Model]
        rows.append([title + (f" ({unit})" if unit else ""), *cells])
    return PaperTable(
        f"The paper's simulation over {len(evidence.seeds)} seeds: {_CELLS}",
        ["quantity", *(model.label for model in Model)],
        rows,
    )


def qualitative(evidence: Evidence) -> PaperTable:
    """Return the paper's Table 2 with what was measured behind each word.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    rows = []
    for characteristic, velocity, position, key, title, unit in _QUALITATIVE:
        v, p = (median_of(evidence.numbers(m)[key]).text for m in (Model.VELOCITY, Model.POSITION))
        rows.append([characteristic, f"{velocity} ({v}{unit})", f"{position} ({p}{unit})", title])
    return PaperTable(
        "The paper's qualitative comparison, with measured medians [95 % interval]",
        ["characteristic", Model.VELOCITY.label, Model.POSITION.label, "measured"],
        rows,
    )


def varied(evidence: Evidence) -> PaperTable:
    """Return what every variation of a parameter or of sensing does, one row each.

    Parameters
    ----------
    evidence : Evidence
        Every run of the reproduction.
    """
    keys = ("gamma_settled", "gamma_end", "alignment_time", "nearest_neighbour_settled")
    titles = ["mean γ, t > 20 s", "γ at 100 s", "time to γ ≥ 0.9 (s)"]
    titles += ["nearest neighbour, t > 20 s (m)"]
    rows = []
    for variation, measures in evidence.variations:
        numbers = summarise(measures)
        study = variation.study
        name = study.title + (f" ({study.unit})" if study.unit else "")
        cells = [_spread(numbers[key]) for key in keys]
        runs = str(len(measures.gamma))
        rows.append([name, f"{variation.value:g}", variation.scenario.model.label, runs, *cells])
    return PaperTable(
        f"Beyond the paper: {_CELLS}",
        ["varied", "value", "model", "seeds", *titles],
        rows,
    )


def _spread(values: Floats) -> str:
    # "nearest" never interpolates: runs that never aligned (infinite) stay what they are.
    low, q1, q3, high = np.percentile(values, [0, 25, 75, 100], method="nearest")
    return f"{median_of(values).text} ({q1:.3g} to {q3:.3g}; {low:.3g} to {high:.3g})"
