"""How far a command is: a bar on a terminal, a line for every tenth elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer


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
            typer.echo(f"{title}: {done} of {total}", err=True)

    yield tell
