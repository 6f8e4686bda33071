"""What the error that ended a script may mean, beyond what it says.

Two errors are no fault of the line that they come from. A script that does not tell its generation,
or knows both, may have run as the wrong one. And a library here may be newer than the testbed's,
and refuse what runs there.
"""

from __future__ import annotations

import re

from rps_compat.errors import RobotariumError, WrongArgumentError
from rps_compat.generations import Generation
from rps_compat.one_element_arrays import takes_one_element
from rps_compat.scripts.changes import CHANGES, Kind
from rps_compat.scripts.evidence import GenerationEvidence
from rps_compat.scripts.generation_names import (
    ATTRIBUTES,
    FUNCTIONS,
    NEW_ARGUMENTS,
    NEW_ATTRIBUTES,
    NEW_FUNCTIONS,
)
from rps_compat.scripts.libraries import GONE_SINCE, LIBRARIES, PYTHON

#: Every name that one generation has and the other has not.
_NAMES = frozenset(
    name
    for names in (
        FUNCTIONS, FUNCTIONS.values(), NEW_FUNCTIONS, ATTRIBUTES, ATTRIBUTES.values(),
        NEW_ATTRIBUTES, NEW_ARGUMENTS,
    )
    for name in names
    if name
)  # fmt: skip
#: What numpy says from 2.4 on of an array of one element where a number is wanted.
_ONE_ELEMENT = {
    "TypeError": "only 0-dimensional arrays can be converted to Python scalars",
    "ValueError": "setting an array element with a sequence.",
}
#: What Python says of a name that is not there.
_NO_SUCH_NAME = {
    "AttributeError": r"module '(?P<module>[\w.]+)' has no attribute '(?P<name>\w+)'",
    "ImportError": r"cannot import name '(?P<name>\w+)' from '(?P<module>[\w.]+)'",
    "ModuleNotFoundError": r"No module named '(?P<name>[\w.]+)'(?P<module>)",
}
#: What to do about an error that a newer library makes.
REHEARSE = "`posflock bundle` and `posflock rehearse` run it with the testbed's versions"


def hint(error: BaseException, evidence: GenerationEvidence, generation: Generation) -> str | None:
    """Return what to try after `error` ended a script that ran as `generation`; None if nothing.

    Parameters
    ----------
    error : BaseException
        What ended it.
    evidence : GenerationEvidence
        What the script's source says about its generation.
    generation : int
        1 or 2.
    """
    other: Generation = 2 if generation == 1 else 1
    if not evidence.stopping(other) and _is_about_the_api(error):
        says = "does not say" if not evidence.certain else "says otherwise"
        return (
            f"this ran as generation {generation} of the API, and the script's source {says}: "
            f"--generation {other} runs it as generation {other}"
        )
    newer = newer_library(type(error).__name__, str(error))
    return f"{newer}; {REHEARSE}" if newer else None


def _is_about_the_api(error: BaseException) -> bool:
    if isinstance(error, RobotariumError) and not isinstance(error, WrongArgumentError):
        return True
    if isinstance(error, ImportError):
        return (error.name or "").partition(".")[0] == "rps"
    if isinstance(error, (AttributeError, NameError, TypeError)):
        return bool(set(re.findall(r"'(\w+)'", str(error))) & _NAMES)
    return False


def newer_library(kind: str, message: str) -> str | None:
    """Say that an error is a newer library's and not the testbed's; None if it is not.

    Parameters
    ----------
    kind : str
        Name of the exception.
    message : str
        What it says.
    """
    if _ONE_ELEMENT.get(kind) == message and not takes_one_element():
        return _told(f"numpy {LIBRARIES['numpy']} takes arrays of one element for numbers")
    found = re.match(_NO_SUCH_NAME.get(kind, "$."), message)
    if found is None:
        return None
    path = f"{found['module']}.{found['name']}".strip(".")
    change = CHANGES.get(path)
    if change is not None and change.kind is Kind.LATER:
        return _told(f"{change.library} has {path}")
    if path.partition(".")[0] in GONE_SINCE:
        return _told(f"Python {PYTHON[0]}.{PYTHON[1]} has {path}")
    return None


def _told(has: str) -> str:
    return f"the testbed's {has}, this machine's newer one does not: no fault of the script"
