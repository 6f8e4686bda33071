"""Whether a run kept to a target, for how much of its time, and how that is said.

What is undefined is neither kept nor missed: where the answer hangs on it, it is unknown.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from barrier_certificates import ties
from posflock_robotarium.alignment.catalogue import metrics, scalars
from posflock_robotarium.alignment.measured_run import MeasuredRun, weighted_mean
from posflock_robotarium.alignment.metric_registry import Number
from posflock_robotarium.alignment.run_verdict import Mark, RunVerdict
from posflock_robotarium.alignment.targets import Relation, Target, When, parse_target
from posflock_robotarium.alignment.verdict_words import since_text
from posflock_robotarium.flocking.errors import ParameterError

Floats = NDArray[np.float64]

TARGET_GROUP = "Targets"
"""Heading of the shares of time on target in the table of numbers."""

_KEPT: dict[Relation, Callable[[Any, Any], Any]] = {
    Relation.BELOW: ties.short_of,
    Relation.AT_MOST: ties.within,
    Relation.ABOVE: ties.beyond,
    Relation.AT_LEAST: ties.reached,
}


@dataclass(frozen=True)
class TargetOutcome:
    """How one run did by one target.

    Attributes
    ----------
    target : str
        As it was written.
    metric : str
        Key of the metric.
    label : str
        What people call it.
    unit : str
        Of the metric.
    limit : float
        Of the target, in that unit.
    met : bool or None
        Whether the run kept to it; None where that cannot be known.
    value : float or None
        What was held against the limit where it is one number; None where undefined.
    share : float or None
        Of the time that counts, during which the metric kept to the limit; None of one number.
    undefined : float
        Share of the time that counts, during which the metric is undefined.
    kept_from : float or None
        Seconds since the experiment began (after a drive to the start, where the log has one),
        from which on it kept to the limit to the end.
    smallest, mean, largest : float or None
        Of the metric over the time that counts, in its unit; None of one number.
    why_unknown : str
        Why that is not known, where it is not.
    """

    target: str
    metric: str
    label: str
    unit: str
    limit: float
    met: bool | None
    value: float | None = None
    share: float | None = None
    undefined: float = 0.0
    kept_from: float | None = None
    smallest: float | None = None
    mean: float | None = None
    largest: float | None = None
    why_unknown: str = ""


def outcomes_of(run: MeasuredRun, numbers: Mapping[str, Number]) -> tuple[TargetOutcome, ...]:
    """Return how a run did by each of its targets.

    Parameters
    ----------
    run : MeasuredRun
        The run; its options hold the targets.
    numbers : mapping of Number
        From `measuring.numbers_of`.

    Raises
    ------
    ParameterError
        When a target names no metric, or its unit is of another kind.
    """
    return tuple(_outcome(parse_target(text), run, numbers) for text in run.options.targets)


def _outcome(target: Target, run: MeasuredRun, numbers: Mapping[str, Number]) -> TargetOutcome:
    metric, scalar = metrics().get(target.metric), scalars().get(target.metric)
    entry = metric or scalar or _no_such(target)
    limit, number = target.limit_in(entry.unit), numbers.get(target.metric)
    label = metric.label if metric else number.label if number else target.metric
    found = TargetOutcome(target.text, target.metric, label, entry.unit, limit, None)
    curve = None if metric is None else run.curve(target.metric)
    if curve is not None:
        known = bool(np.isfinite(curve).any())
        undefined = _unknown(found, "It is undefined throughout.")
        return _over_time(target, found, run, curve) if known else undefined
    if number is None:
        return _unknown(found, "The log has no data for it.")
    if target.when is not When.UNSAID or target.after:
        raise ParameterError(
            f"target {target.text!r}: {target.metric} is one number a run; end the target after "
            "its unit"
        )
    return _of_number(target, found, float(number.value))


def _no_such(target: Target) -> NoReturn:
    known = [*metrics(), *(key for key in scalars() if key not in metrics())]
    near = difflib.get_close_matches(target.metric, known, 3) or known
    raise ParameterError(
        f"target {target.text!r}: no metric is called {target.metric!r}; expected "
        f"{' or '.join(near[:3])}, another key of summary.json, or one given with --metric"
    )


def _unknown(found: TargetOutcome, why: str) -> TargetOutcome:
    return replace(found, met=None, why_unknown=why)


def _of_number(target: Target, found: TargetOutcome, value: float) -> TargetOutcome:
    if math.isnan(value):
        return _unknown(found, "It is undefined in this run.")
    met = bool(_KEPT[target.relation](value, found.limit))
    return replace(found, met=met, value=value)


def _over_time(
    target: Target, found: TargetOutcome, run: MeasuredRun, curve: Floats
) -> TargetOutcome:
    """Hold a curve against a target, each sample weighted by the time it stands for."""
    elapsed = run.t - run.start
    counted = ties.beyond(elapsed, target.after) if target.after else ties.reached(elapsed, 0.0)
    if not counted.any():
        return _unknown(found, f"The run ends after {elapsed[-1]:.1f} s.")
    values, weights = curve[counted], run.weights[counted]
    if not np.isfinite(values).any():
        return _unknown(found, f"It is undefined after {target.after:g} s.")
    found = replace(
        found,
        smallest=float(np.nanmin(values)),
        mean=weighted_mean(values, weights),
        largest=float(np.nanmax(values)),
    )
    if target.when is When.AVERAGE:
        return _of_number(target, found, weighted_mean(values, weights))
    if target.when is When.END:
        return _of_number(target, found, float(values[-1]))
    kept = np.asarray(_KEPT[target.relation](values, found.limit))
    unknown = np.isnan(values)
    share, undefined = (float(weights[of].sum() / weights.sum()) for of in (kept, unknown))
    missed = np.flatnonzero(~kept)
    first = int(missed[-1]) + 1 if missed.size else 0
    found = replace(
        found,
        share=share,
        undefined=undefined,
        kept_from=float(elapsed[counted][first]) if first < len(values) else None,
    )
    # Always is of samples, not of a sum that rounding moves.
    enough = kept.all() if target.share == 1.0 else ties.reached(share, target.share)
    if enough or not (unknown.any() and ties.reached(share + undefined, target.share)):
        return replace(found, met=bool(enough))
    return _unknown(found, f"It is undefined for {_percent(undefined)} of the time.")


def numbers_of_targets(outcomes: Sequence[TargetOutcome]) -> dict[str, Number]:
    """Return what targets are told by as numbers, so that runs can be compared by them.

    That is the share of time on target, or what stands against the limit at the end or on average.

    Parameters
    ----------
    outcomes : sequence of TargetOutcome
        Of one run.

    Returns
    -------
    dict of Number
        By key; none of targets that a number of the run is held against, which stands there.
    """
    found: dict[str, Number] = {}
    for outcome in outcomes:
        when, after = _when(outcome)
        if outcome.share is not None:
            wanted = f"on_target_{outcome.metric}"
            number = Number(
                f"time on target: {outcome.target}",
                outcome.share,
                "share",
                "Share of the time that the target speaks of, during which the metric kept to the "
                "limit; undefined samples did not.",
                TARGET_GROUP,
            )
        elif outcome.value is not None and when in _ONE_VALUE:
            wanted = f"{_ONE_VALUE[when]}_{outcome.metric}"
            number = Number(
                f"{outcome.label} {when.value}{after}",
                outcome.value,
                outcome.unit,
                f"Held against the target {outcome.target}.",
                TARGET_GROUP,
            )
        else:
            continue
        key, count = wanted, 2
        while key in found:
            key, count = f"{wanted}_{count}", count + 1
        found[key] = number
    return found


_ONE_VALUE = {When.END: "at_end", When.AVERAGE: "on_average"}
"""Times at which one value of a curve stands against the limit, as they begin a number's key."""


