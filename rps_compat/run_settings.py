"""Everything about a run that is not in the script, in one object."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from rps_compat.errors import RobotariumError, ScriptError
from rps_compat.generations import Generation
from rps_compat.realism import Profile
from rps_compat.recording import OpenRecorder
from rps_compat.running.outcome import Outcome
from rps_compat.session import Initial


class SettingsError(RobotariumError, ValueError):
    """A time limit, a snapshot's time or a seed outside its range."""


@dataclass(frozen=True)
class RunSettings:
    """Everything about a run that is not in the script.

    Attributes
    ----------
    generation
        Generation of the API; None finds it from the script's source.
    headless
        No window, no waiting; None: headless where there is no display.
    initial
        How robots come to their initial conditions; see `rps_compat.session.Session`.
    seed
        Seeds Python's and numpy's global generators, and the imperfections.
    profile
        The imperfections; None is the ideal arena.
    timeout
        Seconds of real time after which the script is stopped; None lets it run.
    answers
        What ``input()`` answers headless, in order; after them an empty line.
    out
        Folder for everything that the run leaves; made if need be. None leaves nothing.
    claims_folder
        Hold that folder until the process ends; without `out`, runs/SCRIPT. See
        `rps_compat.run_folder`.
    snapshots
        Times of the run in seconds at which the figure is saved; infinity is its end.
    video
        File to film to, .mp4 or .gif; a relative name lies in `out`.
    recorder
        Opens the log of one instance; None writes no log.
    tell
        Is told, before the script starts, each note on the generation that it runs on.
    end_process
        Is called in another thread, with the result, if the time limit cannot stop the script; it
        must end the process. None lets such a script run on.

    Raises
    ------
    SettingsError
        A time limit that is not positive, a snapshot before the start, or a negative seed.
    """

    generation: Generation | None = None
    headless: bool | None = None
    initial: Initial = "published"
    seed: int | None = None
    profile: Profile | None = None
    timeout: float | None = None
    answers: Sequence[str] = ()
    out: Path | None = None
    claims_folder: bool = False
    snapshots: Sequence[float] = ()
    video: Path | None = None
    recorder: OpenRecorder | None = None
    tell: Callable[[str], None] | None = None
    end_process: Callable[[Outcome], NoReturn] | None = None

    def __post_init__(self) -> None:
        if self.timeout is not None and not self.timeout > 0:
            raise SettingsError(
                f"timeout is {self.timeout:g} s, expected more than 0; leave it out for none"
            )
        for time in self.snapshots:
            if not time >= 0:
                raise SettingsError(
                    f"snapshot at {time:g} s, expected 0 or more seconds of the run, or its end"
                )
        if self.seed is not None and self.seed < 0:
            raise SettingsError(f"seed is {self.seed}, expected a whole number from 0")


def snapshot_times(text: str) -> tuple[float, ...]:
    """Read the times of ``--snapshot``: seconds with commas between, ``end`` for the end.

    Parameters
    ----------
    text : str
        What the user wrote.

    Raises
    ------
    ScriptError
        Something else is written there.
    """
    try:
        return tuple(
            math.inf if word.strip() == "end" else float(word) for word in text.split(",") if word
        )
    except ValueError:
        raise ScriptError(f"--snapshot {text}: expected seconds, e.g. 0,10,end") from None
