"""``posflock report`` and ``compare``: what logs tell, alone and beside each other."""

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from posflock_robotarium.commands import options, question_options
from posflock_robotarium.commands.reading import reading as reading_as
from posflock_robotarium.commands.terminal import say

if TYPE_CHECKING:
    from collections.abc import Iterator

    from posflock_robotarium.alignment.comparison import Comparison
    from posflock_robotarium.report import Analysis, AnalysisOptions, ReadOptions


def report(
    logs: options.Logs,
    out: options.ReportFolder = Path("report"),
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
    join: options.Joined = False,
    radius: options.Radius = None,
    window: options.Window = 0.36,
    slowest: options.Slowest = 0.01,
    transient: options.Transient = None,
    drive: options.Drive = None,
    metric: question_options.OwnMetrics = None,
    questions: question_options.QuestionsAsked = None,
    target: question_options.TargetsAsked = None,
    latex: options.Latex = False,
    figures: options.Figures = True,
    json: options.SummaryAsJson = False,
) -> None:
    """Did it align, stay together and safe, and how sure are we? A page, figures, numbers.

    Writes report.html (one file, works offline), figures/, metrics.csv, summary.json and the
    analysis itself. Several logs are several runs: they are overlaid and averaged.

    Exit code 0 when the report was written, 2 when a log cannot be read.

    [bold]Examples[/bold]

        posflock report results/nine_robots.npy -o report

        posflock report poses.mat --dt 0.033 --radius 0.75 -o report --latex

        posflock report poses.npy --metric my_metrics.py:error --target 'error < 0.05 m always'
    """
    from posflock_robotarium.alignment.own_metrics import own_metrics
    from posflock_robotarium.report.outputs import write_report

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
    judged = _judged(radius, window, slowest, transient, drive, questions, target)
    with own_metrics(metric or ()):
        analyses = _analyse(logs, reading, judged, join, bool(metric))
        written = write_report(analyses, out, latex=latex, figures=figures)
    if json:
        _print_json(analyses)
        return
    _print_verdicts(analyses)
    say(f"{len(written)} files in {out}; open {written[0]}")


@contextlib.contextmanager
def _resimulated(runs: list[Path], profile: str | None) -> "Iterator[list[Path]]":
    """Give `runs`, and for each of them a log of its commands simulated under `profile`."""
    if profile is None:
        yield runs
        return
    from posflock_robotarium.calibration import calibrate, read_commanded, resimulate
    from posflock_robotarium.logs.convert import write_pose_log
    from rps_compat.containment.kept import KeptFolder
    from rps_compat.profiles import load_profile

    with KeptFolder("compare") as folder:
        again = []
        for number, run in enumerate(runs):
            log = read_commanded(run)
            fitted = profile == "calibrated"
            chosen = calibrate(log).profile() if fitted else load_profile(profile)
            place = folder / str(number)
            place.mkdir()
            target = place / f"{run.stem}_resimulated"
            again.append(write_pose_log(resimulate(log, chosen), target))
        yield [*runs, *again]


