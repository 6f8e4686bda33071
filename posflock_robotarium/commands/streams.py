"""The ends that a command shares with the shell: its output, and who reads it.

A reader that has seen enough, as ``| head`` does, ends a command as it ends any other: quietly,
with exit code 141. Exit code 1 means that something was found (a risk, a change to be made), and
must not come from a pipe.
"""

import contextlib
import os
import sys
from collections.abc import Iterator

from rps_compat.terminal import reader_is_gone, showable_output

#: What a shell says of a program that SIGPIPE (13) ended.
PIPE_CLOSED = 141


@contextlib.contextmanager
def as_a_shell_expects() -> Iterator[None]:
    """Let output show any character, and end with 141 where nobody reads it any more.

    Raises
    ------
    SystemExit
        With 141, where what the block wrote could not be delivered.
    """
    with showable_output():
        try:
            try:
                yield
            finally:
                sys.stdout.flush()
        except BrokenPipeError:
            _nobody_reads()
        except SystemExit as ended:
            # The command line's library makes exit code 1 of a closed pipe.
            if ended.code not in (0, None) and reader_is_gone():
                _nobody_reads()
            raise


def _nobody_reads() -> None:
    """End with 141, and leave nothing that Python could fail to write at its exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    with contextlib.suppress(AttributeError, OSError, ValueError):
        os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
    raise SystemExit(PIPE_CLOSED)
