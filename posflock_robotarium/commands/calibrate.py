"""``posflock calibrate``: from a returned log to a realism profile."""

from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from posflock_robotarium.calibration import Calibration
    from posflock_robotarium.calibration.estimate import Estimate


def calibrate(
    log: options.CommandedLog,
    out: options.FittedProfile = Path("calibrated.toml"),
    name: options.ProfileName = "calibrated",
    pooled: options.Pooled = False,
    resimulate: options.ResimulatedLog = None,
    dt: options.MeanStep = None,
    step_times: options.StepTimes = None,
    layout: options.Layout = None,
    columns: options.Columns = None,
    array: options.Array = None,
    drop_damaged: options.DropDamaged = False,
    json_only: options.EstimatesAsJson = False,
) -> None:
    """Fit dead time, lag, gains, bias and noise to a log, and write them as a realism profile.

    What the log does not determine is left out and named, and so are poses that no robot can have
    had. Exit code 0, or 2 with the reason, and no file, when the log cannot be read or determines
    nothing.

    [bold]Examples[/bold]

        posflock calibrate back/nine_robots.npy -o lab.toml

        posflock verify main.py --profile lab.toml

        posflock calibrate back/nine_robots.npy --dt 0.0352 -o lab.toml

        posflock calibrate back/nine_robots.npy -o lab.toml --resimulate again.npy

        posflock compare back/nine_robots.npy again.npy
    """
    from posflock_robotarium.calibration import calibrate as fit
    from posflock_robotarium.calibration import read_commanded, retimed, write_profile
    from posflock_robotarium.calibration import resimulate as simulate
    from posflock_robotarium.logs.convert import write_pose_log
    from posflock_robotarium.logs.readers import ReadOptions

    read = read_commanded(log, ReadOptions(layout, columns, dt, array, drop_damaged))
    given = _given_times(dt, step_times, len(read.t))
    found = fit(read, given)
    write_profile(found.profile(name, pooled=pooled), out)
    if resimulate is not None:
        timed = read if given is None else retimed(read, given)
        write_pose_log(simulate(timed, found.profile(name)), resimulate)
    if json_only:
        import json

        say(json.dumps(found.as_dict(), indent=1))
        return
    _print_estimates(found)
    say(f"wrote {out}")
    if resimulate is not None:
        say(f"wrote {resimulate}; overlay them with posflock compare {log} {resimulate}")


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
    typer.echo(f"{'times':<18} {found.times}")
    _print("dead time", found.dead_time, "s")
    _print("lag", found.lag, "s")
    for robot, (speed, turn, bias, offset) in enumerate(
        zip(found.speed_gain, found.turn_gain, found.turn_bias, found.heading_offset, strict=True)
    ):
        typer.echo(f"robot {robot}: speed gain {_said(speed)}, turn gain {_said(turn)}")
        typer.echo(f"         turn bias {_said(bias)} rad/s, heading offset {_said(offset)} rad")
    jitter, unexplained = found.jitter, found.disturbance
    _print("jitter, along", jitter.along, "m")
    _print("jitter, lateral", jitter.lateral, "m")
    _print("jitter, heading", jitter.heading, "rad")
    _print("unexplained speed", unexplained.speed, "m/s")
    _print("unexplained turn", unexplained.turn, "rad/s")
    for left_out in found.left_out:
        typer.echo(f"not determined: {left_out}")
    for warning in found.warnings:
        typer.echo(f"warning: {warning}", err=True)


def _print(what: str, estimate: "Estimate | None", unit: str) -> None:
    typer.echo(f"{what:<18} {_said(estimate)}" + ("" if estimate is None else f" {unit}"))


def _said(estimate: "Estimate | None") -> str:
    return "–" if estimate is None else str(estimate)
