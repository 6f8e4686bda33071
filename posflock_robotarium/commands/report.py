"""``posflock report``, ``compare``, ``replay`` and ``convert``: what logs can be turned into."""

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from posflock_robotarium.report import Analysis, ReadOptions

Logs = Annotated[
    list[Path],
    typer.Argument(help="Pose logs: ours, or .npy, .npz, .mat, CSV, text.", show_default=False),
]
Log = Annotated[Path, typer.Argument(help="Pose log of one run.", show_default=False)]
Out = Annotated[Path, typer.Option("-o", "--out", help="Folder for everything that is written.")]
Layout = Annotated[
    str | None,
    typer.Option(help="Axes of an array: T,3,N  3,N,T  T,N,3  T,3N  3N,T", show_default=False),
]
Columns = Annotated[
    str | None,
    typer.Option(
        help="Order of columns: state (x1…xN, y1…), robot (x1, y1, θ1, x2…), or all their names.",
        show_default=False,
    ),
]
Step = Annotated[
    float | None, typer.Option("--dt", help="Seconds between samples.", show_default=False)
]
Array = Annotated[
    str | None, typer.Option(help="Which array of a file is the poses.", show_default=False)
]
DropDamaged = Annotated[
    bool, typer.Option("--drop-damaged", help="Leave out rows that are not finite, as gaps.")
]
Joined = Annotated[bool, typer.Option("--join", help="The files are parts of one run.")]
Radius = Annotated[
    float | None,
    typer.Option(help="Neighbour radius in metres; the log's own by default.", show_default=False),
]
Window = Annotated[float, typer.Option(help="Seconds of the Savitzky-Golay window.")]
Slowest = Annotated[float, typer.Option(help="m/s up to which a robot has no direction.")]
Settle = Annotated[
    float | None,
    typer.Option(
        help="Seconds at the start that settled means leave out; 20 by default, none of a shorter "
        "run.",
        show_default=False,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the summary as JSON, nothing else.")]


def report(
    logs: Logs,
    out: Out = Path("report"),
    layout: Layout = None,
    columns: Columns = None,
    dt: Step = None,
    array: Array = None,
    drop_damaged: DropDamaged = False,
    join: Joined = False,
    radius: Radius = None,
    window: Window = 0.36,
    slowest: Slowest = 0.01,
    settle: Settle = None,
    latex: Annotated[bool, typer.Option("--latex", help="Also write table.tex.")] = False,
    figures: Annotated[bool, typer.Option(help="Draw figures/*.pdf and *.png.")] = True,
    json: Json = False,
) -> None:
    """Did it align, stay together and safe, and how sure are we? A page, figures, numbers.

    Writes report.html (one file, works offline), figures/, metrics.csv, summary.json and the
    analysis itself. Several logs are several runs: they are overlaid and averaged.

    Exit code 0 when the report was written, 2 when a log cannot be read.

    [bold]Examples[/bold]

        posflock report results/nine_robots.npy -o report

        posflock report poses.mat --dt 0.033 --radius 0.75 -o report --latex
    """
    from posflock_robotarium.report.outputs import write_report

    analyses = _analyse(
        logs,
        _options(layout, columns, dt, array, drop_damaged),
        radius,
        window,
        slowest,
        settle,
        join,
    )
    written = write_report(analyses, out, latex=latex, figures=figures)
    if json:
        _print_json(analyses)
        return
    _print_verdicts(analyses)
    typer.echo(f"{len(written)} files in {out}; open {written[0]}")


@contextlib.contextmanager
def _resimulated(runs: list[Path], profile: str | None) -> "Iterator[list[Path]]":
    """Give `runs`, and for each of them a log of its commands simulated under `profile`."""
    if profile is None:
        yield runs
        return
    import tempfile

    from posflock_robotarium.calibration import calibrate, read_commanded, resimulate
    from posflock_robotarium.logs.convert import write_pose_log
    from rps_compat.profiles import load_profile

    with tempfile.TemporaryDirectory(prefix="posflock-compare-") as folder:
        again = []
        for number, run in enumerate(runs):
            log = read_commanded(run)
            fitted = profile == "calibrated"
            chosen = calibrate(log).profile() if fitted else load_profile(profile)
            place = Path(folder) / str(number)
            place.mkdir()
            target = place / f"{run.stem}_resimulated"
            again.append(write_pose_log(resimulate(log, chosen), target))
        yield [*runs, *again]


def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(help="Logs, or saved analyses (.analysis.npz).", show_default=False),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", help="Also write the overlaid report here.", show_default=False
        ),
    ] = None,
    labels: Annotated[
        str | None,
        typer.Option(
            help="What each run counts as, in order: simulation,testbed,… Runs that share a label "
            "are averaged.",
            show_default=False,
        ),
    ] = None,
    resimulate: Annotated[
        str | None,
        typer.Option(
            help="Add each log's commands, simulated under this realism profile: its name, a TOML "
            "file, or 'calibrated' to fit one to the log first.",
            show_default=False,
        ),
    ] = None,
    layout: Layout = None,
    columns: Columns = None,
    dt: Step = None,
    array: Array = None,
    drop_damaged: DropDamaged = False,
    radius: Radius = None,
    window: Window = 0.36,
    slowest: Slowest = 0.01,
    settle: Settle = None,
    json: Json = False,
) -> None:
    """Put runs side by side: every number, mean and 95 % interval, differences.

    Exit code 0, or 2 when a run cannot be read.

    [bold]Examples[/bold]

        posflock compare simulated.npy returned.npy --labels simulation,testbed

        posflock compare seed-*/nine_robots.npy -o comparison

        posflock compare returned.npy --resimulate calibrated -o comparison
    """
    from posflock_robotarium.alignment.comparison import compare as compare_runs

    with _resimulated(runs, resimulate) as logs:
        reading = _options(layout, columns, dt, array, drop_damaged)
        analyses = _analyse(logs, reading, radius, window, slowest, settle, False)
    comparison = compare_runs(analyses, labels.split(",") if labels else None)
    if json:
        import json as writer

        typer.echo(writer.dumps(comparison.summary(), indent=1, ensure_ascii=False))
    else:
        from posflock_robotarium.report.tables import comparison_table

        for line in comparison_table(comparison):
            typer.echo(line)
    if out is not None:
        from posflock_robotarium.report.outputs import write_report

        written = write_report(analyses, out, labels=comparison.labels)
        typer.echo(f"{len(written)} files in {out}; open {written[0]}", err=json)


