"""A run that has its process to itself, as a command line has: it tells its result, and can end it.

What `run_script` cannot do, since the process may be somebody else's, is to end a script whose
threads go on. Here the process ends with the script, at the latest at its time limit.
"""

import contextlib
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from rps_compat.run_settings import RunSettings
from rps_compat.runner import run_script
from rps_compat.running.ending import end_process, leave
from rps_compat.running.outcome import Outcome, summary
from rps_compat.surroundings import stdout_on_stderr
from rps_compat.terminal import printable


def run_and_tell(
    script: Path, arguments: Sequence[str], settings: RunSettings, as_json: bool
) -> int:
    """Run `script`, print its result, and return the exit code.

    Does not return where Python would wait for threads or processes of a script that has ended, or
    that its time limit cannot stop.

    Parameters
    ----------
    script, arguments, settings
        As `run_script` takes them; without an output folder it is ``runs/SCRIPT``, and either way
        the folder is this process's until it ends.
    as_json
        Print the result as JSON and alone; the script then talks on stderr.
    """
    ours = set(threading.enumerate())
    with contextlib.ExitStack() as around:
        stdout = around.enter_context(stdout_on_stderr()) if as_json else sys.stdout

        def tell(result: Outcome) -> None:
            told = result.as_json() if as_json else summary(result)
            print(printable(told), file=stdout, flush=True)

        def give_up(result: Outcome) -> NoReturn:
            tell(result)
            end_process(result.exit_code)

        ending = replace(settings, claims_folder=True, end_process=give_up)
        result = run_script(script, arguments, ending)
        tell(result)
    leave(result.exit_code, ours)
    return result.exit_code
