"""What a process that is started afresh has to know of the run that it belongs to.

It stands in the environment, as JSON. Functions that make imperfections or open logs are handed on
by `pickle`, by their names; what cannot be handed on is told, and refused where it is needed, since
robots without the run's imperfections would be other robots.
"""

import base64
import json
import os
import pickle
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rps_compat.arena import Realism
from rps_compat.children import VARIABLE
from rps_compat.errors import RobotariumError
from rps_compat.recording import OpenRecorder
from rps_compat.session import Initial

MakeRealism = Callable[[], Realism | None]


class ChildError(RobotariumError):
    """A process that was started afresh cannot have all that the run has."""


@dataclass(frozen=True)
class Plan:
    """What one process hands to those that it starts.

    Attributes
    ----------
    script, api, seed, initial, headless, out
        Those of the run.
    handed
        Pickle of what makes imperfections and opens logs, in base 64; empty if it cannot be.
    lost
        Why it cannot.
    room
        Folder where the processes of the run keep their records.
    within, entropy, identity
        Name of the process, as `rps_compat.children.names.Name` has it.
    """

    script: str
    api: int
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

    def functions(self) -> tuple[MakeRealism | None, OpenRecorder | None]:
        """Return what makes imperfections, and what opens logs.

        Raises
        ------
        ChildError
            They could not be handed on.
        """
        if self.lost:
            raise ChildError(
                f"this process was started afresh and cannot have what its run has: {self.lost}; "
                "give RunSettings functions that stand in a module, such as "
                "load_profile('gritsbot_x').start"
            )
        realism, open_log = pickle.loads(base64.b64decode(self.handed))
        return realism, open_log


def hand_on(*functions: Any) -> tuple[str, str]:
    """Return `handed` and `lost` of a plan for what makes imperfections and opens logs."""
    try:
        return base64.b64encode(pickle.dumps(functions)).decode(), ""
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
