"""What the safety certificate did, where the log tells."""

from __future__ import annotations

import numpy as np

from barrier_certificates import ties
from barrier_certificates.projection import Status
from posflock_robotarium.alignment.measured_run import Floats, MeasuredRun
from posflock_robotarium.alignment.metric_registry import Metric, Scalar, register
from posflock_robotarium.alignment.panels import CERTIFICATE, CLEARANCE
from posflock_robotarium.alignment.reductions import largest, smallest
from posflock_robotarium.flocking.pose_log import INTERVENED


def _known_interventions(run: MeasuredRun) -> Floats | None:
    """Return the change of velocity, m/s, of the steps of which it is known; None without any."""
    known = run.recording.intervention
    if known is None or not np.isfinite(known).any():
        return None
    moved: Floats = known[np.isfinite(known)]
    return moved


def _share_intervened(run: MeasuredRun) -> float | None:
    known = run.once(_known_interventions)
    return None if known is None else float(ties.beyond(known, INTERVENED).mean())


def _mean_intervention(run: MeasuredRun) -> float | None:
    known = run.once(_known_interventions)
    if known is None:
        return None
    intervened = ties.beyond(known, INTERVENED)
    return float(known[intervened].mean()) if intervened.any() else 0.0


def _clearance(run: MeasuredRun) -> Floats | None:
    clearance = run.recording.clearance
    if clearance is None or not np.isfinite(clearance).any():
        return None
    return np.where(np.isfinite(clearance), clearance, np.nan)


def _first_clearance(run: MeasuredRun) -> float | None:
    clearance = run.once(_clearance)
    return None if clearance is None or not np.isfinite(clearance[0]) else float(clearance[0])


def _unsolved(run: MeasuredRun) -> int | None:
    status = run.recording.status
    return (
        None
        if status is None
        else int(np.isin(status, (Status.RELAXED.value, Status.FAILED.value)).sum())
    )


register(
    Metric(
        "intervention",
        "intervention of the certificate",
        "m/s",
        "How far the safety certificate changed a robot's velocity, at most.",
        lambda run: run.recording.intervention,
        "largest",
        panel=CERTIFICATE,
        numbers=(
            Scalar(
                "interventions",
                "steps in which the certificate intervened",
                "share",
                f"Steps in which it changed a velocity by more than {1e3 * INTERVENED:g} mm/s.",
                "Certificate",
                _share_intervened,
                latex=True,
            ),
            Scalar(
                "intervention_mean",
                "mean intervention",
                "m/s",
                "Mean over those steps of the largest change of a robot's velocity.",
                "Certificate",
                _mean_intervention,
            ),
            Scalar(
                "intervention_largest",
                "largest intervention",
                "m/s",
                "Whole run.",
                "Certificate",
                largest("intervention"),
            ),
        ),
    ),
    Metric(
        "clearance",
        "clearance of the certificate",
        "m",
        "Distance beyond what the certificate keeps between look-ahead points and from walls; "
        "negative where the team is unsafe.",
        _clearance,
        "smallest",
        panel=CLEARANCE,
        numbers=(
            Scalar(
                "clearance",
                "smallest clearance",
                "m",
                "Distance beyond what the certificate keeps between look-ahead points and from "
                "walls, whole run; negative where it was not kept.",
                "Certificate",
                smallest("clearance"),
            ),
            Scalar(
                "clearance_first",
                "clearance at the start",
                "m",
                "Negative: the run started unsafe, so that the certificate guarantees nothing.",
                "Certificate",
                _first_clearance,
            ),
        ),
    ),
    Scalar(
        "unsolved",
        "steps without an exact solution",
        "",
        "Steps in which the certificate was relaxed or failed.",
        "Certificate",
        _unsolved,
    ),
)
