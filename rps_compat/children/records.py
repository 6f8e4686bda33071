"""What is known of an instance in a child process, on disk and true after every step.

Pools end their processes with a signal, and a killed process says nothing any more. So what the
report needs, the counters and the faults, is written where it changes, in place: a head of fixed
size, then one entry for each fault. What is written is the operating system's, whatever becomes of
the process; the step that a killed process had begun may be one too many.
"""

import json
import struct
from dataclasses import asdict, dataclass
from pathlib import Path

from rps_compat.arena import Arena
from rps_compat.recording import RecordWriter
from rps_compat.violations import Event, FaultKind, Violations

# Steps, seconds of a step, counters, fastest wheel, number of faults, whether the run is over; then
# kind, robots, first and last step, worst value of each fault.
_HEAD, _FAULT = struct.Struct("<qdqqqqdqq"), struct.Struct("<iiiqqd")
_KINDS = tuple(FaultKind)


@dataclass(frozen=True)
class RobotariumInstance:
    """What does not change about one instance.

    Attributes
    ----------
    process
        Name of the process that it lives in.
    number
        Its number in that process, from 1.
    robots
        How many robots it has.
    log
        Path of its log without ending; "" where there is none.
    copied
        Whether it is a copy, made by a fork, of one that the parent has.
    """

    process: str
    number: int
    robots: int
    log: str
    copied: bool = False

    @property
    def name(self) -> str:
        """What its files are called."""
        return f"{self.process}-{self.number}"

    @classmethod
    def read(cls, path: Path) -> "RobotariumInstance":
        """Read what :meth:`write` has written.

        Parameters
        ----------
        path : Path
            A file ``NAME.instance`` in the folder of the run's records.
        """
        return cls(**json.loads(path.read_text("utf-8")))

    def write(self, room: Path) -> None:
        """Leave this in the folder of the run's records.

        Parameters
        ----------
        room : Path
            Folder of the run's records.
        """
        (room / f"{self.name}.instance").write_text(json.dumps(asdict(self)), "utf-8")


class InstanceRecord(RecordWriter):
    """Writes the record of one instance.

    Parameters
    ----------
    room
        Folder of the records of one run.
    instance
        Which it is.
    """

    def __init__(self, room: Path, instance: RobotariumInstance) -> None:
        self._file = open(room / f"{instance.name}.steps", "w+b", buffering=0)  # noqa: SIM115
        instance.write(room)
        self._violations: Violations | None = None
        self._counted: tuple[int, ...] = ()
        self._places: dict[int, int] = {}

    def update(self, arena: Arena, /) -> None:
        """Take note of the step that the arena is about to do, and of what is wrong before it."""
        self._write(arena, arena.steps + 1)

    def close(self, arena: Arena, /) -> None:
        """Take note of the arena as it is, with the end of every fault."""
        self._counted = ()
        self._write(arena, arena.steps, over=True)
        self._file.close()

    def _write(self, arena: Arena, steps: int, over: bool = False) -> None:
        found = arena.violations
        counted = (found.close_steps, found.outside_steps, found.actuator_steps, found.close_pairs)
        if found is not self._violations:  # counting has been begun afresh
            self._violations, self._counted, self._places = found, (), {}
        if counted != self._counted:
            self._write_faults(found, arena.steps if self._counted else 0)
            self._counted = counted
        fastest, faults = found.largest_wheel_velocity, len(self._places)
        self._file.seek(0)
        self._file.write(_HEAD.pack(steps, arena.robot.time_step, *counted, fastest, faults, over))

    def _write_faults(self, found: Violations, since: int) -> None:
        """Write the faults that were seen at step `since` or later."""
        for event in found.events[len(self._places) :]:
            self._places[id(event)] = len(self._places)
        for event in found.lasting(since):
            first, second = (*event.robots, -1)[:2]
            kind = _KINDS.index(event.kind)
            self._file.seek(_HEAD.size + _FAULT.size * self._places[id(event)])
            self._file.write(_FAULT.pack(kind, first, second, event.first, event.last, event.worst))


@dataclass(frozen=True)
class Record:
    """What an instance last told.

    Attributes
    ----------
    steps, time_step
        How many, and seconds of one.
    found
        What was wrong.
    over
        Whether its run is over: nothing more would have come.
    """

    steps: int
    time_step: float
    found: Violations
    over: bool

    @classmethod
    def read(cls, room: Path, instance: RobotariumInstance) -> "Record":
        """Read what an instance has left.

        Parameters
        ----------
        room : Path
            Folder of the run's records.
        instance : RobotariumInstance
            Whose record it is.
        """
        content = (room / f"{instance.name}.steps").read_bytes()
        if len(content) < _HEAD.size:  # it never made a step
            return cls(0, 0.0, Violations(), over=False)
        steps, dt, close, outside, actuator, pairs, fastest, faults, over = _HEAD.unpack_from(
            content
        )
        found = Violations(
            actuator_steps=actuator,
            largest_wheel_velocity=fastest,
            outside_steps=outside,
            close_pairs=pairs,
            close_steps=close,
        )
        for k in range(min(faults, (len(content) - _HEAD.size) // _FAULT.size)):
            place = _HEAD.size + _FAULT.size * k
            kind, first, second, begun, seen, worst = _FAULT.unpack_from(content, place)
            robots = (first,) if second < 0 else (first, second)
            found.events.append(Event(_KINDS[kind], robots, begun, seen, worst))
        return cls(steps, dt, found, bool(over))
