"""What a run tells of itself while it goes on, to whoever watches it from another process.

The watcher has the numbers of the last step in shared memory, and a pipe: through it come
violations of policy at once, for the run may be killed, and the outcome when it has ended. Each
line of the pipe begins with a word that only these two know, so that a script cannot speak for its
run by writing into whatever file or descriptor it finds.
"""

from __future__ import annotations

import contextlib
import json
import mmap
import os
import secrets
import struct
from collections.abc import Callable
from dataclasses import asdict, dataclass, field

from rps_compat.clock import real
from rps_compat.running.outcome import Outcome
from rps_compat.running.policy_violations import PolicyViolation, read_violation

_PULSE = struct.Struct("qddd")
_VIOLATION, _OUTCOME = b"violation", b"outcome"
#: Violations that are told of one run: one that tries again and again says nothing new.
MOST_VIOLATIONS = 100


def new_word() -> str:
    """Return a word that nobody can guess."""
    return secrets.token_hex(16)


@dataclass
class Teller:
    """The end of the pipe at which the run is.

    Attributes
    ----------
    pipe : int
        Descriptor that is written to.
    word : str
        What every line begins with.
    pulse : mmap, optional
        Shared memory for the numbers of the last step.
    """

    pipe: int
    word: str
    pulse: mmap.mmap | None = None

    def step(self, steps: int, time: float) -> None:
        """Leave how far the run is.

        Parameters
        ----------
        steps : int
            Done so far.
        time : float
            Seconds of the run.
        """
        if self.pulse is not None:
            self.pulse[: _PULSE.size] = _PULSE.pack(steps, time, real.time(), real.process_time())

    def violation(self, violation: PolicyViolation) -> None:
        """Tell of a violation of policy.

        Parameters
        ----------
        violation : PolicyViolation
            What was done.
        """
        self._write(_VIOLATION, json.dumps(asdict(violation)))

    def outcome(self, outcome: Outcome) -> None:
        """Tell how the run went, as the last thing.

        Parameters
        ----------
        outcome : Outcome
            How it went.
        """
        self._write(_OUTCOME, json.dumps(outcome.as_dict()))

    def more(self, kind: str, text: str) -> None:
        """Tell something else, of a kind that a `Listener` hands on.

        Parameters
        ----------
        kind : str
            One word.
        text : str
            One line.
        """
        self._write(kind.encode(), text)

    def _write(self, kind: bytes, text: str) -> None:
        rest = memoryview(b"%s %s %s\n" % (self.word.encode(), kind, text.encode()))
        with contextlib.suppress(OSError):  # the script has closed what it did not open
            while rest:
                rest = rest[os.write(self.pipe, rest) :]


@dataclass
class Listener:
    """The other end, at which the watcher is.

    Attributes
    ----------
    pipe : int
        Descriptor that is read from, without waiting.
    word : str
        What every line begins with that counts.
    said : Outcome, optional
        How the run says it went.
    violations : list of PolicyViolation
        What it has told of so far.
    more : callable, optional
        Is given the kind and the text of whatever else it tells.
    ended : bool
        Whether nobody is left who could tell anything.
    """

    pipe: int
    word: str
    said: Outcome | None = None
    violations: list[PolicyViolation] = field(default_factory=list)
    more: Callable[[str, str], None] | None = None
    ended: bool = False
    _begun: bytes = b""

    def __post_init__(self) -> None:
        os.set_blocking(self.pipe, False)

    def hear(self) -> None:
        """Read what has been told since."""
        while True:
            try:
                block = os.read(self.pipe, 1 << 16)
            except BlockingIOError:
                return
            if not block:
                self.ended = True
                return
            *lines, self._begun = (self._begun + block).split(b"\n")
            for line in lines:
                self._take(line)

    def close(self) -> None:
        """Read the rest, and listen no more."""
        self.hear()
        os.close(self.pipe)

    def _take(self, line: bytes) -> None:
        word, _, rest = line.partition(b" ")
        kind, _, text = rest.partition(b" ")
        if word != self.word.encode():
            return
        if kind == _OUTCOME:
            self.said = Outcome.from_dict(json.loads(text))
        elif kind == _VIOLATION and len(self.violations) < MOST_VIOLATIONS:
            self.violations.append(read_violation(json.loads(text)))
        elif self.more is not None and kind != _VIOLATION:
            self.more(kind.decode(), text.decode())


def read_pulse(pulse: mmap.mmap) -> tuple[int, float, float, float]:
    """Return steps done, seconds of the run, and wall clock and CPU time of the last step.

    Parameters
    ----------
    pulse : mmap
        What the run's `Teller` has.
    """
    steps, time, wall, cpu = _PULSE.unpack(pulse[: _PULSE.size])
    return int(steps), float(time), float(wall), float(cpu)
