"""What is in a bundle, for programs: which files, which is the main one, what to enter.

The file reads as ``sha256sum`` writes it, so that ``sha256sum -c MANIFEST`` checks the upload. What
else there is to know stands as JSON in its first line, a comment to ``sha256sum``.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from posflock_robotarium.submission.upload_names import BundleError, require_upload_names
from rps_compat.bounded_files import read_bounded

__all__ = ["MANIFEST", "BundleError", "Manifest", "check_manifest", "read_manifest"]
#: Name of the file.
MANIFEST = "MANIFEST"
#: Version of its format; a later format has another number.
SCHEMA = "posflock bundle 1"
#: Bytes that one file of an upload may have.
LARGEST_FILE = 256 << 20
#: A line as ``sha256sum`` writes it.
_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


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
        Where `folder` holds no bundle, one of another format, or one with names that are none.
    """
    try:
        text = read_bounded(folder / MANIFEST).decode("utf-8")
    except FileNotFoundError as error:
        raise BundleError(
            f"{folder}: holds no {MANIFEST}; `posflock bundle SCRIPT -o {folder}` makes a bundle"
        ) from error
    except OSError as error:
        raise BundleError(
            f"{folder / MANIFEST}: cannot be read ({error.strerror or error})"
        ) from error
    except UnicodeDecodeError as error:
        raise BundleError(f"{folder / MANIFEST}: not UTF-8 text ({error})") from error
    manifest = _parsed(text)
    if manifest is None:
        raise BundleError(
            f"{folder}: {MANIFEST} is none of this version of posflock, or was changed; make the"
            " bundle again in a new folder"
        )
    try:
        require_upload_names(manifest.files)
    except BundleError as error:
        raise BundleError(f"{folder / MANIFEST}: {error}") from error
    return manifest


def _parsed(text: str) -> Manifest | None:
    """Return what a manifest says; None where it is none of this format."""
    first, *lines = text.removesuffix("\n").split("\n")
    sums = [_LINE.fullmatch(line) for line in lines]
    try:
        head = json.loads(first.removeprefix("#"))
        main, robots, duration = head["main"], head["robots"], head["duration"]
        known = head["schema"] == SCHEMA
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    files = {found[2]: found[1] for found in sums if found}
    sound = (
        known
        and len(files) == len(lines)
        and isinstance(main, str)
        and main in files
        and (robots is None or type(robots) is int)
        and (duration is None or (type(duration) in (int, float) and math.isfinite(duration)))
    )
    return Manifest(main, files, robots, duration) if sound else None


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
            content = read_bounded(folder / name, LARGEST_FILE)
        except FileNotFoundError as error:
            raise BundleError(f"{folder}: {name} is missing; make the bundle again") from error
        except OSError as error:
            raise BundleError(f"{folder}: {name}: {error.strerror or error}") from error
        if hashlib.sha256(content).hexdigest() != digest:
            raise BundleError(f"{folder}: {name} was changed since; make the bundle again")
    return manifest
