"""Starts the uploaded ``main.py`` in the environment of `posflock_robotarium.submission.rehearse`.

Runs there, not here: it imports nothing of this package, and the simulator under a private name.
"""

import importlib
import json
import os
import runpy
import signal
import sys
import traceback
from typing import Any

_NETWORK = ("socket.connect", "socket.getaddrinfo", "socket.sendto", "socket.bind")


class _Watch:
    """Interrupts the run when its declared time is over."""

    def __init__(self, duration: float) -> None:
        self.duration = duration
        self.arenas: list[Any] = []
        self.interrupted = False
        self.refused = 0

    def created(self, robotarium: Any) -> None:
        self.arenas.append(robotarium._arena)

    def append(self, time: float, poses: Any, commands: Any) -> None:
        if time >= self.duration:
            self.interrupted = True
            self.refused += 1
            if self.refused > 10:  # it was told often enough
                os.kill(os.getpid(), signal.SIGKILL)
            raise KeyboardInterrupt


def _refuse_network(event: str, arguments: Any) -> None:
    if event in _NETWORK:
        raise PermissionError(f"there is no network in a rehearsal ({event})")


def _place(error: BaseException) -> str:
    """Return the line of main.py that an error came through, and of the module it rose in."""
    home = os.getcwd()
    frames = traceback.extract_tb(error.__traceback__)
    places = [(frame.filename, frame.lineno) for frame in frames]
    if isinstance(error, SyntaxError) and error.filename:
        places.append((error.filename, error.lineno))
    # The main file goes by its bare name, other uploads by their full path.
    main = [(name, line) for name, line in places if name == "main.py"]
    others = [
        (os.path.basename(name), line) for name, line in places if os.path.dirname(name) == home
    ]
    words = [f"{name}, line {line}" for name, line in main[-1:] + others[-1:]]
    return words[0] + (f" ({words[1]})" if words[1:] else "") + ": " if words else ""


def main() -> None:
    """Run the plan that is given as the one argument."""
    with open(sys.argv[1]) as file:
        plan = json.load(file)
    sys.path.append(plan["simulator"])
    package = plan["package"]
    importlib.import_module(package).install(generation=plan["generation"])
    profiles = importlib.import_module(f"{package}.profiles")
    realism = importlib.import_module(f"{package}.realism")
    sessions = importlib.import_module(f"{package}.session")
    profile = profiles.profile_from_dict(plan["profile"]) if plan["profile"] else None
    watch = _Watch(plan["duration"])
    session = sessions.Session(
        initial=plan["initial"],
        seed=plan["seed"],
        realism=None if profile is None else lambda: realism.Imperfections(profile),
        recorder=lambda robots: watch,
        created=watch.created,
        wait=False,
    )
    sys.argv = ["main.py"]
    sys.path.insert(0, os.getcwd())
    sys.addaudithook(_refuse_network)
    ended, reason = "crashed", ""
    try:
        with session.active():
            runpy.run_path("main.py", run_name="__main__")
        ended = "finished"
    except KeyboardInterrupt:
        ended = "interrupted"
    except SystemExit as end:
        ended = "finished" if end.code in (None, 0) else "exited"
        reason = "" if ended == "finished" else f"exit code {end.code!r}"
    except BaseException as error:
        traceback.print_exc()
        what = traceback.format_exception_only(type(error), error)[-1].strip()
        reason = _place(error) + what.partition("\n")[0]
    finally:
        arena = watch.arenas[-1] if watch.arenas else None
        verdict = {
            "ended": "interrupted" if watch.interrupted and ended == "finished" else ended,
            "reason": reason,
            "seconds": arena.time if arena else 0.0,
            "steps": arena.steps if arena else 0,
            "robots": arena.number_of_robots if arena else 0,
            "faults": {
                name: getattr(arena.violations, name)
                for name in ("close_pairs", "outside_steps", "actuator_steps")
            }
            if arena
            else {},
        }
        with open(plan["verdict"], "w") as file:
            json.dump(verdict, file)


if __name__ == "__main__":
    main()