def replay(
    log: Log,
    video: Annotated[
        Path, typer.Option("--video", help="The film: .mp4 or .gif.", show_default=False)
    ],
    fps: Annotated[
        float | None,
        typer.Option(help="Frames a second; 20 for .mp4, 12.5 for .gif.", show_default=False),
    ] = None,
    speed: Annotated[float, typer.Option(help="Seconds of the run a second of film.")] = 1.0,
    layout: Layout = None,
    columns: Columns = None,
    dt: Step = None,
    array: Array = None,
    drop_damaged: DropDamaged = False,
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

    recording = read(log, _options(layout, columns, dt, array, drop_damaged))
    with progress("filming") as told:
        write_video(recording, video, fps=fps, speed=speed, robot=recording.robot, progress=told)
    typer.echo(f"wrote {video}")


def convert(
    log: Log,
    to: Annotated[
        str,
        typer.Option(
            "--to",
            help="npy (a pose log), mat, csv, npz or mcap (for Foxglove).",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", help="The file; beside the log by default.", show_default=False
        ),
    ] = None,
    layout: Layout = None,
    columns: Columns = None,
    dt: Step = None,
    array: Array = None,
    drop_damaged: DropDamaged = False,
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
    typer.echo(
        f"wrote {write(read(log, _options(layout, columns, dt, array, drop_damaged)), target)}"
    )


def _options(
    layout: str | None,
    columns: str | None,
    dt: float | None,
    array: str | None,
    drop_damaged: bool,
) -> "ReadOptions":
    from posflock_robotarium.report import ReadOptions

    return ReadOptions(layout, columns, dt, array, drop_damaged)


def _analyse(
    logs: list[Path],
    reading: "ReadOptions",
    radius: float | None,
    window: float,
    slowest: float,
    settle: float | None,
    join: bool,
) -> list["Analysis"]:
    from posflock_robotarium.alignment.analysis import is_analysis
    from posflock_robotarium.alignment.comparison import distinctly_named
    from posflock_robotarium.commands.terminal import progress
    from posflock_robotarium.report import AnalysisOptions, analyse, load, read_parts

    options = AnalysisOptions(radius=radius, window=window, slowest=slowest, settle=settle)
    if join:
        return [analyse(read_parts(logs, reading), options)]
    analyses = []
    with progress("analysing") as told:
        for done, log in enumerate(logs, start=1):
            saved = is_analysis(log)
            analyses.append(load(log) if saved else analyse(log, options, read_options=reading))
            told(done, len(logs))
    return distinctly_named(analyses)


def _print_json(analyses: list["Analysis"]) -> None:
    import json

    summaries = [analysis.summary() for analysis in analyses]
    typer.echo(
        json.dumps(summaries[0] if len(summaries) == 1 else summaries, indent=1, ensure_ascii=False)
    )


def _print_verdicts(analyses: list["Analysis"]) -> None:
    for analysis in analyses:
        typer.echo(f"{analysis.name}")
        for verdict in analysis.verdicts:
            typer.echo(f"  {verdict.mark:8s} {verdict.question} {verdict.answer}")
            if verdict.because and verdict.mark != "good":
                typer.echo(f"           {verdict.because}")
