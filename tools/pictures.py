"""Renews the pictures of README and documentation that show what the program draws.

    python tools/pictures.py [nine-robots] [report] [watch]     # `make pictures` renews all three

They are what anybody gets: the figure that `posflock demo` leaves, the page that `posflock report`
makes of its log, the live page of `posflock watch`. Pages are opened in Chromium, as the tests of
pages do. Three other pictures are benchmarks' own and renewed with their figures:
`benchmarks/barrier_speed.py` draws ``barrier-speed.png``, `benchmarks/freespace_speed.py`
``growth.png``, `benchmarks/batch_growth.py` ``batch-growth.png``.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
POSFLOCK = [sys.executable, "-m", "posflock_robotarium"]
#: Width of the window; its height shows what a page has to say at first sight.
WIDE, REPORT_HIGH, WATCH_HIGH = 1280, 1076, 860
#: Seconds of the run at which pages are shown: aligned; turned away from a wall.
REPORT_AT, WATCH_AT = 60.0, 46.0


def demo(folder: Path) -> Path:
    """Fly the nine robots; return the folder of what they leave."""
    subprocess.run([*POSFLOCK, "demo", "-o", str(folder)], check=True, cwd=folder)
    return folder


@contextmanager
def opened(address: str, high: int) -> Iterator[Any]:
    """Open a page in Chromium, in a window so high."""
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("pictures of pages need chromium on the PATH")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDE, "height": high}, color_scheme="light")
        page.goto(address)
        yield page
        browser.close()


def shoot(page: Any, name: str) -> None:
    """Keep what a page shows."""
    page.screenshot(path=str(PICTURES / f"{name}.png"))
    print(PICTURES / f"{name}.png")


def picture_snapshots(results: Path) -> None:
    """Take the experiment's figure as it is drawn."""
    shutil.copyfile(results / "snapshots.png", PICTURES / "nine-robots.png")
    print(PICTURES / "nine-robots.png")


def picture_report(results: Path) -> None:
    """Show the report of the same run."""
    page_of = [*POSFLOCK, "report", str(results / "nine_robots.npy"), "--no-figures"]
    subprocess.run([*page_of, "-o", str(results / "report")], check=True)
    with opened((results / "report" / "report.html").as_uri(), REPORT_HIGH) as page:
        page.evaluate(f"posflock.seek({REPORT_AT})")
        page.wait_for_timeout(500)
        shoot(page, "report")


def picture_watch() -> None:
    """Show the live page of the same experiment, held."""
    words = ["watch", "--no-open", "--speed", "max", "--seed", "3"]
    script = ROOT / "experiments" / "robotarium_9bot.py"
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen(
            [*POSFLOCK, *words, str(script)], stdout=subprocess.PIPE, text=True, cwd=folder
        )
        try:
            assert process.stdout is not None
            found = (re.search(r"http://127\.0\.0\.1:\S+", line) for line in process.stdout)
            address = next(match[0] for match in found if match)
            with opened(address, WATCH_HIGH) as page:
                while not page.evaluate(f"posflock.state.frame?.time >= {WATCH_AT}"):
                    page.wait_for_timeout(10)
                page.evaluate("posflock.ask({do: 'pause'})")
                page.evaluate("posflock.ask({do: 'speed', factor: 1})")
                page.wait_for_timeout(500)
                shoot(page, "watch")
        finally:
            process.terminate()
            process.wait()


def main() -> int:
    """Renew what is asked for; return the exit code."""
    names = ("nine-robots", "report", "watch")
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(names)}; by default all")
    asked = parser.parse_args().names or names
    if unknown := set(asked) - set(names):
        parser.error(f"no picture {', '.join(sorted(unknown))}: there are {', '.join(names)}")
    with tempfile.TemporaryDirectory() as folder:
        results = demo(Path(folder)) if {"nine-robots", "report"} & set(asked) else Path(folder)
        if "nine-robots" in asked:
            picture_snapshots(results)
        if "report" in asked:
            picture_report(results)
        if "watch" in asked:
            picture_watch()
    return 0


if __name__ == "__main__":
    sys.exit(main())