def compare(
    runs: options.Runs,
    out: options.OverlaidReport = None,
    labels: options.Labels = None,
    resimulate: options.ResimulatedUnder = None,
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
    radius: options.Radius = None,
    window: options.Window = 0.36,
    slowest: options.Slowest = 0.01,
    transient: options.Transient = None,
    drive: options.Drive = None,
    metric: question_options.OwnMetrics = None,
    questions: question_options.QuestionsAsked = None,
    target: question_options.TargetsAsked = None,
    reference: question_options.ReferenceRun = None,
    delta: question_options.ReferenceDelta = 1.0,
    reference_offset: question_options.ReferenceOffset = 0.0,
    json: options.SummaryAsJson = False,
) -> None:
    """Put runs side by side: every number, mean and 95 % interval, differences.

    Exit code 0, or 2 when a run cannot be read.

    [bold]Examples[/bold]

        posflock compare simulated.npy returned.npy --labels simulation,testbed

        posflock compare seed-*/nine_robots.npy -o comparison

        posflock compare returned.npy --resimulate calibrated -o comparison

        posflock compare returned.npy --reference simulated.npy
    """
    from posflock_robotarium.alignment.comparison import compare as compare_runs
    from posflock_robotarium.alignment.comparison import labelled, with_errors
    from posflock_robotarium.alignment.own_metrics import own_metrics
    from posflock_robotarium.report.outputs import write_report

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
    judged = _judged(radius, window, slowest, transient, drive, questions, target)
    named = labels.split(",") if labels else None
    with own_metrics(metric or ()), _resimulated(runs, resimulate) as logs:
        compared = logs if reference is None else [reference, *logs]
        analyses = _analyse(compared, reading, judged, False, bool(metric))
        if named is not None and len(named) == len(compared):
            analyses = labelled(analyses, named)
        if reference is not None and (named is None or len(named) < len(compared)):
            named = ["reference", *(named or ["runs"] * len(logs))]
        comparison = compare_runs(analyses, named)
        if reference is not None:
            comparison = with_errors(comparison, delta=delta, offset=reference_offset)
        if out is not None:
            written = write_report(analyses, out, comparison=comparison)
    _print_comparison(comparison, json)
    if out is not None:
        say(f"{len(written)} files in {out}; open {written[0]}", err=json)


def _judged(
    radius: float | None,
    window: float,
    slowest: float,
    transient: float | None,
    drive: float | None,
    questions: str | None,
    targets: list[str] | None,
) -> "AnalysisOptions":
    from posflock_robotarium.alignment.questions import Questions
    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.report import AnalysisOptions

    known = [each.value for each in Questions]
    if questions is not None and questions not in known:
        raise ParameterError(f"--questions {questions!r} is none of {', '.join(known)}")
    return AnalysisOptions(
        radius=radius,
        window=window,
        slowest=slowest,
        transient=transient,
        drive=drive,
        questions=None if questions is None else Questions(questions),
        targets=tuple(targets or ()),
    )


def _analyse(
    logs: list[Path],
    reading: "ReadOptions",
    judged: "AnalysisOptions",
    join: bool,
    own: bool,
) -> list["Analysis"]:
    from posflock_robotarium.alignment.analysis import is_analysis, judged_again
    from posflock_robotarium.alignment.comparison import distinctly_named
    from posflock_robotarium.commands.terminal import progress
    from posflock_robotarium.report import analyse, load, read_parts

    if join:
        return [analyse(read_parts(logs, reading), judged)]
    asked = own or bool(judged.questions or judged.targets)
    analyses = []
    with progress("analysing") as told:
        for done, log in enumerate(logs, start=1):
            if is_analysis(log):
                saved = load(log)
                analyses.append(judged_again(saved, judged) if asked else saved)
            else:
                analyses.append(analyse(log, judged, read_options=reading))
            told(done, len(logs))
    return distinctly_named(analyses)


def _print_json(analyses: list["Analysis"]) -> None:
    import json

    summaries = [analysis.summary() for analysis in analyses]
    say(
        json.dumps(summaries[0] if len(summaries) == 1 else summaries, indent=1, ensure_ascii=False)
    )


def _print_comparison(comparison: "Comparison", as_json: bool) -> None:
    if as_json:
        import json

        say(json.dumps(comparison.summary(), indent=1, ensure_ascii=False))
        return
    from posflock_robotarium.report.tables import comparison_table, reference_table

    for line in (*comparison_table(comparison), *reference_table(comparison)):
        say(line)


def _print_verdicts(analyses: list["Analysis"]) -> None:
    from posflock_robotarium.alignment.verdicts import Mark

    for analysis in analyses:
        say(f"{analysis.name}")
        say(f"  asked    {analysis.asked.questions}, {analysis.asked.reason}")
        for verdict in analysis.verdicts:
            say(f"  {verdict.mark:8} {verdict.question} {verdict.answer}")
            if verdict.because and verdict.mark is not Mark.GOOD:
                say(f"           {verdict.because}")
