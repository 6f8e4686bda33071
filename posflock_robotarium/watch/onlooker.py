"""Looks on in the script's own process: holds it in its step, obeys requests, sends pictures.

Everything happens in the thread that steps, between the script's command and the robots' motion:
what a request changes holds from that very step on. The script's time stands still meanwhile (see
`rps_compat.clock.scheduler`).
"""

from __future__ import annotations

import json
import math
import os
import weakref
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from barrier_certificates.hearing import Answer
from posflock_robotarium.flocking.attendance import Attended
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.watch.pace import WatchPace
from posflock_robotarium.watch.picture import BarrierPicture, barrier_of, frame_of, known, scene_of
from posflock_robotarium.watch.requests import (
    Go,
    PageRequest,
    Pause,
    Retune,
    Speed,
    Step,
    Stop,
    UseProfile,
    read_request,
)
from posflock_robotarium.watch.settings import Settings
from rps_compat.arena import Arena
from rps_compat.clock import real
from rps_compat.realism import Profile
from rps_compat.recording import Onlooker

#: Real seconds between two pictures of a simulation that runs.
_PICTURES_APART = 0.03
#: Speed in m/s that does not count as moving, as for the report.
_SLOWEST = 0.005


class Lines:
    """Lines that come through a pipe.

    Parameters
    ----------
    pipe : int
        Descriptor that is read from.
    """

    def __init__(self, pipe: int) -> None:
        self.pipe = pipe
        self.ended = False
        self._begun = b""

    def within(self, seconds: float) -> list[str]:
        """Return the lines that have come, waiting for the first so long.

        Parameters
        ----------
        seconds : float
            Real seconds; infinity waits until there is one, or the pipe's end.
        """
        timeout = None if math.isinf(seconds) else seconds
        if self.ended or not real.select_select([self.pipe], [], [], timeout)[0]:
            return []
        block = os.read(self.pipe, 1 << 16)
        self.ended = not block
        *lines, self._begun = (self._begun + block).split(b"\n")
        return [line.decode("utf-8", "replace") for line in lines]


