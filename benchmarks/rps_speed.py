"""How fast scripts run, against what others would write, and what plotting adds.

What is judged are ratios of CPU time, taken in turns:

- a step of nine robots through the API against the same arithmetic in plain numpy, without an API
  (`references.plain_step`);
- a script with a boundary certificate against the same script with the certificate as it is
  commonly written, dense and by cvxopt (`references.dense_certificate`);
- making an instance against the same plain numpy steps;
- a script that plots in every step against the same script without.

Memory is judged as it is. Exits 1 where a bar is missed.
"""

import argparse
import gc
import resource
import sys
import tempfile
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path

import numpy as np
from comparing import Table, Times, cpu
from history import recorded
from references import dense_certificate, plain_step

import rps_compat
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.testbed import GTERNAL

STEPS, DRAWN, INSTANCES = 3000, 500, 20
#: Most that each may take of its reference. Measured: see docs/reference/api-compatibility.md.
MOST_STEP, MOST_CONSTRUCTION, MOST_PLOTTING = 1.0, 12.0, 1.5
MOST_CERTIFIED = {9: 0.12, 50: 0.02}
MOST_GROWTH = 10  # MB

#: A script that circles with a boundary certificate; {plot} is what it draws in every step.
SCRIPT = """
import time
import numpy as np
from rps.robotarium import *
from rps.utilities.barrier_certificates import *
from rps.utilities.transformations import *

N = 9
angles = np.linspace(0, 2 * np.pi, N, endpoint=False)
start = np.stack([0.7 * np.cos(angles), 0.7 * np.sin(angles), angles])
r = Robotarium(number_of_robots=N, sim_in_real_time=True, initial_conditions=start)
barrier = create_single_integrator_barrier_certificate_with_boundary()
si_to_uni, uni_to_si = create_si_to_uni_mapping()
markers = r.axes.scatter(start[0], start[1])
labels = [r.axes.text(0, 0, str(i)) for i in range(N)]
began = time.process_time()
for k in range({steps}):
    x = r.get_poses()
    points = uni_to_si(x)
    {plot}
    r.set_velocities(np.arange(N), si_to_uni(barrier(0.1 * np.array([-x[1], x[0]]), points), x))
    r.step()
print("cpu", time.process_time() - began)
"""
PLOTS = {
    "nothing": "pass",
    "axes.plot": "r.axes.plot(x[0], x[1], 'b.')",
    "axes.scatter": "r.axes.scatter(x[0], x[1], s=4)",
    "plt.plot": "plt.plot(x[0, 0], x[1, 0], 'r.')",
    "set_offsets": "markers.set_offsets(x[:2].T)",
    "labels": "[label.set_position(x[:2, i]) for i, label in enumerate(labels)]",
    "plt.pause": "markers.set_offsets(x[:2].T); plt.pause(0.01)",
}


def places(robots: int) -> np.ndarray:
    """Poses on a grid, (3, robots)."""
    x, y = np.meshgrid(np.linspace(-1.4, 1.4, 10), np.linspace(-0.8, 0.8, 5))
    return np.stack([x.ravel(), y.ravel(), np.zeros(50)])[:, :robots]


def robotarium(generation: int, robots: int, **options: object) -> object:
    from rps.robotarium import Robotarium

    if generation == 2:
        options["skip_initialization"] = True
    options = {"show_figure": False, "sim_in_real_time": False, **options}
    return Robotarium(number_of_robots=robots, initial_conditions=places(robots), **options)


def stepping(generation: int) -> Callable[[], float]:
    """Return what steps nine robots that turn on the spot."""

    def loop() -> None:
        for _ in range(STEPS):
            r.get_poses()
            r.set_velocities(ids, command)
            r.step()

    r, ids = robotarium(generation, 9), np.arange(9)
    command = np.stack([np.zeros(9), np.full(9, 0.5)])
    return lambda: cpu(loop)


def plain_stepping() -> float:
    """Do the same without an API."""

    def loop() -> None:
        for _ in range(STEPS):
            plain_step(poses, command, GTERNAL, pairs)

    poses = places(9)
    command = np.stack([np.zeros(9), np.full(9, 0.5)])
    pairs = np.triu_indices(9, 1)
    return cpu(loop)


