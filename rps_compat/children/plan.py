"""What a process that is started afresh has to know of the run that it belongs to.

It stands in the environment, as JSON. The profile, and the function that opens logs, are handed on
by `pickle`, functions by their names; what cannot be handed on is told, and refused where it is
needed, since robots without the run's imperfections would be other robots.
"""

import base64
import json
import os
import pickle
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rps_compat.children import VARIABLE
from rps_compat.errors import RobotariumError
from rps_compat.realism import Profile
from rps_compat.recording import OpenRecorder
from rps_compat.session import Initial


class ChildError(RobotariumError):
    """A process that was started afresh cannot have all that the run has."""


@dataclass(frozen=True)
class Plan:
    """What one process hands to those that it starts.

    Attributes
    ----------
    script, generation, seed, initial, headless, out
        Those of the run.
    handed
        Pickle of the profile and of what opens logs, in base 64; empty if it cannot be.
    lost
        Why it cannot.
    room
        Folder where the processes of the run keep their records.
    within, entropy, identity
        Name of the process, as `rps_compat.children.names.Name` has it.
    """

    script: str
    generation: int
    seed: int | None
    initial: Initial
    headless: bool
    out: str | None
    handed: str = ""
    lost: str = ""
    room: str = ""
    within: str = ""
    entropy: tuple[int, ...] = ()
    identity: tuple[int, ...] = ()

    def text(self) -> str:
        """Return the plan as it stands in the environment."""
        return json.dumps(asdict(self))

    def guests(self) -> tuple[Profile | None, OpenRecorder | None]:
        """Return the profile, and what opens logs.

        Raises
        ------
        ChildError
            They could not be handed on.
        """
        if self.lost:
            raise ChildError(
                f"this process was started afresh and cannot have what its run has: {self.lost}; "
                "give RunSettings a recorder that stands in a module, such as "
                "posflock_robotarium.logs.recorder.open_pose_log"
            )
        profile, open_log = pickle.loads(base64.b64decode(self.handed))
        return profile, open_log


def hand_on(*guests: Any) -> tuple[str, str]:
    """Return `handed` and `lost` of a plan for a profile and what opens logs.

    Parameters
    ----------
    *guests : object
        What is handed on; anything that can be pickled.
    """
    try:
        return base64.b64encode(pickle.dumps(guests)).decode(), ""
    except Exception as error:  # whatever a user's object raises when it is pickled
        return "", f"{type(error).__name__}: {error}"


def plan_of_this_process() -> Plan | None:
    """Read the plan that this process was started with; None without, or when the run is over."""
    text = os.environ.get(VARIABLE)
    if text is None:
        return None
    fields = json.loads(text)
    for name in ("entropy", "identity"):
        fields[name] = tuple(fields[name])
    plan = Plan(**fields)
    return plan if Path(plan.room).is_dir() else None