class WatchedRun(Onlooker):
    """Shows one run to whoever watches, and does what they ask.

    Parameters
    ----------
    tell : callable
        Is given the kind and the JSON of whatever is shown.
    requests : Lines
        What is asked.
    settings : Settings
        How the run begins.
    profiles : mapping of str to Profile
        Those that may be asked for.
    radius : float, optional
        Who is a neighbour where no flock tells, metres; None shows no neighbours then.
    seed : int, optional
        Of the randomness of a profile that is asked for.
    """

    def __init__(
        self,
        tell: Callable[[str, str], None],
        requests: Lines,
        settings: Settings,
        profiles: Mapping[str, Profile],
        radius: float | None = None,
        seed: int | None = None,
    ) -> None:
        self._tell, self._requests, self._profiles = tell, requests, profiles
        self.settings = settings
        self.pace = WatchPace(settings.speed, settings.paused)
        self.logs: list[PoseLog] = []
        self.changes: list[dict[str, Any]] = []
        self._radius, self._seed, self._owner = radius, seed, os.getpid()
        self._arena: Arena | None = None
        self._robotarium: weakref.ref[Any] = weakref.ref(self)
        self._flock: Attended | None = None
        self._barrier: BarrierPicture | None = None  # since the last picture
        self._told_barrier: BarrierPicture | None = None
        self._shown = (-math.inf, -1)  # real time and step of the last picture
        self._begun_with = settings.profile

    # --- What comes in --------------------------------------------------------------------------

    def created(self, robotarium: Any, /) -> None:
        """Look at a new instance from now on."""
        self._arena, self._robotarium = robotarium._arena, weakref.ref(robotarium)
        if self.settings.profile != self._begun_with:
            self._exchange(robotarium._arena)
        self._tell_scene(robotarium._arena)
        self.tell_state()

    def heard(self, answer: Answer) -> None:
        """Take note of what a certificate answered: of the step's answers the one that did most.

        Parameters
        ----------
        answer : Answer
            Of any certificate of the script.
        """
        if os.getpid() != self._owner:  # a process that the script has forked
            return
        before = self._barrier
        if before is None or (answer.info.intervention or 0.0) >= (before.intervention or 0.0):
            self._barrier = barrier_of(answer)

    def attend(self, flock: Attended) -> None:
        """Let a flock follow the law that is asked for, from its next step on.

        Parameters
        ----------
        flock : Attended
            A flock of the script.
        """
        if os.getpid() != self._owner:
            return
        fresh = self._flock is not flock
        self._flock = flock
        asked = self.settings.law
        wanted = {k: v for k, v in vars(asked).items() if v is not None and k != "model"}
        law = replace(flock.law, **wanted)
        model = flock.model if asked.model is None else asked.model
        refused = ""
        if law.as_dict() != flock.law.as_dict() or model is not flock.model:
            try:
                flock.retune(law, model)
            except ParameterError as error:
                refused = str(error)
                self.settings = replace(self.settings, law=Retune())
            else:
                self._note(law=law.as_dict(), model=model.value)
                fresh = True
        if fresh or refused:
            self.tell_state(refused)

    def step(self, time: float, arena: Arena, /) -> None:
        """Show the step if it is time, hold it as long as the pace wants, obey what is asked.

        Raises
        ------
        KeyboardInterrupt
            If somebody asks to stop, or nobody is left who watches.
        """
        if arena is not self._arena:
            self._arena = arena
            self._tell_scene(arena)
        self._obey(self._requests.within(0.0), arena)
        left = self.pace.wait(real.monotonic())
        if math.isinf(left) or real.monotonic() - self._shown[0] >= _PICTURES_APART:
            self.show(arena)
        while left:
            self._obey(self._requests.within(left), arena)
            left = self.pace.wait(real.monotonic())
        self.pace.stepped(time, arena.robot.time_step, real.monotonic())

    def _obey(self, lines: list[str], arena: Arena) -> None:
        if self._requests.ended:
            raise KeyboardInterrupt
        for line in lines:
            request = read_request(line)
            if isinstance(request, Stop):
                raise KeyboardInterrupt
            self._change(request, arena)
            self.tell_state()

    def _change(self, request: PageRequest, arena: Arena) -> None:
        """Do what is asked, between two steps of robots and flock."""
        before, pace = self.settings, self.pace
        self.settings = before.after(request)
        if isinstance(request, Go):
            pace.go()
        elif isinstance(request, Pause):
            pace.pause()
            self.show(arena)
        elif isinstance(request, Step):
            pace.step(request.steps)
        elif isinstance(request, Speed):
            pace.run_at(request.factor)
        elif isinstance(request, UseProfile) and request.name != before.profile:
            self._exchange(arena)
            self._note(profile=request.name)
        elif isinstance(request, Retune) and self._flock is not None:
            self.attend(self._flock)

    def _exchange(self, arena: Arena) -> None:
        """Give an arena the imperfections that are asked for."""
        profile = self._profiles[self.settings.profile]
        seed = None if self._seed is None else [self._seed, arena.steps, len(self.changes)]
        arena.become(profile.start(), np.random.default_rng(seed))

    def _note(self, **change: Any) -> None:
        """Keep in the pose logs what was changed, and when: no seed repeats it."""
        time = 0.0 if self._arena is None else self._arena.time
        self.changes.append({"time": time, **change})
        for log in self.logs:
            log.annotate(changed_while_watched=self.changes)

    # --- What goes out --------------------------------------------------------------------------

    def _tell_scene(self, arena: Arena) -> None:
        self._tell("scene", json.dumps(scene_of(arena)))

    def tell_state(self, refused: str = "") -> None:
        """Tell how things are set, and what flock there is.

        Parameters
        ----------
        refused : str
            Why something was not done.
        """
        flock = self._flock
        law = None if flock is None else {**flock.law.as_dict(), "model": flock.model.value}
        state = {"settings": self.settings.as_dict(), "flock": law, "refused": refused}
        self._tell("state", json.dumps(state))

    def show(self, arena: Arena | None = None, last: bool = False) -> None:
        """Send a picture of an arena as it is now, unless it has been sent.

        Parameters
        ----------
        arena : Arena, optional
            By default the one that was stepped last.
        last : bool
            Whether the run is over: what certificates did last is still shown.
        """
        arena = self._arena if arena is None else arena
        if arena is None or self._shown[1] == arena.steps:
            return
        self._shown = (real.monotonic(), arena.steps)
        frame = frame_of(arena, self._leds())
        if not last or self._barrier is not None:
            self._told_barrier = self._barrier
        barrier, self._barrier = self._told_barrier, None
        frame["barrier"] = None if barrier is None else asdict(barrier)
        frame["reached"] = self.pace.reached
        frame.update(self._neighbours(arena))
        self._tell("frame", json.dumps(frame, allow_nan=False))

    def _leds(self) -> Any:
        robotarium = self._robotarium()
        return getattr(robotarium, "_leds", getattr(robotarium, "leds", None))

    def _neighbours(self, arena: Arena) -> dict[str, Any]:
        """Return who is whose neighbour, and γ; nothing where nobody knows the radius."""
        flock, positions = self._flock, arena.poses[:2]
        radius = self._radius if flock is None else flock.law.radius
        if radius is None:
            return {}
        from posflock_robotarium.alignment.metrics.directions import alignment, heading_vectors

        links = None if flock is None else flock.links
        if links is None or links.shape[0] != arena.number_of_robots:
            offset = positions[:, :, None] - positions[:, None, :]
            links = np.hypot(*offset) < radius
        first, second = np.nonzero(np.triu(links | links.T, 1))
        headings = heading_vectors(arena.poses)
        speeds = arena.velocities[0]
        pointed = alignment(headings, positions, radius).gamma
        moved = alignment(speeds * headings, positions, radius, slowest=_SLOWEST).gamma
        return {
            "links": list(zip(first.tolist(), second.tolist(), strict=True)),
            "gamma": {"headings": known(float(pointed)), "motion": known(float(moved))},
        }
