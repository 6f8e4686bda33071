"""How far runs of one seed drift apart from machine to machine, and whether their numbers do.

The same runs are made in processes of their own, as this processor computes and as those would
that can do less (the settings of ``.ci/portable.py``). Printed is, at several times, the largest
distance of a robot or agent from where it is in the first of these runs; and how far the figures
of a run differ. There is no bar: this measures, for docs/explanations/reproducibility.md.
"""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / ".ci"))

from portable import Setting, settings_for  # noqa: E402

RUNS = """
import sys
import numpy as np
from posflock_robotarium.alignment import metrics
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.freespace.simulation import FreeSpace, simulate
from posflock_robotarium.alignment.point_agents import measure, summarise
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.alignment.summary import summarise as figures_of
from posflock_robotarium.simulation.flock_trial import simulate as drive
from rps_compat.profiles import load_profile

out = {}
for seed in range(SEEDS):
    for name, profile in (("nine robots", None), ("nine robots, gritsbot_x", "gritsbot_x")):
        start = random_poses(9, np.random.default_rng(seed))
        realism = load_profile(profile).start() if profile else None
        log = drive(Flock(), start, 120.0, realism=realism, seed=seed).truth()
        out[f"{name}/{seed}"] = log.poses[::30, :2]
        figures = figures_of(log)
        out[f"{name}/{seed}/figures"] = [figures.gamma_motion, figures.smallest_distance]
    for model in Model:
        scenario = FreeSpace(model, record_interval=1.0)
        run = simulate(scenario, seed)
        out[f"50 agents, {model.value}/{seed}"] = run.positions
        figures = summarise(measure(run, 7.5))
        out[f"50 agents, {model.value}/{seed}/figures"] = [
            figures["gamma_settled"], figures["nearest_neighbour_end"]]
np.savez(sys.stdout.buffer, **out)
"""
SEEDS = 5
TIMES = (1, 5, 10, 20, 40, 60, 80, 99)


def runs_under(setting: Setting) -> dict[str, np.ndarray]:
    """Return positions (T, 2, N), about once a second, and figures of each run."""
    program = RUNS.replace("SEEDS", str(SEEDS))
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=setting.environment(),
        check=True,
        stdout=subprocess.PIPE,
    )
    with np.load(io.BytesIO(done.stdout)) as file:
        return {name: file[name] for name in file.files}


def main() -> int:
    """Run, compare and print."""
    settings, _ = settings_for(Path(sys.executable), quick=False)
    first = runs_under(Setting("as it is"))
    others = {setting.name: runs_under(setting) for setting in settings}
    kinds = list(dict.fromkeys(name.split("/")[0] for name in first))
    print(f"largest distance (m), {SEEDS} seeds, after" + "".join(f"{t:>9} s" for t in TIMES))
    for kind in kinds:
        print(kind)
        for name, other in others.items():
            apart = [
                np.hypot(*np.moveaxis(other[run] - first[run], 1, 0)).max(axis=-1)
                for run in first
                if run.startswith(f"{kind}/") and not run.endswith("figures")
            ]
            rows = np.max(apart, axis=0)
            print(f"  {name:<40}" + "".join(f"{rows[min(t, len(rows) - 1)]:11.1e}" for t in TIMES))
        figures = [run for run in first if run.startswith(f"{kind}/") and run.endswith("figures")]
        differ = [abs(other[run] - first[run]) for other in others.values() for run in figures]
        gamma, distance = np.max(differ, axis=0)
        print(f"  figures differ by up to {gamma:.1e} in γ, {distance:.1e} m in distances")
    return 0


if __name__ == "__main__":
    sys.exit(main())
