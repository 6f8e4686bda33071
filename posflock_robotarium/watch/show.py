"""What all pages see of the run, and what becomes of what one of them asks.

Pages come and go, several at a time. Each that comes is told everything that a page needs, with the
trails of the last seconds; a page that is too slow misses pictures, and nothing else.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from posflock_robotarium.watch.requests import SPEEDS, Again, PageRequest, RequestError, UseProfile
from posflock_robotarium.watch.script import ScriptEars, ScriptProcess, WatchJob
from posflock_robotarium.watch.settings import Settings
from posflock_robotarium.watch.tuning import MODELS, RANGES
from rps_compat.running.outcome import Outcome, summary

#: Pictures that a page gets when it comes, for its trails; characters of what was printed.
_PICTURES, _PRINTED = 400, 20_000
#: Pictures that may wait for a slow page.
_MOST_WAITING = 60
#: Real seconds that an interrupted script gets to end itself.
_GRACE = 3.0
#: Real seconds between two looks whether it runs.
_LOOK = 0.05


class Viewer:
    """One page, and what it has not been sent yet."""

    def __init__(self) -> None:
        self._waiting: list[tuple[str, str]] = []
        self._bell = asyncio.Event()

    def offer(self, kind: str, text: str) -> None:
        """Let something be sent; of pictures the newest.

        Parameters
        ----------
        kind : str
            What it is.
        text : str
            JSON of it.
        """
        pictures = [k for k, (waiting, _) in enumerate(self._waiting) if waiting == "frame"]
        if kind == "frame" and len(pictures) >= _MOST_WAITING:
            del self._waiting[pictures[0]]
        self._waiting.append((kind, text))
        self._bell.set()

    async def messages(self) -> list[str]:
        """Return what waits, once there is something."""
        await self._bell.wait()
        self._bell.clear()
        found, self._waiting = self._waiting, []
        return [f'{{"kind": "{kind}", "data": {text}}}' for kind, text in found]


class Show:
    """The run, and all pages that show it.

    Parameters
    ----------
    job : WatchJob
        What is run.
    settings : Settings
        How it begins.
    folder : Path
        Temporary folder for its runs.
    out : Path, optional
        Where the files of the last run are put; None keeps none.
    say : callable
        Is given what the script prints.
    ended : callable
        Is told of the end of each run.

    Attributes
    ----------
    settings : Settings
        How things are set.
    outcome : Outcome or None
        How the run has ended; None while it goes on.
    """

    def __init__(
        self,
        job: WatchJob,
        settings: Settings,
        folder: Path,
        out: Path | None = None,
        say: Callable[[str], None] = lambda text: None,
        ended: Callable[[Outcome], None] = lambda outcome: None,
    ) -> None:
        self.job, self.settings = job, settings
        self.outcome: Outcome | None = None
        self._folder, self._out, self._say, self._ended = folder, out, say, ended
        self._viewers: set[Viewer] = set()
        self._process: ScriptProcess | None = None
        self._runs = 0
        self._left: list[str] = []
        self._again = False
        self._forget()

    def _forget(self) -> None:
        """Begin with an empty arena."""
        self.outcome = None
        self._scene: str | None = None
        self._frames: deque[str] = deque(maxlen=_PICTURES)
        self._flock: dict[str, Any] | None = None
        self._printed = ""

    # --- Pages ----------------------------------------------------------------------------------

    @contextlib.contextmanager
    def viewed(self) -> Iterator[Viewer]:
        """Let one page more see the run within the ``with`` block."""
        viewer = Viewer()
        viewer.offer("hello", json.dumps(self._hello()))
        for kind, text in self._everything():
            viewer.offer(kind, text)
        self._viewers.add(viewer)
        try:
            yield viewer
        finally:
            self._viewers.discard(viewer)

    def _hello(self) -> dict[str, Any]:
        """Return what stays the same for as long as the server runs."""
        return {
            "script": self.job.script.name,
            "generation": self.job.generation,
            "seed": self.job.seed,
            "profiles": list(self.job.profiles),
            "speeds": list(SPEEDS),
            "ranges": {name: asdict(span) for name, span in RANGES.items()},
            "models": {model.value: words for model, words in MODELS.items()},
        }

    def _everything(self) -> Iterator[tuple[str, str]]:
        yield "begin", "null"
        if self._scene is not None:
            yield "scene", self._scene
        yield "past", f"[{', '.join(self._frames)}]"
        yield "printed", json.dumps(self._printed)
        yield "state", self._state()

    def _state(self, refused: str = "") -> str:
        outcome = self.outcome
        running = "starting" if self._scene is None else "running"
        return json.dumps(
            {
                "phase": running if outcome is None else "ended",
                "settings": self.settings.as_dict(),
                "flock": self._flock,
                "refused": refused,
                "outcome": None if outcome is None else _told(outcome),
            }
        )

    def _tell(self, kind: str, text: str) -> None:
        for viewer in self._viewers:
            viewer.offer(kind, text)

    def ask(self, request: PageRequest) -> None:
        """Do what a page asks.

        Parameters
        ----------
        request : PageRequest
            What it asks.

        Raises
        ------
        RequestError
            There is no such profile.
        """
        if isinstance(request, UseProfile) and request.name not in self.job.profiles:
            raise RequestError(
                f"name: expected one of {', '.join(self.job.profiles)}; got {request.name!r}"
            )
        if isinstance(request, Again):
            self._again = True
            if self._process is not None:
                self._process.interrupt()
        elif self.outcome is None and self._process is not None:
            self._process.ask(request)
        else:
            self.settings = self.settings.after(request)
            self._tell("state", self._state())

    # --- The run --------------------------------------------------------------------------------

    async def run(self, stay: bool) -> None:
        """Run the script, and again when a page asks for it.

        Parameters
        ----------
        stay : bool
            Whether to go on when the script has ended.
        """
        while True:
            self._again = False
            await self._run_once()
            while stay and not self._again:
                await asyncio.sleep(_LOOK)
            if not self._again:
                return

    async def _run_once(self) -> None:
        self._forget()
        for kind, text in self._everything():
            self._tell(kind, text)
        self._runs += 1
        place, heard = self._folder / f"run-{self._runs}", ScriptEars(self._heard, self._print)
        process = await asyncio.to_thread(ScriptProcess, self.job, self.settings, place, heard)
        self._process = process
        loop, sources = asyncio.get_running_loop(), (process.told.pipe, process.printed)
        for source in sources:
            loop.add_reader(source, self._hear, process)
        deadline = float("inf")
        while process.is_running():
            await asyncio.sleep(_LOOK)
            if self._again:
                deadline = min(deadline, time.monotonic() + _GRACE)
            if time.monotonic() > deadline:
                break
        for source in sources:
            loop.remove_reader(source)
        self._finish(process)

    def _hear(self, process: ScriptProcess) -> None:
        process.hear()
        loop = asyncio.get_running_loop()
        for source, over in (
            (process.told.pipe, process.told.ended),
            (process.printed, process.silent),
        ):
            if over:
                loop.remove_reader(source)

    def _finish(self, process: ScriptProcess) -> None:
        """Take note of the end of a run, and keep its files where that was asked for."""
        process.hear()
        if process.is_running():
            process.kill()
        self._process = None
        self.outcome = replace(process.outcome(), files=())
        if self._out is not None:
            self._left = process.bring_out(self._out, self._left)
            files = tuple(self._out / name for name in self._left)
            self.outcome = replace(self.outcome, files=files, folder=self._out)
        self._tell("state", self._state())
        self._ended(self.outcome)

    def close(self) -> None:
        """End a run that goes on: it is interrupted, and soon killed."""
        process = self._process
        if process is None:
            return
        deadline = time.monotonic() + _GRACE
        try:
            process.interrupt()
            while process.is_running() and time.monotonic() < deadline:
                time.sleep(_LOOK)
                process.hear()
        finally:
            self._finish(process)

    def _heard(self, kind: str, text: str) -> None:
        if kind == "frame":
            self._frames.append(text)
        elif kind == "scene":
            self._scene = text
            self._frames.clear()
        elif kind == "state":
            data = json.loads(text)
            self.settings, self._flock = Settings.from_dict(data["settings"]), data["flock"]
            text = self._state(data["refused"])
        else:
            return
        self._tell(kind, text)

    def _print(self, text: str) -> None:
        self._printed = (self._printed + text)[-_PRINTED:]
        self._tell("printed", json.dumps(text))
        self._say(text)


def _told(outcome: Outcome) -> dict[str, Any]:
    """Return what a page is told of the end."""
    lines, error = summary(outcome).splitlines(), outcome.error
    place = f" (line {error.line} of {error.file})" if error and error.line else ""
    return {
        "ended": outcome.ended.value,
        "reason": outcome.reason + place,
        "exit_code": outcome.exit_code,
        "clean": outcome.clean,
        "lines": [line for line in lines[1:] if not line.startswith("in ")],
    }
