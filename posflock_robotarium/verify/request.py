"""What the verifier asks the fork server for: trials, and what each may use; one line of JSON."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from rps_compat.containment.usage import Allowance
from rps_compat.running.plan import RunPlan


@dataclass(frozen=True)
class Request:
    """Trials to be run.

    Attributes
    ----------
    plans : tuple of RunPlan
        What each trial runs, and how.
    preload : tuple of str
        Modules to import once, before any trial is forked.
    jobs : int
        Trials at a time.
    stall : float
        Seconds of computing without a step after which a trial is ended.
    seconds : float
        Seconds of computing after which a trial is ended.
    allowance : Allowance
        What else a trial may use.
    """

    plans: tuple[RunPlan, ...]
    preload: tuple[str, ...]
    jobs: int
    stall: float
    seconds: float
    allowance: Allowance

    def line(self) -> str:
        """Return the request as one line."""
        return json.dumps(asdict(self)) + "\n"

    @classmethod
    def of(cls, line: str) -> Request:
        """Return the request that a line holds.

        Parameters
        ----------
        line : str
            JSON, as the method `line` writes it.
        """
        said = json.loads(line)
        plans = tuple(RunPlan.from_dict(plan) for plan in said.pop("plans"))
        allowance = Allowance(**said.pop("allowance"))
        return cls(plans, tuple(said.pop("preload")), **said, allowance=allowance)
