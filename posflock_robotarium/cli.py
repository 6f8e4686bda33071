"""The ``posflock`` command: the list of commands, and how errors reach the terminal."""

import sys

import typer

from posflock_robotarium import __version__
from posflock_robotarium.commands import (
    bundle,
    calibrate,
    convert,
    paper,
    report,
    run,
    start,
    sweep,
    verify,
    watch,
)
from posflock_robotarium.commands.argument_order import RunPage
from posflock_robotarium.commands.help_pages import CommandPage, GroupPage
from posflock_robotarium.commands.streams import as_a_shell_expects
from posflock_robotarium.commands.terminal import say
from posflock_robotarium.flocking.errors import PosflockError

app = typer.Typer(
    name="posflock",
    help="Simulate, verify, deploy and report Robotarium experiments.",
    cls=GroupPage,
    no_args_is_help=True,
    rich_markup_mode=None,
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
        False, "--version", "-V", callback=_print_version, is_eager=True, help="Print the version."
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
_COMMANDS = {
    _WRITE: (start.demo, start.examples, start.new, run.run, watch.watch, run.lint),
    _SUBMIT: (verify.verify, bundle.bundle, bundle.rehearse, verify.profile),
    _ANALYSE: (report.report, report.compare, convert.replay, convert.convert, calibrate.calibrate),
    _STUDY: (paper.reproduce, sweep.sweep),
}
for _heading, _commands in _COMMANDS.items():
    for _command in _commands:
        _own = _command in (run.run, watch.watch)
        app.command(
            cls=RunPage if _own else CommandPage,
            rich_help_panel=_heading,
            context_settings=SCRIPT_ARGUMENTS if _own else None,
        )(_command)


def main() -> None:
    """Run the command line; an error the user can mend is one plain line and exit code 2."""
    with as_a_shell_expects():
        try:
            app()
        except PosflockError as error:
            say(f"posflock: {error}", err=True)
            sys.exit(2)