def _when(outcome: TargetOutcome) -> tuple[When, str]:
    """Return at which times a target must hold, and after which, in words."""
    target = parse_target(outcome.target)
    after = f", after {target.after:g} s" if target.after and target.when is not When.END else ""
    return target.when, after


def verdicts_of_targets(outcomes: Sequence[TargetOutcome], drive: float = 0.0) -> list[RunVerdict]:
    """Return what is said of each target; of the targets of one metric the headline speaks once.

    Parameters
    ----------
    outcomes : sequence of TargetOutcome
        Of one run.
    drive : float
        Seconds of the log before the experiment began, from which its times count.
    """
    by_metric: dict[str, list[TargetOutcome]] = {}
    for outcome in outcomes:
        by_metric.setdefault(outcome.metric, []).append(outcome)
    verdicts = []
    for outcome in outcomes:
        alike, verdict = by_metric[outcome.metric], verdict_of(outcome, drive)
        if alike[0] is not outcome:
            verdict = replace(verdict, short="")
        elif len({one.met for one in alike}) > 1:
            met = sum(one.met is True for one in alike)
            short = f"{outcome.label} on {met} of {len(alike)} targets"
            verdict = replace(verdict, short=short)
        verdicts.append(verdict)
    return verdicts


_MARKS = {True: Mark.GOOD, False: Mark.BAD, None: Mark.UNKNOWN}
_SHORT = {True: "on target", False: "off target", None: "unknown"}


