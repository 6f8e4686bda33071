"""``posflock replay`` and ``posflock convert``: a log as a film, or as another tool's file."""

from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.commands import options
from posflock_robotarium.commands.reading import reading as reading_as
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    from posflock_robotarium.report import Run


def replay(
    log: options.Log,
    video: options.Film,
    fps: options.FramesPerSecond = None,
    speed: options.Speed = 1.0,
    layout: options.Layout = None,
    columns: options.Columns = None,
    dt: options.Step = None,
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
    json: options.FilmAsJson = False,
) -> None:
    """Film a run from above.

    Exit code 0, or 2 with the reason when the log cannot be read.

    [bold]Examples[/bold]

        posflock replay results/nine_robots.npy --video run.mp4

        posflock replay results/nine_robots.npy --video run.gif --speed 8
    """
    from posflock_robotarium.commands.terminal import progress
    from posflock_robotarium.report import read
    from posflock_robotarium.report.video import write_video

    recording = read(
        log,
        reading_as(
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
        ),
    )
    with progress("filming") as told:
        write_video(recording, video, fps=fps, speed=speed, robot=recording.robot, progress=told)
    _print_written(log, video, recording, json)


def convert(
    log: options.Log,
    to: options.Format,
    out: options.ConvertedFile = None,
    layout: options.Layout = None,
    columns: options.Columns = None,
    dt: options.Step = None,
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
    json: options.WrittenAsJson = False,
) -> None:
    """Write a log in another tool's format.

    Exit code 0, or 2 with the reason when the log cannot be read.

    [bold]Examples[/bold]

        posflock convert results/nine_robots.npy --to mcap -o nine_robots.mcap
    """
    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.logs.convert import WRITERS
    from posflock_robotarium.logs.convert import convert as write
    from posflock_robotarium.report import read

    if to not in WRITERS:
        raise ParameterError(f"--to {to!r} is none of {', '.join(WRITERS)}")
    target = out or log.with_suffix(f".{to}")
    if target.suffix != f".{to}":
        raise ParameterError(f"--out {target} does not end in .{to}")
    if target.exists() and target.resolve() == log.resolve():
        raise ParameterError(f"{target} is the log itself; name another file with --out")
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
    recording = read(log, reading)
    _print_written(log, write(recording, target), recording, json)


def _print_written(log: Path, path: Path, recording: "Run", as_json: bool) -> None:
    """Tell the file that a log became; as JSON, with what is in it."""
    if not as_json:
        say(f"wrote {path}")
        return
    import json

    steps, _, robots = recording.poses.shape
    told = {"log": str(log), "file": str(path), "bytes": path.stat().st_size}
    seconds = float(recording.t[-1] - recording.t[0]) if steps else None
    say(json.dumps(told | {"rows": steps, "robots": robots, "seconds": seconds}, indent=1))
