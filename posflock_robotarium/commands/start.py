"""``posflock demo``, ``examples`` and ``new``: what runs with nothing but the package."""

from pathlib import Path

from posflock_robotarium.commands import options
from posflock_robotarium.commands.terminal import say


def demo(
    out: options.DemoFolder = Path("results"),
    seed: options.StartSeed = 0,
    duration: options.DemoSeconds = 120.0,
) -> None:
    """Run the paper's experiment with nine robots: pose log, figures and summary in seconds.

    Exit code 0, or 2 with the reason where it cannot run.

    [bold]Examples[/bold]

        posflock demo

        posflock demo --seed 3 --duration 60 -o results/seed3
    """
    import runpy
    import sys
    from unittest import mock

    from posflock_robotarium.examples import NINE_ROBOTS, examples_folder
    from posflock_robotarium.flocking.errors import ParameterError

    if not 0 < duration < float("inf"):
        raise ParameterError(f"--duration {duration:g}: expected seconds, more than 0")
    script = examples_folder() / NINE_ROBOTS
    words = ["--seed", str(seed), "--duration", str(duration), "--out", str(out)]
    with mock.patch.object(sys, "argv", [str(script), *words]):
        runpy.run_path(str(script), run_name="__main__")
    say(f"next: posflock report {out / 'nine_robots.npy'} -o report; posflock examples")


def examples(out: options.ExamplesFolder = Path("experiments")) -> None:
    """Copy the scripts, studies and the notebook that come along into a folder.

    What is there already is never overwritten. Exit code 0, or 2 where a file of the same name
    has another content.

    [bold]Examples[/bold]

        posflock examples

        posflock examples -o first-steps
    """
    from posflock_robotarium.examples import NINE_ROBOTS, copy_examples

    for path in copy_examples(out):
        say(str(path))
    say(f"next: posflock verify {out / NINE_ROBOTS}")


def new(
    name: options.NewName,
    kind: options.NewKind = "flocking",
    out: options.NewFolder = Path(),
) -> None:
    """Write a script of your own to begin with: it runs, logs itself and passes verify.

    A folder of this name gets the script, a file with its metric and a README. Exit code 0, or 2
    where the name cannot be a script's or the folder is there already.

    [bold]Examples[/bold]

        posflock new my_flock

        posflock new my_cover --kind coverage -o experiments

        posflock new my_team --kind policy
    """
    from posflock_robotarium.flocking.errors import ParameterError
    from posflock_robotarium.new_script import ExperimentKind, write_script

    known = [experiment.value for experiment in ExperimentKind]
    if kind not in known:
        raise ParameterError(f"--kind {kind!r} is none of {', '.join(known)}")
    script, *others = write_script(name, ExperimentKind(kind), out)
    for path in (script, *others):
        say(str(path))
    say(f"next: cd {script.parent}; posflock verify {script.name}")
