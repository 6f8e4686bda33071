"""The ``posflock`` command: the list of commands, and how errors reach the terminal."""

import sys

import typer

from posflock_robotarium import __version__
from posflock_robotarium.commands import bundle, calibrate, paper, report, run, sweep, verify
from posflock_robotarium.commands.terminal import say
from posflock_robotarium.flocking.errors import PosflockError

app = typer.Typer(
    name="posflock",
    help="Simulate, verify, deploy and report Robotarium experiments.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"posflock {__version__}")
        raise typer.Exit


@app.callback()
def _posflock(
    version: bool = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Print the version."
    ),
) -> None:
    """Simulate, verify, deploy and report Robotarium experiments."""


# Each family of commands is registered here, in the order a researcher meets them; help shows
# them under these headings.
# What comes after a script's name is the script's own.
SCRIPT_ARGUMENTS = {"allow_extra_args": True, "allow_interspersed_args": False}
_WRITE, _SUBMIT, _ANALYSE, _STUDY = (
    "Write and run",
    "Submit",
    "Analyse what came back",
    "Study",
)
app.command(rich_help_panel=_WRITE, context_settings=SCRIPT_ARGUMENTS)(run.run)
app.command(rich_help_panel=_WRITE)(run.lint)
app.command(rich_help_panel=_SUBMIT)(verify.verify)
app.command(rich_help_panel=_SUBMIT)(bundle.bundle)
app.command(rich_help_panel=_SUBMIT)(bundle.rehearse)
app.command(rich_help_panel=_SUBMIT)(verify.profile)
for _command in (report.report, report.compare, report.replay, report.convert):
    app.command(rich_help_panel=_ANALYSE)(_command)
app.command(rich_help_panel=_ANALYSE)(calibrate.calibrate)
app.command(rich_help_panel=_STUDY)(paper.reproduce)
app.command(rich_help_panel=_STUDY)(sweep.sweep)


def main() -> None:
    """Run the command line; an error the user can mend is one plain line and exit code 2."""
    try:
        app()
    except PosflockError as error:
        say(f"posflock: {error}", err=True)
        sys.exit(2)
