"""How much a reader takes in: asked before memory is taken, told with the option that raises it."""

from __future__ import annotations

from dataclasses import dataclass

from posflock_robotarium.flocking.errors import LogError, ParameterError

LONGEST_LINE = 1 << 20
"""Letters of one line of text (50 robots need 3,000)."""

TEXT_TAKES = 4
"""Bytes of memory that a byte of text takes while it is read."""


@dataclass(frozen=True)
class Bounds:
    """The largest log that is read.

    Parameters
    ----------
    megabytes : float
        Of one file, and of what it unpacks to in memory (900 s of 50 robots are 33 MB).
    robots : int
        Of one run.

    Raises
    ------
    ParameterError
        Where one of them is not above 0.
    """

    megabytes: float = 256.0
    robots: int = 200

    def __post_init__(self) -> None:
        if not 0.0 < self.megabytes < 1e9:
            raise ParameterError(f"--max-size is {self.megabytes}; expected megabytes above 0")
        if self.robots < 1:
            raise ParameterError(f"--max-robots is {self.robots}; expected a number from 1")

    @property
    def bytes(self) -> int:
        """Bytes of one file, and of what it unpacks to."""
        return int(self.megabytes * 2**20)

    def require_size(self, size: int, where: str) -> None:
        """Refuse a file that is, or claims to unpack to, more than that.

        Parameters
        ----------
        size : int
            Bytes that it takes in memory.
        where : str
            File (and variable) name for messages.

        Raises
        ------
        LogError
            Saying how much it is, and how to read it all the same.
        """
        if size > self.bytes:
            raise LogError(
                f"{where}: takes {size / 2**20:.1f} MB of memory, more than {self.megabytes:g} MB;"
                " read it all the same with --max-size"
            )

    def require_robots(self, robots: int, where: str) -> None:
        """Refuse more robots than that.

        Parameters
        ----------
        robots : int
            Robots of a run.
        where : str
            File (and variable) name for messages.

        Raises
        ------
        LogError
            Saying how many they are, and how to read them all the same.
        """
        if robots > self.robots:
            raise LogError(
                f"{where}: {robots} robots, more than {self.robots}; where they are robots indeed,"
                " read them with --max-robots"
            )


BOUNDS = Bounds()
"""Those that hold where nobody says otherwise."""