def swapping(generation: int, robots: int, steps: int, dense: bool = False) -> float:
    """Let everybody change places behind a boundary certificate, ours or the common one."""
    from rps.utilities import barrier_certificates as certificates
    from rps.utilities.transformations import create_si_to_uni_mapping

    kind = "si" if generation == 2 else "single_integrator"
    ours = getattr(certificates, f"create_{kind}_barrier_certificate_with_boundary")
    barrier = dense_certificate(GTERNAL.boundaries) if dense else ours()
    to_command, _ = create_si_to_uni_mapping()
    r, ids = robotarium(generation, robots), np.arange(robots)
    goals = places(robots)[:2, ::-1]

    def loop() -> None:
        for _ in range(steps):
            x = r.get_poses()
            velocities = barrier(0.15 * np.sign(goals - x[:2]), x[:2])
            r.set_velocities(ids, to_command(velocities, x))
            r.step()

    return cpu(loop)


def plotting(plot: str, steps: int, folder: Path) -> float:
    """CPU seconds of the loop of a script that plots; the runner is headless."""
    script = folder / "script.py"
    script.write_text(SCRIPT.format(steps=steps, plot=PLOTS[plot]))
    said = folder / "said.txt"
    with said.open("w") as file, redirect_stdout(file):
        result = run_script(script, (), RunSettings(headless=True, seed=0))
    if result.exit_code:
        raise RuntimeError(result.reason)
    return float(said.read_text().split()[1])


def growth(generation: int) -> float:
    """Return the MB by which the process grows from the hundredth to the thousandth instance."""

    def resident(instances: int) -> float:
        for _ in range(instances):
            r = robotarium(generation, 9, show_figure=True)
            r.get_poses()
            r.step()
        gc.collect()
        statm = Path("/proc/self/statm")
        if statm.exists():
            return int(statm.read_text().split()[1]) * resource.getpagesize() / 2**20
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # the most so far

    before = resident(100)
    return resident(900) - before


def constructing(generation: int) -> float:
    """Return the CPU seconds of an instance."""
    return cpu(lambda: [robotarium(generation, 9) for _ in range(INSTANCES)]) / INSTANCES


def main() -> int:
    """Measure, print, and return 1 where a requirement is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    table = Table()
    for generation in (1, 2):
        rps_compat.install(generation=generation)
        table.part(f"generation {generation}")
        times = Times({"ours": stepping(generation), "plain": plain_stepping}, rounds)
        table.ratio("nine robots, against plain numpy", times, "ours", "plain", MOST_STEP, STEPS)
        print(f"    {STEPS / times.median('ours'):,.0f} steps a second of CPU time")
        for robots, steps in ((9, 150), (50, 10)):
            swap = partial(swapping, generation, robots, steps)
            times = Times({"ours": swap, "dense": partial(swap, dense=True)}, rounds)
            what = f"{robots} robots and boundary, against dense cvxopt"
            table.ratio(what, times, "ours", "dense", MOST_CERTIFIED[robots], steps)
            print(f"    {steps / times.median('ours'):,.0f} steps a second of CPU time")
        times = Times(
            {
                "instance": partial(constructing, generation),
                "step": lambda: plain_stepping() / STEPS,
            },
            rounds,
        )
        what = "construction, against a plain numpy step"
        table.ratio(what, times, "instance", "step", MOST_CONSTRUCTION)
        table.bar("growth by 900 more instances", growth(generation), "≤", MOST_GROWTH, "MB")
        rps_compat.uninstall()
    table.part("plotting in every step, against the same script without")
    with tempfile.TemporaryDirectory() as folder:
        drawn = Times(
            {plot: partial(plotting, plot, DRAWN, Path(folder)) for plot in PLOTS}, rounds
        )
    for plot in list(PLOTS)[1:]:
        table.ratio(plot, drawn, plot, "nothing", MOST_PLOTTING, DRAWN)
    return recorded("rps_speed", table)


if __name__ == "__main__":
    sys.exit(main())
