"""Arguments and options of the commands: each name, help and range once, by what it is about.

A command writes ``layout: Layout = None``; what two commands share stands here, and so does what
would hide a command's work behind a table of options.
"""

from pathlib import Path
from typing import Annotated

import typer

# --- What several commands ask ----------------------------------------------------------------

Script = Annotated[Path, typer.Argument(help="The experiment's main file.", show_default=False)]
Profile = Annotated[
    str, typer.Option(help="Imperfections: ideal, gritsbot_x, gternal, harsh, or a TOML file.")
]
TestbedProfile = Annotated[
    str | None,
    typer.Option(
        "--profile",
        help="Imperfections: ideal, gritsbot_x, gternal, harsh, or a TOML file. Default: those of "
        "the generation's robots, gritsbot_x for 1 and gternal for 2.",
    ),
]
Processes = Annotated[
    int | None, typer.Option("--jobs", min=1, help="Processes; by default one a processor.")
]

# --- Logs and how to read them ------------------------------------------------------------------

Logs = Annotated[
    list[Path],
    typer.Argument(
        help="Pose logs: ours, or .npy, .npz, .mat, .mcap, CSV, text, ROS CSV, TUM, EuRoC, KITTI, "
        "MRCLAM, Motive CSV, Vicon CSV, ROS 2 bag.",
        show_default=False,
    ),
]
Log = Annotated[Path, typer.Argument(help="Pose log of one run.", show_default=False)]
Runs = Annotated[
    list[Path], typer.Argument(help="Logs, or saved analyses (.analysis.npz).", show_default=False)
]
Layout = Annotated[
    str | None,
    typer.Option(
        help="Axes of an array: T,3,N  3,N,T  T,N,3  T,3N  3N,T  T,5N  5N,T", show_default=False
    ),
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
LengthUnit = Annotated[
    str | None,
    typer.Option("--units", help="What lengths are in: m, cm or mm.", show_default=False),
]
Degrees = Annotated[bool, typer.Option("--degrees", help="Angles are in degrees.")]
FileClock = Annotated[
    str,
    typer.Option(
        "--time",
        help="file; none: count samples --dt apart instead of the file's own times; real: the "
        "real time that our pose log holds beside its steps.",
    ),
]
Array = Annotated[
    str | None, typer.Option(help="Which array of a file is the poses.", show_default=False)
]
DropDamaged = Annotated[
    bool, typer.Option("--drop-damaged", help="Leave out rows that are not finite, as gaps.")
]
LargestLog = Annotated[
    float, typer.Option("--max-size", help="MB of memory that a log may take.", show_default=True)
]
MostRobots = Annotated[int, typer.Option("--max-robots", help="Robots that a log may have.")]
Arena = Annotated[
    str | None,
    typer.Option(
        "--arena",
        metavar="LEFT,RIGHT,BOTTOM,TOP",
        help="The arena's edges in metres, whatever the log says: --arena=-1.6,1.6,-1,1",
        show_default=False,
    ),
]
CollisionDiameter = Annotated[
    float | None,
    typer.Option(
        "--collision-diameter",
        metavar="METRES",
        help="Nearer than this robots collide, whatever the log says.",
        show_default=False,
    ),
]
FixSwaps = Annotated[
    bool,
    typer.Option("--fix-swaps", help="Give robots that are taken for each other their own poses."),
]
Joined = Annotated[bool, typer.Option("--join", help="The files are parts of one run.")]

# --- How to analyse them ------------------------------------------------------------------------

Radius = Annotated[
    float | None,
    typer.Option(help="Neighbour radius in metres; the log's own by default.", show_default=False),
]
Window = Annotated[float, typer.Option(help="Seconds of the Savitzky-Golay window.")]
Slowest = Annotated[float, typer.Option(help="m/s up to which a robot has no direction.")]
Transient = Annotated[
    float | None,
    typer.Option(
        help="Seconds of the transient, left out of settled means; 20 by default, 0 for a shorter "
        "run.",
        show_default=False,
    ),
]
Drive = Annotated[
    float | None,
    typer.Option(
        help="Seconds at the start in which robots drive to their places: marked, and left out of "
        "settled means; what the log says by default.",
        show_default=False,
    ),
]
ReportFolder = Annotated[
    Path, typer.Option("-o", "--out", help="Folder for everything that is written.")
]
Latex = Annotated[bool, typer.Option("--latex", help="Also write table.tex.")]
Figures = Annotated[bool, typer.Option(help="Draw figures/*.pdf and *.png.")]
SummaryAsJson = Annotated[
    bool, typer.Option("--json", help="Print the summary as JSON, nothing else.")
]
OverlaidReport = Annotated[
    Path | None,
    typer.Option("-o", "--out", help="Also write the overlaid report here.", show_default=False),
]
Labels = Annotated[
    str | None,
    typer.Option(
        help="What each run counts as, in order: simulation,testbed,… Runs that share a label "
        "are averaged.",
        show_default=False,
    ),
]
ResimulatedUnder = Annotated[
    str | None,
    typer.Option(
        "--resimulate",
        help="Add each log's commands, simulated under this realism profile: its name, a TOML "
        "file, or 'calibrated' to fit one to the log first.",
        show_default=False,
    ),
]

# --- Films, other formats, profiles -------------------------------------------------------------

Film = Annotated[Path, typer.Option("--video", help="The film: .mp4 or .gif.", show_default=False)]
FramesPerSecond = Annotated[
    float | None,
    typer.Option(help="Frames a second; 20 for .mp4, 12.5 for .gif.", show_default=False),
]
Speed = Annotated[float, typer.Option(help="Seconds of the run a second of film.")]
Format = Annotated[
    str,
    typer.Option(
        "--to", help="npy (a pose log), mat, csv, npz or mcap (for Foxglove).", show_default=False
    ),
]
FilmAsJson = Annotated[bool, typer.Option("--json", help="Print what was filmed as JSON.")]
ProfileAsJson = Annotated[bool, typer.Option("--json", help="Print it as JSON.")]
ConvertedFile = Annotated[
    Path | None,
    typer.Option("-o", "--out", help="The file; beside the log by default.", show_default=False),
]
CommandedLog = Annotated[
    Path | None,
    typer.Argument(
        help="A pose log, or another file with poses, times and commands. None with --events.",
        show_default=False,
    ),
]
EventLog = Annotated[
    Path | None,
    typer.Option(
        "--events",
        help="Instead: what a run on the testbed printed, with times, as '[t= 50.3s] at gate'.",
        show_default=False,
    ),
]
EventScript = Annotated[
    Path | None,
    typer.Option("--script", help="The script that printed the events.", show_default=False),
]
EventBase = Annotated[
    str,
    typer.Option(
        "--profile", help="With --events, what else robots are like: a profile or a TOML file."
    ),
]
EventTrials = Annotated[
    int,
    typer.Option(
        "--trials", "-n", min=8, help="With --events, runs to simulate around each guess."
    ),
]
MeanStep = Annotated[
    float | None,
    typer.Option(
        "--dt",
        help="Mean seconds between rows, where the log's own times are nominal or useless.",
        show_default=False,
    ),
]
StepTimes = Annotated[
    Path | None,
    typer.Option(
        help="Text, CSV or .npy with the seconds from row to row, or of each row, which then "
        "replace the log's times.",
        show_default=False,
    ),
]
FittedProfile = Annotated[Path, typer.Option("--out", "-o", help="The realism profile to write.")]
ProfileName = Annotated[str, typer.Option(help="What the profile is to be called.")]
Pooled = Annotated[
    bool, typer.Option("--pooled", help="Distributions over robots, for any number of them.")
]
ResimulatedLog = Annotated[
    Path | None,
    typer.Option(
        "--resimulated",
        help="Also write a log here: the same commands, simulated with the profile.",
    ),
]
EstimatesAsJson = Annotated[bool, typer.Option("--json", help="Print all estimates as JSON.")]

# --- First steps --------------------------------------------------------------------------------

DemoFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder for what the run leaves.")]
StartSeed = Annotated[int, typer.Option(min=0, help="Of the starting poses.")]
DemoSeconds = Annotated[float, typer.Option("--duration", "-d", help="Seconds of the run.")]
ExamplesFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder for the copies.")]
NewName = Annotated[str, typer.Argument(help="Of the script, as Python has names: my_flock.")]
NewKind = Annotated[
    str,
    typer.Option(metavar="KIND", help="flocking, formation, coverage, swarm-swap or policy."),
]
NewFolder = Annotated[
    Path,
    typer.Option(
        "-o", "--out", help="Where its folder is made; here by default.", show_default=False
    ),
]

# --- Running a script ---------------------------------------------------------------------------

ScriptAndArguments = Annotated[Path, typer.Argument(help="The script; what follows it is its own.")]
FoundGeneration = Annotated[
    int | None, typer.Option(min=1, max=2, help="Of the API. Default: found in the source.")
]
Headless = Annotated[
    bool | None,
    typer.Option("--headless/--window", help="No window, no waiting. Default without a display."),
]
Initial = Annotated[
    str,
    typer.Option(
        help="How robots come to their initial conditions: published, exact, arrive (within "
        "the testbed's 5 cm and 0.2 rad) or drive."
    ),
]
ScriptSeed = Annotated[
    int | None,
    typer.Option(
        help="Seed of Python's and numpy's global generators: on one machine, the same bytes."
    ),
]
StopAfter = Annotated[float | None, typer.Option(help="Stop the script after so many seconds.")]
Answers = Annotated[
    list[str] | None, typer.Option("--input", help="An answer to input(); repeatable.")
]
Snapshots = Annotated[str, typer.Option(help="Save the figure at these seconds: 0,10,end")]
RunFilm = Annotated[
    Path | None, typer.Option(help="Film the run, in the output folder: run.mp4 or .gif")
]
RunFolder = Annotated[
    Path | None,
    typer.Option("-o", "--out", help="Folder for log, report, pictures. Default runs/SCRIPT."),
]
ReportAsJson = Annotated[bool, typer.Option("--json", help="Print the report as JSON.")]

# --- Verifying and submitting -------------------------------------------------------------------

Trials = Annotated[
    int | None,
    typer.Option(
        "--trials", "-n", help="Runs with imperfections. Default: 20, with --effect 5 each."
    ),
]
Declared = Annotated[
    float | None,
    typer.Option("--duration", "-d", help="Seconds you will declare at submission, if known."),
]
TestbedGeneration = Annotated[
    int, typer.Option(help="Generation of the API on the testbed, 1 or 2.")
]
FirstSeed = Annotated[int, typer.Option(min=0, help="First seed; the others count up from it.")]
VerifyFolder = Annotated[
    Path | None, typer.Option("--out", "-o", help="Folder for verify.html and verify.json.")
]
VerifyAsJson = Annotated[bool, typer.Option("--json", help="Print verify.json, and nothing else.")]
Effects = Annotated[
    list[str] | None,
    typer.Option(
        "--effect", help="Instead: run under this imperfection alone; 'each' for each in turn."
    ),
]
Jobs = Annotated[
    int | None, typer.Option(min=1, help="Trials at a time. Default: one a processor.")
]
Stall = Annotated[float, typer.Option(help="Seconds without a step after which a trial hangs.")]
TrialSeconds = Annotated[float, typer.Option(help="Seconds that a trial may take.")]
TrialMemory = Annotated[float, typer.Option(help="GiB that a trial may allocate.")]
TrialDisk = Annotated[float, typer.Option(help="GiB that a trial may write.")]

BundleFolder = Annotated[
    Path,
    typer.Option(
        "--out", "-o", help="Folder to write: new, empty or a bundle.", show_default=False
    ),
]
DataFiles = Annotated[
    list[Path] | None, typer.Option(help="A data file to take along; may be repeated.")
]
RunOnce = Annotated[
    bool, typer.Option(help="Run the script once to learn what to enter for robots and duration.")
]
LargestUpload = Annotated[
    float | None, typer.Option(help="Largest upload in MiB. Default: no limit.")
]
WrittenAsJson = Annotated[bool, typer.Option("--json", help="Print what was written as JSON.")]

Bundled = Annotated[
    Path, typer.Argument(help="A bundle, made by `posflock bundle`.", show_default=False)
]
ReturnFolder = Annotated[
    Path, typer.Option("--out", "-o", help="New or empty folder for what comes back.")
]
DeclaredDuration = Annotated[
    float, typer.Option("--duration", "-d", help="Declared duration, seconds.")
]
TestbedSeed = Annotated[int, typer.Option(help="Of everything random that is the testbed's.")]
Generation = Annotated[int, typer.Option(help="Generation of the API, 1 or 2.")]
TestbedInitial = Annotated[
    str, typer.Option(help="arrive (within 5 cm and 0.2 rad), exact, or drive.")
]
RealSeconds = Annotated[float, typer.Option(help="Seconds of real time it may take.")]
WithReport = Annotated[bool, typer.Option(help="Open returned pose logs with posflock report.")]
OutcomeAsJson = Annotated[bool, typer.Option("--json", help="Print the outcome as JSON.")]

# --- Studies ------------------------------------------------------------------------------------

StudyFile = Annotated[Path, typer.Argument(help="A study file, TOML.")]
StudyFolder = Annotated[
    Path | None,
    typer.Option("--out", "-o", help="Folder; by default results/ and the study's name."),
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Send the runs to this Dask scheduler.")
]
ClusterAuthority = Annotated[
    Path | None,
    typer.Option(
        "--tls-ca",
        help="For tls://: certificate (PEM) of who signed the cluster's; by default what Dask's "
        "configuration says.",
        show_default=False,
    ),
]
ClientCertificate = Annotated[
    Path | None,
    typer.Option("--tls-cert", help="This client's certificate (PEM).", show_default=False),
]
ClientKey = Annotated[
    Path | None, typer.Option("--tls-key", help="Its private key (PEM).", show_default=False)
]
RetryFailed = Annotated[
    bool, typer.Option("--retry-failed", help="Compute runs that failed once more.")
]
DoneAsJson = Annotated[bool, typer.Option("--json", help="Print what was done as JSON.")]
