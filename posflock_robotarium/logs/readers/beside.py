"""What lies beside a pose log and tells of another run, or of another script.

A folder may be used twice, files may be copied. The digest of its rows is what a run is known by:
two runs of one seed are the same bytes, so no drawn number could tell more. `summary.json` has that
digest, `report.json` the sums of all files of its run; `verify.json` and the log's description have
the sum of the script. Where they do not fit, the log is sound, and what lies beside it is not about
it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rps_compat.bounded_files import read_bounded
from rps_compat.run_folder import REPORT_DATA
from rps_compat.whole_files import sum_of

VERDICT = "verify.json"
"""What `posflock verify` leaves for programs."""

NUMBERS = "summary.json"
"""What the experiment of the nine robots leaves for programs."""


def strangers_beside(log: Path, parameters: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a sentence on each file beside a log that is not about it; none where nobody knows.

    Parameters
    ----------
    log : Path
        The log's rows, which can be read.
    parameters : mapping
        What its description says.
    """
    found = []
    sums = _said(log.with_name(REPORT_DATA)).get("sums")
    told = sums.get(log.name) if isinstance(sums, dict) else None
    if told is not None and told != sum_of(log):
        found.append(f"{REPORT_DATA} beside it is of another run")
    rows, summed = parameters.get("rows_digest"), _said(log.with_name(NUMBERS)).get("rows_digest")
    if rows is not None and summed is not None and rows != summed:
        found.append(f"{NUMBERS} beside it is of another run")
    ran, verified = parameters.get("sha256"), _said(log.with_name(VERDICT)).get("sha256")
    if ran is not None and verified is not None and ran != verified:
        found.append(
            f"{VERDICT} beside it is of another script than the one that ran, or of another state"
            " of it: its verdict says nothing of this run"
        )
    return tuple(found)


def _said(path: Path) -> dict[str, Any]:
    """Return what a file of JSON says; nothing where it is none."""
    try:
        said = json.loads(read_bounded(path))
    except (OSError, ValueError, RecursionError):
        return {}
    return said if isinstance(said, dict) else {}
