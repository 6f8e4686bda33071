"""What a person does with a bundle: which files to upload, and what to enter where."""

from __future__ import annotations

import math

from posflock_robotarium.submission.manifest import MANIFEST
from posflock_robotarium.submission.upload_folder import Bundle
from posflock_robotarium.verify.findings import count
from posflock_robotarium.verify.initial_drive_time import predicted_drive
from rps_compat import testbed

#: Name of the file that holds them.
INSTRUCTIONS = "SUBMIT.md"


def instructions(ready: Bundle) -> str:
    """Return the instructions for a bundle, as Markdown.

    Parameters
    ----------
    ready : Bundle
        What was laid out for the upload.
    """
    size = math.ceil(ready.size / 1024)
    robots = f"{ready.robots}" if ready.robots else "as many as the script asks for"
    duration = (
        f"{ready.duration:.0f} s (the run, and a slow drive of {robots} robots to their start)"
        if ready.duration
        else "the run's length and a slow drive to the start"
        f" ({predicted_drive(testbed.MAX_ROBOTS).most:.0f} s for {testbed.MAX_ROBOTS} robots), at"
        f" most {testbed.MAX_DURATION:.0f} s"
    )
    lines = [
        f"# Submitting {ready.main}",
        "",
        f"Upload every file of this folder except `{INSTRUCTIONS}` and `{MANIFEST}`:"
        f" {count(len(ready.files), 'file')}, {size} KiB. Do not upload the simulator.",
        "",
        *(f"- **Mind** {warning}" for warning in ready.warnings),
        *([""] if ready.warnings else []),
        "| field | enter |",
        "|---|---|",
        f"| Main file | `{ready.main}` |",
        f"| Number of robots | {robots} |",
        f"| Duration | {duration} |",
        "",
        f"`sha256sum -c {MANIFEST}` checks the files.",
        "",
        "| file | bytes |",
        "|---|---|",
        *(f"| `{name}` | {len(content)} |" for name, content in sorted(ready.files.items())),
    ]
    if ready.left_out:
        lines += ["", "Left out, for they need libraries that the testbed has not:", ""]
        lines += [f"- `{name}` ({library})" for name, library in sorted(ready.left_out.items())]
    return "\n".join(lines) + "\n"
