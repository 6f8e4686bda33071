"""``posflock calibrate``: from a returned log to a realism profile."""

from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    from posflock_robotarium.calibration import Calibration


def calibrate(
    log: options.CommandedLog,
    out: options.FittedProfile = Path("calibrated.toml"),
    name: options.ProfileName = "calibrated",
    pooled: options.Pooled = False,
    resimulate: options.ResimulatedLog = None,
    json_only: options.EstimatesAsJson = False,
) -> None:
    """Fit dead time, lag, gains, bias and noise to a log, and write them as a realism profile.

    Exit code 0, or 2 with the reason when the log cannot be read or does not tell enough.

    [bold]Examples[/bold]

        posflock calibrate back/nine_robots.npy -o lab.toml

        posflock verify main.py --profile lab.toml

        posflock calibrate back/nine_robots.npy -o lab.toml --resimulate again.npy

        posflock compare back/nine_robots.npy again.npy
    """
    from posflock_robotarium.calibration import calibrate as fit
    from posflock_robotarium.calibration import read_commanded, write_profile
    from posflock_robotarium.calibration import resimulate as simulate
    from posflock_robotarium.logs.convert import write_pose_log

    read = read_commanded(log)
    found = fit(read)
    profile = found.profile(name, pooled=pooled)
    write_profile(profile, out)
    if resimulate is not None:
        write_pose_log(simulate(read, found.profile(name)), resimulate)
    if json_only:
        import json

        say(json.dumps(found.as_dict(), indent=1))
        return
    _print_estimates(found)
    say(f"wrote {out}")
    if resimulate is not None:
        say(f"wrote {resimulate}; overlay them with posflock compare {log} {resimulate}")


def _print_estimates(found: "Calibration") -> None:
    say(f"{'dead time':<18} {found.dead_time} s")
    say(f"{'lag':<18} {found.lag} s")
    for robot, (speed, turn, bias, offset) in enumerate(
        zip(found.speed_gain, found.turn_gain, found.turn_bias, found.heading_offset, strict=True)
    ):
        say(f"robot {robot}: speed gain {speed}, turn gain {turn}")
        say(f"         turn bias {bias} rad/s, heading offset {offset} rad")
    jitter, unexplained = found.jitter, found.disturbance
    for what, estimate, unit in (
        ("jitter, along", jitter.along, "m"),
        ("jitter, lateral", jitter.lateral, "m"),
        ("jitter, heading", jitter.heading, "rad"),
        ("unexplained speed", unexplained.speed, "m/s"),
        ("unexplained turn", unexplained.turn, "rad/s"),
    ):
        say(f"{what:<18} {estimate} {unit}")
