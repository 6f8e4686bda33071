"""Starts the uploaded ``main.py`` in the rehearsal environment; see `posflock_robotarium.rehearse`.

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


def main() -> None:
    """Run the plan that is given as the one argument."""
    with open(sys.argv[1]) as file:
        plan = json.load(file)
    sys.path.append(plan["simulator"])
    package = plan["package"]
    importlib.import_module(package).install(api=plan["generation"])
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
    ended = "crashed"
    try:
        with session.active():
            runpy.run_path("main.py", run_name="__main__")
        ended = "finished"
    except KeyboardInterrupt:
        ended = "interrupted"
    except SystemExit as end:
        ended = "finished" if end.code in (None, 0) else "exited"
    except BaseException:
        traceback.print_exc()
    finally:
        arena = watch.arenas[-1] if watch.arenas else None
        verdict = {
            "ended": "interrupted" if watch.interrupted and ended == "finished" else ended,
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
