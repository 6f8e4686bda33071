"""The end of a script that nothing will ever wake again, and where its threads wait."""

import math
import os
import sys
import sysconfig
import threading
from collections.abc import Iterable
from pathlib import Path
from types import FrameType

from rps_compat.clock.threads import ScriptThread

_LIBRARY = sysconfig.get_path("stdlib") + os.sep
_OURS = str(Path(__file__).parent.parent) + os.sep
#: What calls the script: outside of it nothing is the script's.
_CALLERS = ("ending.py", "runpy.py", "<frozen runpy>")


class Stuck(BaseException):
    """The script waits for ever; not an Exception, so that scripts do not swallow it."""

    @classmethod
    def told_of(cls, threads: Iterable[ScriptThread], after: float = math.inf) -> "Stuck":
        """Return what to raise where threads wait for ever.

        Parameters
        ----------
        threads : iterable of ScriptThread
            Those of the script that have not ended.
        after : float
            Simulated time without a step, s; infinite where nothing can wake them.
        """
        long = "" if math.isinf(after) else f"no step for {after:g} s of the run, "
        return cls(f"waits for ever: {long}{where_they_wait(threads)}")


def line_of_the_script(frame: FrameType | None) -> str:
    """Return ``file, line n`` of the innermost frame that belongs to the script, or nothing.

    Parameters
    ----------
    frame : frame or None
        The innermost frame of a thread.
    """
    while frame is not None and not frame.f_code.co_filename.endswith(_CALLERS):
        name = frame.f_code.co_filename
        if not name.startswith((_LIBRARY, _OURS, "<frozen")) or "site-packages" in name:
            return f"{os.path.basename(name)}, line {frame.f_lineno}"
        frame = frame.f_back
    return ""


def where_they_wait(threads: Iterable[ScriptThread]) -> str:
    """Tell of each thread where it waits, for a person who looks for the mistake.

    Parameters
    ----------
    threads : iterable of ScriptThread
        Those of the script that have not ended.
    """
    frames = sys._current_frames()
    told = (_told(thread, frames.get(thread.ident or 0)) for thread in threads)
    return "; ".join(filter(None, told))


def _told(thread: ScriptThread, frame: FrameType | None) -> str:
    place = line_of_the_script(frame)
    if place:
        return f"{thread.name} waits at {place}"
    if thread.thread is threading.main_thread():
        return ""  # the script is at its end, and Python waits for the others
    while frame is not None and frame.f_code.co_filename.startswith(_OURS):
        frame = frame.f_back
    what = "" if frame is None else f" in {frame.f_code.co_name}()"
    started = f", started at {thread.started_at}," if thread.started_at else ""
    return f"{thread.name}{started} waits{what}"
