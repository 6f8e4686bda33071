"""Position-based flocking with nine robots: the paper's experiment, as it is submitted.

Nine robots start at random places and headings in a square metre and align without
measuring any velocity (Jond et al., Section "Experiment").  The same bytes run in the
simulator on this machine and on the Robotarium, on either generation of its API:

    python experiments/robotarium_9bot.py --seed 3 --out results

leaves the pose log nine_robots.npy with its description nine_robots.json and, where no
Robotarium package is installed and ours stands in, summary.json and the figures.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

try:
    import rps.robotarium as robotarium

    STAND_IN = False
except ImportError:
    import rps_compat

    # Robots stand where they are asked to, so that a seed gives one run to the last byte.
    rps_compat.install(generation=2, session=rps_compat.Session(initial="exact"))
    import rps.robotarium as robotarium

    # Judging and drawing is for the laptop: of it nothing goes to the testbed.
    from posflock_robotarium.report.nine_robots import report_experiment

    STAND_IN = True

from barrier_certificates.unicycle import UnicycleCertificate
from posflock_robotarium.flocking.constants_on_board import constants_of
from posflock_robotarium.flocking.errors import ParameterError, PosflockError
from posflock_robotarium.flocking.flock import EXPERIMENT_CERTIFICATE, WALLS, Flock
from posflock_robotarium.flocking.law import LawParameters
from posflock_robotarium.flocking.placement import random_poses
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.flocking.progress import steps_of

ROBOTS = 9
DURATION = 120.0  # s
TIME_STEP = 0.033  # s, the testbed's
START_SIDE = 1.0  # m, the square in which the robots start
START_SPACING = 0.30  # m, at least, between any two of them; look-ahead points are 0.32 m apart
LAW = LawParameters(
    distance_scale=0.12,  # δ, m
    radius=0.75,  # r, m
    persistence=0.15,  # k, 1/s
    speed_limit=0.15,  # v_max, m/s
    input_limit=0.5,  # u_max, m/s²
)


def main() -> None:
    """Run the experiment once."""
    options = parse_options()
    if options.certificate == "off" and not STAND_IN:
        raise ParameterError(
            "--certificate off lets robots collide: it is for the simulator, to show what the law"
            " does on its own; run it where no Robotarium package is installed"
        )
    chance = np.random.default_rng(options.seed)
    start = random_poses(ROBOTS, chance, side=START_SIDE, spacing=START_SPACING)
    certificate = replace(EXPERIMENT_CERTIFICATE, pair_rows=options.certificate == "on")
    flock = flock_in({}, options, certificate)
    steps = flock.steps_in(options.duration)
    description = flock.parameters() | {
        "experiment": "robotarium_9bot",
        "seed": options.seed,
        "duration": options.duration,
        "requested_poses": start.tolist(),
        "api_generation": 2 if hasattr(robotarium.Robotarium, "debug") else 1,
    }
    # The log first: a folder that cannot be written is refused before a robot has moved.
    path = options.out / "nine_robots"
    with PoseLog(path, ROBOTS, steps, description) as log:
        r = robotarium.Robotarium(
            number_of_robots=ROBOTS,
            show_figure=options.show,
            sim_in_real_time=options.show,
            initial_conditions=start,
        )
        constants = constants_of(r)
        flock = flock_in(constants, options, certificate)
        log.annotate(robot=constants, **flock.parameters())
        try:
            run(r, flock, log, steps)
        except KeyboardInterrupt:  # the testbed's way to end a run
            log.close("interrupted", "KeyboardInterrupt: the run was stopped from outside")
            print(f"interrupted: the {log.rows} steps until then are in {log.path}")
        if flock.retuned:  # by somebody who watched
            log.annotate(retuned=flock.retuned)
    getattr(r, "debug" if hasattr(r, "debug") else "call_at_scripts_end")()
    if STAND_IN:
        report_experiment(log.path)


def flock_in(
    constants: dict[str, Any], options: argparse.Namespace, certificate: UnicycleCertificate
) -> Flock:
    """Return the flock for the arena and the time step that the Robotarium tells of."""
    arena = tuple(constants.get("boundaries", certificate.boundary))
    time_step = constants.get("time_step", TIME_STEP)
    certificate = replace(certificate, boundary=arena)
    return Flock(LAW, time_step, walls=options.walls, certificate=certificate, local=options.local)


def run(r: Any, flock: Flock, log: PoseLog, steps: int) -> None:
    """Read, decide, command and log, once a step."""
    for step in steps_of(steps, flock.time_step, "flocking"):
        poses = r.get_poses()
        decision = flock.step(poses)
        r.set_velocities(np.arange(ROBOTS), decision.command)
        log.append(step * flock.time_step, poses, **decision.logged())
        r.step()


def parse_options() -> argparse.Namespace:
    """Read the options; the testbed gives none, so each has a default."""
    parser = argparse.ArgumentParser(description="The paper's nine-robot flocking experiment.")
    parser.add_argument("--seed", type=int, default=0, help="of the starting poses")
    parser.add_argument("--duration", type=float, default=DURATION, help="in seconds")
    parser.add_argument("--walls", choices=WALLS, default="steer", help="certificate: no steering")
    parser.add_argument(
        "--certificate",
        choices=("on", "off"),
        default="on",
        help="off: a control run in which nobody is kept apart (simulator only)",
    )
    parser.add_argument(
        "--local",
        action="store_true",
        help="each robot decides by what it senses within 0.75 m and hears from neighbours once a"
        " step; without, by the mean over the flock and one certificate for the team",
    )
    parser.add_argument("--out", type=Path, default=Path(), help="folder for what the run leaves")
    parser.add_argument("--show", action="store_true", help="watch it in real time")
    return parser.parse_args()


if __name__ == "__main__":
    try:
        main()
    except PosflockError as error:
        raise SystemExit(f"robotarium_9bot: {error}") from error