def verdict_of(outcome: TargetOutcome, drive: float = 0.0) -> RunVerdict:
    """Return what is said of one target.

    Parameters
    ----------
    outcome : TargetOutcome
        How the run did by it.
    drive : float
        Seconds of the log before the experiment began, from which its times count.
    """
    return RunVerdict(
        f"{outcome.target}?",
        _MARKS[outcome.met],
        _answer(outcome),
        _because(outcome, drive),
        f"{outcome.label} {_SHORT[outcome.met]}",
    )


def _answer(outcome: TargetOutcome) -> str:
    if outcome.met is None:
        return "It cannot be known."
    yes = "Yes" if outcome.met else "No"
    if outcome.share is None:
        return f"{yes}: {_with_unit(outcome.value, outcome.unit)}."
    if outcome.share == 1.0 and outcome.met:
        return "Yes, always."
    if outcome.share == 0.0:
        return "No, at no time."
    only = "" if outcome.met else "only "
    return f"{yes}: {only}for {_percent(outcome.share)} of the time."


def _because(outcome: TargetOutcome, drive: float) -> str:
    said = [outcome.why_unknown] if outcome.met is None else []
    if outcome.share and outcome.share < 1.0:
        kept = outcome.kept_from
        said.append(
            "It ends off target." if kept is None else f"For good {since_text(kept, drive)}."
        )
    if outcome.undefined and outcome.met is not None:
        said.append(f"Undefined for {_percent(outcome.undefined)} of the time.")
    if outcome.mean is not None and _when(outcome)[0] is not When.END:  # told of more than that
        mean, low, high = (
            _with_unit(value, outcome.unit)
            for value in (outcome.mean, outcome.smallest, outcome.largest)
        )
        said.append(f"{mean} on average, from {low} to {high}.")
    return " ".join(said)


def _with_unit(value: float | None, unit: str) -> str:
    if value is None:
        return "undefined"
    if unit == "share":
        return _percent(value)
    return f"{value:.3g} {unit}".strip()


def _percent(share: float) -> str:
    percent = 100.0 * share
    if 0.0 < percent < 0.05 or 99.95 <= percent < 100.0:
        return "under 0.1 %" if percent < 1.0 else "over 99.9 %"
    return f"{percent:.1f} %".replace(".0 %", " %")
