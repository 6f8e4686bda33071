"""What was laid out for the upload: the folder, its files, and what is to be entered with them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from posflock_robotarium.submission.manifest import Manifest


@dataclass(frozen=True)
class Bundle:
    """A folder ready to be uploaded.

    Attributes
    ----------
    folder : Path
        Where it lies.
    main : str
        Name of the main file.
    files : dict of str to bytes
        What is to be uploaded, by name.
    left_out : dict
        Modules that were left out → the library they need, which the testbed has not.
    robots : int, optional
        To be entered at submission, where known.
    duration : float, optional
        To be entered at submission, s, where known.
    warnings : tuple of str
        What will stop it on the testbed, though it can be laid flat.
    """

    folder: Path
    main: str
    files: dict[str, bytes]
    left_out: dict[str, str]
    robots: int | None = None
    duration: float | None = None
    warnings: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Bytes to upload."""
        return sum(len(content) for content in self.files.values())

    @property
    def manifest(self) -> Manifest:
        """What is to be uploaded, and how it is to be run."""
        return Manifest.of(self.files, self.main, self.robots, self.duration)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, ready for JSON: of each file its bytes."""
        return {
            "folder": str(self.folder),
            "main": self.main,
            "files": {name: len(content) for name, content in sorted(self.files.items())},
            "left_out": self.left_out,
            "robots": self.robots,
            "duration": self.duration,
            "warnings": list(self.warnings),
        }
