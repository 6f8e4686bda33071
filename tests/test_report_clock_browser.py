"""The two clocks of a run in a real browser: curves over either, the drive shaded, gains drawn."""

import numpy as np
import pytest
from test_following import STEP, a_run
from test_report_browser import (
    SCREENSHOTS,
    SIZES,
    browser,
    cursor_of,
    now,
    open_page,
    page_file,
    pytestmark,
    until,
)

from posflock_robotarium.alignment.options import AnalysisOptions
from posflock_robotarium.report import analyse
from posflock_robotarium.report.page import write_page

__all__ = ["browser", "open_page", "page_file", "pytestmark"]


@pytest.fixture(scope="module")
def two_clocks(tmp_path_factory):
    """A run of 19.8 s by its steps that took 39.8 s: it stood for 20 s in its middle."""
    real_time = np.arange(600) * STEP
    real_time[300:] += 20.0
    run = a_run(real_time=real_time)
    path = tmp_path_factory.mktemp("clocks") / "report.html"
    return write_page([analyse(run, AnalysisOptions(drive=4.0))], path)


def test_curves_are_drawn_over_either_clock(open_page, two_clocks):
    page = open_page(file=two_clocks)
    page.evaluate("posflock.seek(14.85)")  # three quarters by the steps
    until(page, "document.querySelectorAll('.u-cursor-x').length > 0")
    assert cursor_of(page) == pytest.approx(0.75, abs=0.02)
    page.select_option("#axis", "real")
    page.wait_for_timeout(100)
    assert now(page) == pytest.approx(14.85, abs=0.05)
    assert cursor_of(page) == pytest.approx(34.85 / 39.77, abs=0.02)
    page.select_option("#axis", "steps")
    page.wait_for_timeout(100)
    assert cursor_of(page) == pytest.approx(0.75, abs=0.02)


def test_a_click_goes_to_the_time_that_is_shown(open_page, two_clocks):
    page = open_page(file=two_clocks)
    page.select_option("#axis", "real")
    plot = page.locator(".u-over").first
    box = plot.bounding_box()
    plot.click(position={"x": box["width"] * 34.85 / 39.77, "y": 20})
    assert now(page) == pytest.approx(14.85, abs=0.3)


#: Coloured points of the first chart within a tenth of its width, in the middle.
COLOURED = """() => {
  const canvas = document.querySelector(".u-wrap canvas"), w = canvas.width, h = canvas.height;
  const copy = new OffscreenCanvas(w, h).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0.45 * w, 0, 0.1 * w, h);
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    const [r, g, b] = data.slice(k, k + 3);
    if (data[k + 3] > 99 && Math.max(r, g, b) - Math.min(r, g, b) > 60) count += 1;
  }
  return count;
}"""


def test_a_stall_is_a_gap_over_real_time_alone(open_page, two_clocks):
    page = open_page(file=two_clocks)
    page.evaluate("posflock.seek(1)")
    until(page, f"({COLOURED})() > 50")
    page.select_option("#axis", "real")
    until(page, f"({COLOURED})() === 0")


@pytest.mark.parametrize("size", SIZES)
def test_steps_drive_and_gains_are_photographed(open_page, two_clocks, size):
    page = open_page(size, file=two_clocks)
    assert page.locator("#following svg").count() == 3
    assert "Time that each step took" in page.locator("#plots").inner_text()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=SCREENSHOTS / f"clocks-{size}.png", full_page=True)


def test_a_page_without_real_time_has_no_switch(open_page):
    assert open_page().locator("#axis").count() == 0
