"""What is run, and how: plain data, so that another process can obey it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from typing import Any

from barrier_certificates.word_enum import WordEnum
from rps_compat.generations import Generation
from rps_compat.running.policy_violations import PolicyKind
from rps_compat.session import Initial


class ClockPolicy(WordEnum):
    """Which time a script sees."""

    #: The computer's.
    REAL = "real"
    #: A step takes its time step, whatever was computed.
    SIMULATED = "simulated"
    #: The same, and computing takes its CPU time.
    CHARGED = "charged"


@dataclass(frozen=True)
class RunPlan:
    """What is run, and how; JSON holds it.

    Attributes
    ----------
    script : str
        The main file as it is called, ``sys.argv[0]``: absolute, or within `folder`.
    folder : str
        Where it runs: the script's own.
    generation : int
        Of the API, 1 or 2.
    arguments : tuple of str
        The script's own.
    path : tuple of str
        Further folders to import from.
    name : str
        Of the run among others, such as ``trial-007``.
    initial : str
        How the robots come to their initial conditions; see `rps_compat.session.Session`.
    seed : int, optional
        Of what is random in the robots: imperfections and arrival.
    script_seed : int, optional
        Of Python's and numpy's global generators; None leaves them as they are.
    profile : dict, optional
        The imperfections, as a table; None is the ideal arena.
    clock : ClockPolicy
        Which time the script sees.
    wait : bool, optional
        Whether a script that wants real time gets it where the clock is real; None where somebody
        can see it.
    draws_on_demand : bool
        Whether windows are replaced by drawing where a picture is asked for.
    answers : tuple of str, optional
        What ``input()`` answers, after which it answers an empty line; None lets it ask.
    keeps_apart : bool
        Whether the script's files are kept from hiding modules of Python and of libraries.
    bridges : tuple of str
        Which kinds of names that libraries dropped are put back; see
        `rps_compat.scripts.changes.Kind`. With any, one-element arrays are numbers as of old.
    children : bool
        Whether what the script starts belongs to the run.
    exit_functions : bool
        Whether functions that the script registers to run at exit are run: for a process that ends
        without them.
    forbidden : tuple of PolicyKind
        What policy forbids; see `rps_compat.running.policy`.
    forbidden_to_libraries : bool
        Whether that holds for what libraries do of their own accord, too.
    measures : bool
        Whether gaps, loop times and silence are measured.
    timeout : float, optional
        Real seconds after which the script is stopped.
    longest : float, optional
        Seconds of the run after which it is interrupted, as the testbed does.
    interrupt_at, kill_at : float, optional
        Seconds of the run at which a KeyboardInterrupt comes out of ``step()``, or the process is
        killed.
    only_start : bool
        Whether enough has been seen when the robots are at their initial conditions.
    kills_deaf : bool
        Whether a script that goes on after ten interruptions is killed, instead of stopped by an
        exception.
    memory : int, optional
        Bytes that the process may allocate from now on.
    disk : int, optional
        Bytes that one file may have.
    out : str, optional
        Folder for what the run leaves; None leaves nothing.
    snapshots : tuple of float
        Times of the run in seconds at which the figure is saved.
    video : str, optional
        File to film to.
    writable : tuple of str
        Folders besides `folder` in which policy lets it write.
    """

    script: str
    folder: str
    generation: Generation
    arguments: tuple[str, ...] = ()
    path: tuple[str, ...] = ()
    name: str = ""
    initial: Initial = "published"
    seed: int | None = None
    script_seed: int | None = None
    profile: dict[str, Any] | None = None
    clock: ClockPolicy = ClockPolicy.REAL
    wait: bool | None = None
    draws_on_demand: bool = False
    answers: tuple[str, ...] | None = None
    keeps_apart: bool = True
    bridges: tuple[str, ...] = ()
    children: bool = False
    exit_functions: bool = False
    forbidden: tuple[PolicyKind, ...] = ()
    forbidden_to_libraries: bool = False
    measures: bool = False
    timeout: float | None = None
    longest: float | None = None
    interrupt_at: float | None = None
    kill_at: float | None = None
    only_start: bool = False
    kills_deaf: bool = False
    memory: int | None = None
    disk: int | None = None
    out: str | None = None
    snapshots: tuple[float, ...] = ()
    video: str | None = None
    writable: tuple[str, ...] = ()

    def text(self) -> str:
        """Return the plan as JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> RunPlan:
        """Return the plan that ``asdict`` gave, or JSON of it.

        Parameters
        ----------
        data : dict
            What it gave.
        """
        known = {field.name for field in fields(cls)}
        plain: dict[str, Any] = {name: data[name] for name in known & data.keys()}
        for name, value in plain.items():
            if isinstance(value, list):
                plain[name] = tuple(value)
        if "clock" in plain:
            plain["clock"] = ClockPolicy(plain["clock"])
        plain["forbidden"] = tuple(PolicyKind(kind) for kind in plain.get("forbidden", ()))
        return cls(**plain)

    @property
    def profile_name(self) -> str:
        """Name of the profile."""
        return "ideal" if self.profile is None else str(self.profile.get("name", "ideal"))
