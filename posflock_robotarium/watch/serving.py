"""The server from its start to Ctrl-C."""

from __future__ import annotations

import asyncio
import contextlib
import getpass
import secrets
import signal
import socket
import threading
import webbrowser
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.watch.script import WatchJob
from posflock_robotarium.watch.settings import Settings
from posflock_robotarium.watch.show import Show
from rps_compat.containment.kept import KeptFolder
from rps_compat.running.outcome import Outcome

if TYPE_CHECKING:
    import uvicorn

#: The only address that is listened at.
LOOPBACK = "127.0.0.1"


class WatchError(PosflockError):
    """The page cannot be served."""


@dataclass(frozen=True)
class Place:
    """Where the page is.

    Attributes
    ----------
    port : int
        Of this machine.
    word : str
        Which nobody can guess.
    """

    port: int
    word: str

    @property
    def url(self) -> str:
        """The page's whole address."""
        return f"http://{LOOPBACK}:{self.port}/{self.word}/"

    @property
    def forwarding(self) -> str:
        """The command by which another machine has the same address."""
        try:
            user = getpass.getuser()
        except (KeyError, OSError):
            user = "USER"
        return f"ssh -N -L {self.port}:{LOOPBACK}:{self.port} {user}@{socket.gethostname()}"


def require_library() -> None:
    """Refuse to go on without a server library.

    Raises
    ------
    WatchError
        With the line that brings it.
    """
    try:
        import starlette
        import uvicorn
        import websockets
    except ImportError as error:
        raise WatchError(
            f"watch needs a server, and {error.name} is not installed: "
            "pip install 'posflock-robotarium[watch]'"
        ) from error
    del starlette, uvicorn, websockets


def watch(
    job: WatchJob,
    settings: Settings,
    *,
    port: int = 0,
    out: Path | None = None,
    stay: bool = True,
    opens: bool = False,
    tell: Callable[[Place], None] = lambda place: None,
    say: Callable[[str], None] = lambda text: None,
    ended: Callable[[Outcome], None] = lambda outcome: None,
) -> Outcome | None:
    """Run a script and show it, until Ctrl-C or, without `stay`, its end.

    Parameters
    ----------
    job : WatchJob
        What is run.
    settings : Settings
        How it begins.
    port : int
        To listen at; 0 takes one that is free.
    out : Path, optional
        Where the files of the last run are put; None keeps none.
    stay : bool
        Whether the page stays when the script has ended.
    opens : bool
        Whether a browser is opened here.
    tell : callable
        Is told where the page is, once it is.
    say : callable
        Is given what the script prints.
    ended : callable
        Is told of the end of each run.

    Returns
    -------
    Outcome or None
        Of the last run; None where none came to an end.

    Raises
    ------
    WatchError
        The library is not installed, or the port is taken.
    """
    require_library()
    with KeptFolder("watch") as folder, _listening(port) as listening:
        place = Place(listening.getsockname()[1], secrets.token_urlsafe(16))
        show = Show(job, settings, folder, out, say, ended)

        def ready() -> None:
            tell(place)
            if opens:
                threading.Thread(target=webbrowser.open, args=(place.url,), daemon=True).start()

        with contextlib.suppress(KeyboardInterrupt), _terminated_as_interrupted():
            asyncio.run(_serve(show, place, listening, stay, ready))
        return show.outcome


@contextlib.contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Take SIGTERM for Ctrl-C: what the run left is still to be kept."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _listening(port: int) -> socket.socket:
    server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        server.bind((LOOPBACK, port))
        server.listen()
    except (OSError, OverflowError) as error:
        server.close()
        raise WatchError(
            f"port {port} of {LOOPBACK} cannot be listened at: {error}; choose another (--port), or"
            " 0 for one that is free"
        ) from error
    return server


async def _serve(
    show: Show, place: Place, listening: socket.socket, stay: bool, ready: Callable[[], None]
) -> None:
    import uvicorn

    from posflock_robotarium.watch.server import application

    server = uvicorn.Server(
        uvicorn.Config(
            application(show, place.word),
            log_config=None,
            access_log=False,
            lifespan="off",
            http="h11",
            ws="websockets-sansio",
            ws_max_size=4096,
            server_header=False,
            timeout_graceful_shutdown=1,
        )
    )
    run = asyncio.create_task(_run(show, server, stay, ready))
    try:
        await server.serve(sockets=[listening])
    finally:
        show.close()
        run.cancel()
    if run.done() and not run.cancelled():
        run.result()


async def _run(show: Show, server: uvicorn.Server, stay: bool, ready: Callable[[], None]) -> None:
    ready()
    try:
        await show.run(stay)
    finally:
        server.should_exit = True
