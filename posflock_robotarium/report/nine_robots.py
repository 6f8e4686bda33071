"""What the nine-robot experiment tells at its end on a laptop: its summary and its figures."""

import json
from pathlib import Path


def report_experiment(path: Path) -> None:
    """Summarise and draw a run beside its log; for one from the testbed, ``posflock report`` does.

    Parameters
    ----------
    path : Path
        The pose log. ``summary.json`` and the figures are written into its folder.

    Raises
    ------
    LogError
        The log cannot be judged.
    """
    from posflock_robotarium.alignment.summary import summarise
    from posflock_robotarium.figures.experiment import draw_run
    from posflock_robotarium.logs.readers import read
    from rps_compat.terminal import printable
    from rps_compat.whole_files import write_whole

    log = read(path)
    summary = summarise(log)
    # The digest tells a reader of which run in this folder these are the numbers.
    told = {**summary.as_dict(), "rows_digest": log.parameters.get("rows_digest")}
    write_whole(path.parent / "summary.json", json.dumps(told, indent=1) + "\n")
    print(printable(str(summary)))
    for drawn in draw_run(log, path.parent):
        print(f"wrote {drawn}")
