"""What commands say, and how far they are.

All that a command prints goes through `say`: names of files, words of scripts and reasons in logs
come from strangers, and none of them commands the terminal.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer

from rps_compat.terminal import printable


def say(text: str = "", *, err: bool = False, end: str = "\n") -> None:
    """Print text, with what would command a terminal written out.

    Parameters
    ----------
    text : str
        What is said.
    err : bool
        To standard error.
    end : str
        What follows it.
    """
    typer.echo(printable(text) + end, nl=False, err=err)


@contextmanager
def progress(title: str) -> Iterator[Callable[[int, int], None]]:
    """Yield a function that is told how much is done of how much, and shows it.

    Parameters
    ----------
    title : str
        What is being done.
    """
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    if console.is_terminal:
        with Progress(console=console, transient=True) as bar:
            task = bar.add_task(title, total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)
        return

    def tell(done: int, total: int) -> None:
        if total >= 10 and done * 10 // total > (done - 1) * 10 // total:
            say(f"{title}: {done} of {total}", err=True)

    yield tell
