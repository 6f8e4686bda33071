"""What it costs to verify the nine-robot experiment, against running its script as often.

What is judged is CPU time. The reference runs the same script headless in a process of its own, as
``posflock run`` does, once; verifying with n trials runs it, under imperfections and watched, n + 1
times from start to end, three more in part, and reads the source. Exits 1 where the bar is missed,
or where the experiment does not pass.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from comparing import Table, Times, cpu_with_children, seconds
from history import recorded

from posflock_robotarium.verify import verify
from posflock_robotarium.verify.findings import Verdict

SCRIPT = Path(__file__).parents[1] / "experiments" / "robotarium_9bot.py"
#: Most of the time of as many runs.
MOST = 1.5

RUN = """
import sys
from rps_compat.runner import RunSettings, run_script
sys.exit(run_script(sys.argv[1], (), RunSettings(headless=True)).exit_code)
"""


def plain_run() -> float:
    """Return the CPU seconds of one run of the script."""
    with tempfile.TemporaryDirectory() as folder:
        # A script writes beside itself, as on the testbed.
        command = [sys.executable, "-c", RUN, shutil.copy(SCRIPT, folder)]
        return cpu_with_children(
            lambda: subprocess.run(command, check=True, capture_output=True, cwd=folder)
        )


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, default=20)
    trials = parser.parse_args().trials
    verdicts: list[Verdict] = []

    def verified() -> float:
        return cpu_with_children(lambda: verdicts.append(verify(SCRIPT, trials=trials).verdict)) / (
            trials + 1
        )

    times = Times({"trial": verified, "run": plain_run}, rounds=3)
    table = Table()
    table.ratio("a trial of verify, against a plain run", times, "trial", "run", MOST)
    print(f"    {seconds(times.median('trial') * (trials + 1))} of CPU for {trials} trials")
    failed = sum(verdict is not Verdict.PASS for verdict in verdicts)
    table.bar("verdicts other than PASS", failed, "≤", 0)
    return recorded("verify_cost", table)


if __name__ == "__main__":
    sys.exit(main())
