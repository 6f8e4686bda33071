"""``python -m rps_compat run SCRIPT`` and ``python -m rps_compat path --generation 2``."""

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import entry_points
from pathlib import Path
from typing import get_args

from barrier_certificates.certificate_errors import PosflockError
from rps_compat.install import import_path
from rps_compat.process import run_and_tell
from rps_compat.recording import OpenRecorder
from rps_compat.run_settings import RunSettings, snapshot_times
from rps_compat.session import Initial
from rps_compat.terminal import printable

#: Packages offer recorders under this group; the first is used.
RECORDERS = "rps_compat.recorders"


def offered_recorder() -> OpenRecorder | None:
    """Find the recorder that an installed package offers for `RECORDERS`; None if there is none."""
    for entry in entry_points(group=RECORDERS):
        recorder: OpenRecorder = entry.load()
        return recorder
    return None


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(prog="python -m rps_compat", description=__doc__)
    commands = top.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="run a Robotarium script as it is")
    run.add_argument(
        "--generation", type=int, choices=(1, 2), help="found from the script by default"
    )
    shown = run.add_mutually_exclusive_group()
    shown.add_argument(
        "--headless",
        action="store_true",
        default=None,
        help="no window and no waiting; the default where there is no display",
    )
    shown.add_argument("--window", dest="headless", action="store_false", help="show the arena")
    run.add_argument("--initial", choices=get_args(Initial), default="published")
    run.add_argument(
        "--seed",
        type=int,
        help="of Python's and numpy's global generators: on one machine, the same bytes",
    )
    run.add_argument("--timeout", type=float, help="seconds of real time")
    run.add_argument("--input", action="append", default=[], help="an answer to input()")
    run.add_argument("--snapshot", default="", help="times in seconds: 0,10,end")
    run.add_argument("--video", type=Path, help="file to film to: .mp4 or .gif")
    run.add_argument("-o", "--out", type=Path, help="folder for log and report")
    run.add_argument("--json", action="store_true", help="print the report as JSON")
    run.add_argument("script", type=Path)
    run.add_argument("arguments", nargs=argparse.REMAINDER, help="the script's own arguments")
    path = commands.add_parser("path", help="print what to put on PYTHONPATH")
    path.add_argument("--generation", type=int, choices=(1, 2), default=2)
    return top


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code.

    Parameters
    ----------
    words : sequence of str, optional
        What follows the command's name; by default that of this process.
    """
    asked = parser().parse_args(words)
    if asked.command == "path":
        print(import_path(asked.generation))
        return 0
    settings = RunSettings(
        generation=asked.generation,
        headless=asked.headless,
        initial=asked.initial,
        seed=asked.seed,
        timeout=asked.timeout,
        answers=asked.input,
        out=asked.out,
        snapshots=snapshot_times(asked.snapshot),
        video=asked.video,
        recorder=offered_recorder(),
        tell=lambda note: print(printable(f"note: {note}"), file=sys.stderr, flush=True),
    )
    return run_and_tell(asked.script, asked.arguments, settings, asked.json)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except PosflockError as error:
        print(printable(f"rps_compat: {error}"), file=sys.stderr)
        sys.exit(2)
