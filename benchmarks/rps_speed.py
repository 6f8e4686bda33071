"""How fast scripts run: steps a second of CPU time, construction, the price of plotting.

Each figure is the median of interleaved repetitions in process CPU time; run it with one BLAS
thread, as ``make bench-rps`` does. Prints measured against required; exits 1 where one is missed.
"""

import argparse
import gc
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from statistics import median

import numpy as np

import rps_compat
from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script

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


def robotarium(api: int, robots: int, **options: object) -> object:
    from rps.robotarium import Robotarium

    x, y = np.meshgrid(np.linspace(-1.4, 1.4, 10), np.linspace(-0.8, 0.8, 5))
    poses = np.stack([x.ravel(), y.ravel(), np.zeros(50)])[:, :robots]
    if api == 2:
        options["skip_initialization"] = True
    options = {"show_figure": False, "sim_in_real_time": False, **options}
    return Robotarium(number_of_robots=robots, initial_conditions=poses, **options)


def steps_per_second(api: int, robots: int, steps: int, certified: bool) -> float:
    r = robotarium(api, robots)
    ids = np.arange(robots)
    command = np.stack([np.zeros(robots), np.full(robots, 0.5)])
    if certified:
        from rps.utilities import barrier_certificates as certificates
        from rps.utilities.transformations import create_si_to_uni_mapping

        name = (
            "create_si_barrier_certificate_with_boundary"
            if api == 2
            else ("create_single_integrator_barrier_certificate_with_boundary")
        )
        barrier = getattr(certificates, name)()
        si_to_uni, _ = create_si_to_uni_mapping()
        goals = r.get_poses()[:2, ::-1].copy()  # everybody changes places
        r.step()
    began = time.process_time()
    for _ in range(steps):
        x = r.get_poses()
        if certified:
            command = si_to_uni(barrier(0.15 * np.sign(goals - x[:2]), x[:2]), x)
        r.set_velocities(ids, command)
        r.step()
    return steps / (time.process_time() - began)


def construction(api: int) -> float:
    began = time.process_time()
    for _ in range(20):
        robotarium(api, 9)
    return (time.process_time() - began) / 20


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


def growth(api: int) -> float:
    """MB by which the process grows from the hundredth to the thousandth instance."""

    def run(instances: int) -> None:
        for _ in range(instances):
            r = robotarium(api, 9, show_figure=True)
            r.get_poses()
            r.step()
        gc.collect()

    run(100)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    run(900)
    return (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024


def interleaved(candidates: dict[str, Callable[[], float]], repetitions: int) -> dict[str, float]:
    found: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(repetitions):
        for name, candidate in candidates.items():
            found[name].append(candidate())
    return {name: median(values) for name, values in found.items()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=5)
    repetitions = parser.parse_args().repetitions
    rows: list[tuple[str, float, str, float]] = []
    for api in (1, 2):
        rps_compat.install(api=api)
        speeds = interleaved(
            {
                "N = 9": lambda api=api: steps_per_second(api, 9, 5000, False),
                "N = 9, boundary certificate": lambda api=api: steps_per_second(api, 9, 1000, True),
                "N = 50, boundary certificate": lambda api=api: steps_per_second(
                    api, 50, 200, True
                ),
            },
            repetitions,
        )
        for (name, speed), required in zip(speeds.items(), (20_000, 3_000, 400), strict=True):
            rows.append((f"generation {api}, {name}: steps/s", speed, ">=", required))
        seconds = interleaved({"": lambda api=api: construction(api)}, repetitions)[""]
        rows.append((f"generation {api}, construction: ms", 1000 * seconds, "<=", 20))
        rows.append((f"generation {api}, 900 more instances: MB", growth(api), "<=", 10))
        rps_compat.uninstall()
    with tempfile.TemporaryDirectory() as folder:
        costs = interleaved(
            {plot: lambda plot=plot: plotting(plot, 1000, Path(folder)) for plot in PLOTS},
            repetitions,
        )
    for plot, cost in list(costs.items())[1:]:
        rows.append(
            (f"time of a script with {plot} in every step", cost / costs["nothing"], "<=", 1.5)
        )
    missed = 0
    for name, measured, sign, required in rows:
        met = measured >= required if sign == ">=" else measured <= required
        missed += not met
        print(f"{name:58} {measured:10.2f}  {sign} {required:<8g} {'' if met else 'MISSED'}")
    return int(bool(missed))


if __name__ == "__main__":
    sys.exit(main())
