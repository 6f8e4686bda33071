"""What is in a bundle, for programs: which files, which is the main one, what to enter.

The file reads as ``sha256sum`` writes it, so that ``sha256sum -c MANIFEST`` checks the upload. What
else there is to know stands as JSON in its first line, a comment to ``sha256sum``.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from posflock_robotarium.flocking.errors import PosflockError

#: Name of the file.
MANIFEST = "MANIFEST"
#: Version of its format; a later format has another number.
SCHEMA = "posflock bundle 1"


class BundleError(PosflockError):
    """The script cannot be laid flat as it is; the message says why, and the way out."""


@dataclass(frozen=True)
class Manifest:
    """What is in a bundle.

    Attributes
    ----------
    main : str
        Name of the main file.
    files : dict of str to str
        sha256 sum of each file to upload, by name.
    robots : int, optional
        To be entered at submission, where known.
    duration : float, optional
        To be entered at submission, s, where known.
    """

    main: str
    files: dict[str, str]
    robots: int | None = None
    duration: float | None = None

    @classmethod
    def of(
        cls, files: Mapping[str, bytes], main: str, robots: int | None, duration: float | None
    ) -> Manifest:
        """Return the manifest of files.

        Parameters
        ----------
        files : mapping of str to bytes
            What each file to upload holds, by name.
        main : str
            Name of the main file.
        robots : int or None
            To be entered at submission; None where unknown.
        duration : float or None
            To be entered at submission, s; None where unknown.
        """
        sums = {name: hashlib.sha256(files[name]).hexdigest() for name in sorted(files)}
        return cls(main, sums, robots, duration)

    def text(self) -> str:
        """Return what the file holds."""
        head = {
            "schema": SCHEMA,
            "main": self.main,
            "robots": self.robots,
            "duration": self.duration,
        }
        sums = "".join(f"{digest}  {name}\n" for name, digest in self.files.items())
        return f"# {json.dumps(head)}\n{sums}"


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of a bundle.

    Parameters
    ----------
    folder : Path
        The bundle's folder.

    Raises
    ------
    BundleError
        Where `folder` holds no bundle, or one of another format.
    """
    try:
        first, *lines = (folder / MANIFEST).read_text(encoding="utf-8").splitlines() or [""]
    except OSError as error:
        raise BundleError(
            f"{folder}: holds no {MANIFEST}; `posflock bundle SCRIPT -o {folder}` makes a bundle"
        ) from error
    try:
        head = json.loads(first.removeprefix("#"))
        known = head["schema"] == SCHEMA
        files = {line[66:]: line[:64] for line in lines}
        if known and head["main"] in files:
            return Manifest(head["main"], files, head["robots"], head["duration"])
    except (ValueError, KeyError, TypeError):
        pass
    raise BundleError(
        f"{folder}: {MANIFEST} is none of this version of posflock, or was changed; make the"
        " bundle again in a new folder"
    )


def check_manifest(folder: Path) -> Manifest:
    """Read the manifest of a bundle whose files are all present and unchanged.

    Parameters
    ----------
    folder : Path
        The bundle's folder.

    Raises
    ------
    BundleError
        Where one is missing, or is not the one that was bundled.
    """
    manifest = read_manifest(folder)
    for name, digest in manifest.files.items():
        try:
            content = (folder / name).read_bytes()
        except OSError as error:
            raise BundleError(f"{folder}: {name} is missing; make the bundle again") from error
        if hashlib.sha256(content).hexdigest() != digest:
            raise BundleError(f"{folder}: {name} was changed since; make the bundle again")
    return manifest
