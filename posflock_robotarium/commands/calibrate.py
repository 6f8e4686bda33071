"""``posflock calibrate``: from a returned log to a realism profile."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.commands import options
from posflock_robotarium.commands.reading import reading as reading_as
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from posflock_robotarium.calibration import Calibration
    from posflock_robotarium.calibration.estimate import Estimate
    from posflock_robotarium.logs.readers import ReadOptions


def calibrate(
    log: options.CommandedLog = None,
    out: options.FittedProfile = Path("calibrated.toml"),
    name: options.ProfileName = "calibrated",
    pooled: options.Pooled = False,
    resimulated: options.ResimulatedLog = None,
    dt: options.MeanStep = None,
    step_times: options.StepTimes = None,
    layout: options.Layout = None,
    columns: options.Columns = None,
    array: options.Array = None,
    drop_damaged: options.DropDamaged = False,
    units: options.LengthUnit = None,
    degrees: options.Degrees = False,
    time: options.FileClock = "file",
    max_size: options.LargestLog = 256.0,
    max_robots: options.MostRobots = 200,
    arena: options.Arena = None,
    collision_diameter: options.CollisionDiameter = None,
    fix_swaps: options.FixSwaps = False,
    events: options.EventLog = None,
    script: options.EventScript = None,
    profile: options.EventBase = "gritsbot_x",
    trials: options.EventTrials = 16,
    jobs: options.Jobs = None,
    json_only: options.EstimatesAsJson = False,
) -> None:
    """Fit dead time, lag, gains, bias and noise to a log, and write them as a realism profile.

    What the log does not determine is left out and named, and so are poses that no robot can have
    had. Without poses, speed gain and delay can be fitted to the times of printed events. Exit
    code 0, or 2 with the reason, and no file, when the log cannot be read or determines nothing.

    [bold]Examples[/bold]

        posflock calibrate back/nine_robots.npy -o lab.toml

        posflock verify main.py --profile lab.toml

        posflock calibrate back/nine_robots.npy --dt 0.0352 -o lab.toml

        posflock calibrate back/nine_robots.npy -o lab.toml --resimulated again.npy

        posflock compare back/nine_robots.npy again.npy

        posflock calibrate --events back/printed.txt --script main.py -o lab.toml
    """
    from posflock_robotarium.flocking.errors import ParameterError

    if (log is None) == (events is None) or (events is None) != (script is None):
        raise ParameterError("give a log with commands, or --events with --script")
    if events is not None and script is not None:
        _calibrate_events(events, script, out, name, profile, trials, jobs, json_only)
    if log is not None:
        reading = reading_as(
            layout,
            columns,
            dt,
            array,
            drop_damaged,
            units,
            degrees,
            time,
            max_size,
            max_robots,
            arena,
            collision_diameter,
            fix_swaps,
        )
        _calibrate_log(log, out, name, pooled, resimulated, reading, step_times, json_only)


def _calibrate_log(
    log: Path,
    out: Path,
    name: str,
    pooled: bool,
    resimulated: Path | None,
    reading: "ReadOptions",
    step_times: Path | None,
    json_only: bool,
) -> None:
    from posflock_robotarium.calibration import (
        calibrate,
        read_commanded,
        resimulate,
        retimed,
        write_profile,
    )
    from posflock_robotarium.logs.convert import write_pose_log

    read = read_commanded(log, reading)
    given = _given_times(reading.dt, step_times, len(read.t))
    found = calibrate(read, given)
    write_profile(found.profile(name, pooled=pooled), out)
    if resimulated is not None:
        timed = read if given is None else retimed(read, given)
        write_pose_log(resimulate(timed, found.profile(name)), resimulated)
    if json_only:
        say(json.dumps(found.as_dict(), indent=1))
        return
    _print_estimates(found)
    say(f"wrote {out}")
    if resimulated is not None:
        say(f"wrote {resimulated}; overlay them with posflock compare {log} {resimulated}")


def _calibrate_events(
    events: Path,
    script: Path,
    out: Path,
    name: str,
    profile: str,
    trials: int,
    jobs: int | None,
    json_only: bool,
) -> None:
    from posflock_robotarium.calibration import write_profile
    from posflock_robotarium.event_calibration import calibrate_events
    from posflock_robotarium.verify.trials import Limits
    from rps_compat.profiles import load_profile

    limits = Limits() if jobs is None else Limits(jobs=jobs)

    def tell(done: int) -> None:
        if done % 5 == 0:
            say(f"{done} runs simulated", err=True)

    found = calibrate_events(events, script, load_profile(profile), trials, limits, tell)
    write_profile(found.profile(name), out)
    if json_only:
        say(json.dumps(found.as_dict(), indent=1))
        return
    fit = found.fit
    _print("speed gain", fit.gain, "")
    _print("dead time", fit.delay, "s")
    if fit.delay is None:
        say(f"not determined: the dead time; assumed {fit.assumed_delay:.3g} s")
    say(f"{'logged':>8} {'fitted':>8} {'seeds':>7}  event (seconds)")
    for row in fit.rows:
        say(f"{row.logged:8.1f} {row.fitted:8.1f} {row.spread:7.2f}  {row.name}")
    say(f"unexplained by the simulation: {fit.unexplained:.2f} s")
    if fit.scheduled:
        say(f"{fit.scheduled} more come at times that do not hang on the gain")
    if fit.unmatched:
        say(f"not in every simulated run: {'; '.join(fit.unmatched)}")
    say(f"wrote {out}")


def _given_times(
    dt: float | None, step_times: Path | None, rows: int
) -> "float | NDArray[np.float64] | None":
    """Return what the user knows of the steps, s."""
    from posflock_robotarium.calibration import read_step_times
    from posflock_robotarium.flocking.errors import ParameterError

    if step_times is None:
        return dt
    if dt is not None:
        raise ParameterError("--dt and --step-times both give the steps; leave one out")
    return read_step_times(step_times, rows)


def _print_estimates(found: "Calibration") -> None:
    say(f"{'times':<18} {found.times}")
    _print("dead time", found.dead_time, "s")
    _print("lag", found.lag, "s")
    for robot, (speed, turn, bias, offset) in enumerate(
        zip(found.speed_gain, found.turn_gain, found.turn_bias, found.heading_offset, strict=True)
    ):
        say(f"robot {robot}: speed gain {_said(speed)}, turn gain {_said(turn)}")
        say(f"         turn bias {_said(bias)} rad/s, heading offset {_said(offset)} rad")
    jitter, unexplained = found.jitter, found.disturbance
    _print("jitter, along", jitter.along, "m")
    _print("jitter, lateral", jitter.lateral, "m")
    _print("jitter, heading", jitter.heading, "rad")
    _print("unexplained speed", unexplained.speed, "m/s")
    _print("unexplained turn", unexplained.turn, "rad/s")
    for left_out in found.left_out:
        say(f"not determined: {left_out}")
    for warning in found.warnings:
        say(f"warning: {warning}", err=True)


def _print(what: str, estimate: "Estimate | None", unit: str) -> None:
    say(f"{what:<18} {_said(estimate)}" + ("" if estimate is None else f" {unit}"))


def _said(estimate: "Estimate | None") -> str:
    return "–" if estimate is None else str(estimate)
