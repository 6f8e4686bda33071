"""Several runs side by side: each run's numbers, their mean and how far that can be trusted.

The interval is a percentile bootstrap over runs (:mod:`posflock_robotarium.alignment.intervals`).
With fewer than three runs there is none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.alignment.analysis import Analysis
from posflock_robotarium.alignment.intervals import MEAN_RESAMPLES, mean_interval
from posflock_robotarium.alignment.reference_errors import ReferenceErrors, errors_against
from posflock_robotarium.alignment.verdicts import headline
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Spread:
    """Mean over runs, with a 95 % interval.

    Attributes
    ----------
    runs : int
        Runs in which the number is defined.
    mean, low, high : float
        Mean and interval; NaN where undefined.
    smallest, largest : float
        Of the runs.
    """

    runs: int
    mean: float
    low: float
    high: float
    smallest: float
    largest: float


@dataclass(frozen=True)
class Row:
    """One number in every run.

    Attributes
    ----------
    key : str
        Of the number.
    label : str
        Words for people.
    unit : str
        Empty for pure numbers.
    group : str
        Table of the summary that it belongs to.
    values : tuple of float
        Of each run; NaN where undefined.
    by_label : mapping of str to Spread
        Mean of the runs of each label.
    overall : Spread
        Mean of all runs.
    """

    key: str
    label: str
    unit: str
    group: str
    values: tuple[float, ...]
    by_label: Mapping[str, Spread]
    overall: Spread


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs side by side.

    Attributes
    ----------
    analyses : tuple of Analysis
        One a run, in the order given.
    labels : tuple of str
        What each run counts as (``simulation``, ``testbed``, or one name for all).
    rows : tuple of Row
        One a number.
    outcomes : dict of int
        How many runs came out how (``aligned, together, safe``).
    errors : tuple of ReferenceErrors
        Of every other run against the first, where that is a reference.
    """

    analyses: tuple[Analysis, ...]
    labels: tuple[str, ...]
    rows: tuple[Row, ...]
    outcomes: Mapping[str, int]
    errors: tuple[ReferenceErrors, ...] = ()

    @property
    def groups(self) -> tuple[str, ...]:
        """The different labels, in order of appearance."""
        return tuple(dict.fromkeys(self.labels))

    def summary(self) -> dict[str, Any]:
        """Return labels, outcomes and every row, ready for JSON (NaN becomes null)."""
        return {
            "runs": [analysis.name for analysis in self.analyses],
            "labels": list(self.labels),
            "outcomes": dict(self.outcomes),
            "interval": f"95 % percentile bootstrap over runs, {MEAN_RESAMPLES} resamples",
            "numbers": {row.key: _without_nan(asdict(row)) for row in self.rows},
            "errors_against_reference": [_without_nan(asdict(errors)) for errors in self.errors],
        }


def compare(
    analyses: Sequence[Analysis], labels: Sequence[str] | None = None, *, seed: int = 0
) -> Comparison:
    """Compare runs.

    Parameters
    ----------
    analyses : sequence of Analysis
        At least two.
    labels : sequence of str, optional
        What each run counts as; by default what its log says (simulation or testbed).
    seed : int
        Of the bootstrap: the same seed gives the same interval.

    Returns
    -------
    Comparison
        Every number in every run, by label and overall.

    Raises
    ------
    ParameterError
        When there are fewer than two runs, or not a label for each.
    """
    if len(analyses) < 2:
        raise ParameterError(f"{len(analyses)} run; a comparison needs at least 2")
    if labels is None:
        names = [analysis.origin for analysis in analyses]
        if set(names) == {"unknown"}:
            names = ["all runs"] * len(analyses)
    else:
        names = list(labels)
    if len(names) != len(analyses):
        raise ParameterError(f"{len(names)} labels for {len(analyses)} runs; give one for each")
    keys = list(dict.fromkeys(key for analysis in analyses for key in analysis.numbers))
    rows = []
    for key in keys:
        example = next(a.numbers[key] for a in analyses if key in a.numbers)
        values = np.array(
            [a.numbers[key].value if key in a.numbers else np.nan for a in analyses], dtype=float
        )
        chosen = {
            name: spread_of(values[[n == name for n in names]], seed=seed)
            for name in dict.fromkeys(names)
        }
        rows.append(
            Row(
                key=key,
                label=example.label,
                unit=example.unit,
                group=example.group,
                values=tuple(values.tolist()),
                by_label=chosen,
                overall=spread_of(values, seed=seed),
            )
        )
    outcomes = Counter(headline(analysis.verdicts) for analysis in analyses)
    return Comparison(tuple(analyses), tuple(names), tuple(rows), dict(outcomes.most_common()))


def with_errors(comparison: Comparison, *, delta: float = 1.0, offset: float = 0.0) -> Comparison:
    """Return the same comparison with the errors of its runs against the first one.

    Parameters
    ----------
    comparison : Comparison
        Its first run is the reference.
    delta, offset : float
        See `reference_errors.errors_against`; s.

    Raises
    ------
    LogError
        When runs have other numbers of robots, or no samples at the same times.
    ParameterError
        When `delta` or `offset` are no such times.
    """
    reference, *others = (analysis.recording for analysis in comparison.analyses)
    errors = tuple(errors_against(run, reference, delta=delta, offset=offset) for run in others)
    return replace(comparison, errors=errors)


def labelled(analyses: Sequence[Analysis], labels: Sequence[str]) -> list[Analysis]:
    """Return the runs under the labels that they were given: alone, or before a run's own name.

    Parameters
    ----------
    analyses : sequence of Analysis
        In the order of the labels; they stay as they are.
    labels : sequence of str
        What each counts as.

    Raises
    ------
    ParameterError
        When there is not a label for each.
    """
    if len(labels) != len(analyses):
        raise ParameterError(f"{len(labels)} labels for {len(analyses)} runs; give one for each")
    shared = Counter(labels)
    names = [
        label if shared[label] == 1 else f"{label}: {analysis.name}"
        for label, analysis in zip(labels, analyses, strict=True)
    ]
    return [
        replace(analysis, recording=replace(analysis.recording, name=name))
        for name, analysis in zip(names, analyses, strict=True)
    ]


def _without_nan(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def distinctly_named(analyses: Sequence[Analysis]) -> list[Analysis]:
    """Return the runs with names that differ: those that share one get their folder's before it.

    Parameters
    ----------
    analyses : sequence of Analysis
        Runs whose names may coincide, as those of one experiment repeated do.
    """
    count = Counter(analysis.name for analysis in analyses)
    used: Counter[str] = Counter()
    named = []
    for analysis in analyses:
        name = analysis.name
        if count[name] > 1:
            source = analysis.recording.sources[0] if analysis.recording.sources else ""
            folder = Path(source).parent.name
            name = f"{folder}/{name}" if folder else name
            used[name] += 1
            name = name if used[name] == 1 else f"{name} ({used[name]})"
        named.append(replace(analysis, recording=replace(analysis.recording, name=name)))
    return named


def spread_of(values: Floats, *, seed: int = 0) -> Spread:
    """Return mean and 95 % bootstrap interval of one number over runs, undefined ones left out.

    Parameters
    ----------
    values : (runs,) array
        NaN where undefined.
    seed : int
        Of the resampling.
    """
    known = values[np.isfinite(values)]
    nan = float("nan")
    if not known.size:
        return Spread(0, nan, nan, nan, nan, nan)
    mean, least, most = float(known.mean()), float(known.min()), float(known.max())
    return Spread(int(known.size), mean, *mean_interval(known, seed=seed), least, most)
