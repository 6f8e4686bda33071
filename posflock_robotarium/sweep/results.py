"""What a study found: tidy tables, and medians with confidence intervals.

Tables hold one run a row, sorted by combination and replication, and leave out when and
how fast it was computed.  The same study gives the same bytes, in whatever order its runs
were computed, on machines whose processors and libraries are alike.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections import Counter
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from posflock_robotarium.alignment.intervals import median_interval
from posflock_robotarium.sweep.store import ENGINE, ERROR, Row, Store
from posflock_robotarium.sweep.study import Study
from rps_compat.whole_files import atomic_write, write_whole

#: Columns of a summary behind those of the grid.
_OF_SUMMARY = ("outcome", "runs", "median", "low", "high", "q1", "q3")
#: The table for programs, beside the one that everybody opens.
PARQUET = "results.parquet"
#: In a row of the store, but not the run's result.
_OF_MACHINE = ("seconds",)


def finished(study: Study, store: Store) -> list[Row]:
    """Return the rows of a study that are in the store, by combination and replication.

    Those of runs that failed are among them, with their reason under `store.ERROR`.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    store : Store
        Where its runs are kept.
    """
    rows = [
        # The place of a combination may have moved since the row was stored.
        {**store.rows[run.key], "point": run.point}
        for run in study.runs()
        if run.key in store.rows
    ]
    return [{k: v for k, v in row.items() if k not in _OF_MACHINE} for row in rows]


def succeeded(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of runs that did not fail.

    Parameters
    ----------
    rows : sequence of Row
        From :func:`finished`.
    """
    return [row for row in rows if ERROR not in row]


def of_other_code(study: Study, store: Store) -> int:
    """Return how many runs in the store were computed by other code than the study's now.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    store : Store
        Where its runs are kept.
    """
    code, name = study.code, study.experiment.name
    return sum(
        row.get("code") != code and row.get("experiment") == name for row in store.rows.values()
    )


def engines(study: Study, rows: Sequence[Row]) -> dict[str, int]:
    """Return how many runs were computed by whom, where an experiment has several engines.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    rows : sequence of Row
        Its runs, as the store has them.
    """
    if study.experiment.engine is None:
        return {}
    return dict(Counter(str(row[ENGINE]) for row in rows if ENGINE in row))


def outcomes(study: Study, rows: Sequence[Row]) -> list[str]:
    """Return the names of what came out of the runs, without what went in.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    rows : sequence of Row
        Its runs, as the store has them.
    """
    given = {"key", "point", "replication", "experiment", "study_seed", "version", "code"}
    given |= {*study.experiment.defaults, *([ENGINE] if study.experiment.engine else [])}
    told = dict.fromkeys(name for row in succeeded(rows) for name in row)
    return [name for name in told if name not in given]


def summary(study: Study, rows: Sequence[Row]) -> list[Row]:
    """Return median, quartiles and confidence interval of every outcome and combination.

    Parameters
    ----------
    study : Study
        What was run.
    rows : sequence of rows
        From :func:`finished`.

    Returns
    -------
    list of rows
        One for each combination and outcome: the values of the grid, ``outcome``, ``runs``,
        ``median``, ``low`` and ``high`` (95 % bootstrap interval of the median; None of one or two
        runs), ``q1``, ``q3``.
    """
    found: list[Row] = []
    names, rows = outcomes(study, rows), succeeded(rows)
    for point in sorted({row["point"] for row in rows}):
        of_point = [row for row in rows if row["point"] == point]
        combination = {name: of_point[0][name] for name in study.grid}
        for name in names:
            # A number is absent from runs that are too short for it.
            values = np.array([row[name] for row in of_point if name in row], dtype=float)
            if not values.size:
                continue
            low, high = (None if math.isnan(end) else end for end in median_interval(values))
            q1, q3 = np.percentile(values, [25, 75], method="nearest")
            median = float(np.median(values))
            found.append(
                {**combination, "outcome": name, "runs": len(values), "median": median}
                | {"low": low, "high": high, "q1": float(q1), "q3": float(q3)}
            )
    return found


def write_tables(study: Study, store: Store, folder: Path) -> list[Path]:
    """Write ``results.csv`` and ``summary.csv``; return the paths.

    With pyarrow, ``results.parquet`` too. Without it, one of an earlier call is removed: it would
    not be of these runs.

    Where no run is finished, there is nothing to write, and no path.

    Parameters
    ----------
    study : Study
        Which runs of which experiment.
    store : Store
        Where its runs are kept.
    folder : Path
        Where the files are put.

    Raises
    ------
    OutputError
        Where the folder cannot be written.
    """
    done = finished(study, store)
    rows = _of_one_form(done)
    if not rows:
        return []
    paths = [folder / name for name in ("results.csv", "summary.csv", PARQUET)]
    write_whole(paths[0], _as_csv(rows, list(rows[0])))
    columns = [*study.grid, *_OF_SUMMARY]
    write_whole(paths[1], _as_csv(summary(study, done), columns))
    if not parquet_is_installed():
        paths.pop().unlink(missing_ok=True)
        return paths
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.Table.from_pylist(rows)
    about = {b"posflock study": json.dumps(study.said, sort_keys=True).encode()}
    with atomic_write(paths[2]) as draft:
        parquet.write_table(table.replace_schema_metadata(about), draft)
    return paths


def parquet_is_installed() -> bool:
    """Whether the library that writes Parquet is there; the extra ``parquet`` brings it."""
    return find_spec("pyarrow") is not None


def _of_one_form(rows: Sequence[Row]) -> list[Row]:
    """Return rows that all have all columns, None where a run that failed has no outcome."""
    columns = dict.fromkeys(name for row in (*succeeded(rows), *rows) for name in row)
    return [{name: row.get(name) for name in columns} for row in rows]


def _as_csv(rows: Sequence[Row], columns: Sequence[str]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
