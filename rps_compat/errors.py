"""What a Robotarium script can do wrong, each with a name.

Every class also derives from the exception that the published simulators raise in the same place
(``AssertionError``, ``ValueError``, ``IndexError``), so that a script that catches theirs catches
ours; ``except RobotariumError`` catches them all, and ``except PosflockError`` whatever else this
distribution raises besides.
"""

from barrier_certificates.certificate_errors import PosflockError


class RobotariumError(PosflockError):
    """A mistake of the script: the message says what was got, what was expected, what to do."""


class ConstructorError(RobotariumError, AssertionError, ValueError):
    """An argument of ``Robotarium(...)`` is of the wrong type or outside its range."""


class InitialConditionsError(ConstructorError, IndexError):
    """Initial conditions of the wrong shape or type, not finite, outside the arena or touching."""


class CommandError(RobotariumError, ValueError, IndexError):
    """Velocities that no robot can be given: not finite, or of the wrong shape."""


class CallOrderError(RobotariumError, AssertionError):
    """``get_poses`` and ``step`` must alternate: one of each, in that order, every time step."""


class WrongGenerationError(RobotariumError, AttributeError):
    """A name of the other generation of the API; the message gives the right one."""


class WrongArgumentError(WrongGenerationError, TypeError):
    """An argument of the other generation's constructor."""


class UnreachableError(RobotariumError, RuntimeError):
    """The robots could not be driven to the initial conditions; the message says which and why."""


class ScriptError(RobotariumError, OSError):
    """The script cannot be run at all: not found, not Python, a folder that cannot be written."""
