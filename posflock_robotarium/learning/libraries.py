"""What is said where a library of environments is not installed."""

from __future__ import annotations

from posflock_robotarium.flocking.errors import PosflockError

__all__ = ["LearningLibraryError"]


class LearningLibraryError(PosflockError, ImportError):
    """An interface for learners was asked for whose library is not installed.

    Parameters
    ----------
    interface : str
        What was asked for.
    library : str
        What it needs.
    """

    def __init__(self, interface: str, library: str | None) -> None:
        super().__init__(
            f"{interface} needs {(library or interface).partition('.')[0]}, which is not installed:"
            " pip install 'posflock-robotarium[learn]'"
        )
