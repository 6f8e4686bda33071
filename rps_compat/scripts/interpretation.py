"""What every name and expression of a script, and of the modules beside it, stands for.

This is a small abstract interpreter. It walks through the statements in order with a table of what
each name stands for (:mod:`~rps_compat.scripts.bindings`), joins the tables where branches meet,
goes through loops twice, and looks into functions with what they are called with. It does so again
until nothing new turns up. Nothing is run, so what a name stands for is told only as far as
imports, assignments, calls and annotations tell it.
"""

from pathlib import Path

from rps_compat.scripts.bindings import Interpreter
from rps_compat.scripts.program import Program
from rps_compat.scripts.source import Script, read_script
from rps_compat.scripts.values import ANYTHING, NONE

#: Rounds through the script after which the last one counts, whatever it brought.
_ROUNDS = 8


def interpret(script: Script) -> Program:
    """Find out what the names of a script and of the modules beside it stand for.

    Parameters
    ----------
    script : Script
        The main file.
    """
    program = Program(script)
    for program.absent in (NONE, ANYTHING):  # nothing yet, then whatever it may be
        _go_through(program)
    return program


def _go_through(program: Program) -> None:
    """Go through everything until nothing new turns up."""
    for _ in range(_ROUNDS):
        program.begin_round()
        Interpreter(program, program.main).run()
        if not program.grown:
            break


def read_program(path: Path | str) -> Program:
    """Read a script and the modules beside it.

    Parameters
    ----------
    path : Path or str
        The script's file.

    Raises
    ------
    ScriptError
        It is not there.
    UnreadableError
        It is not Python. A module beside it that is not is left out.
    """
    return interpret(read_script(path))
