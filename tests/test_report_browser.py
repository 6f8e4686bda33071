"""The page in a real browser, from disk, with no network: it replays, scrubs, zooms and listens.

Screenshots are kept in the folder named by POSFLOCK_SCREENSHOTS (by default
build/screenshots), to be looked at.
"""

import dataclasses
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.report import analyse
from posflock_robotarium.report.page import write_page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium on the PATH"),
]
ROOT = Path(__file__).parents[1]
SCREENSHOTS = Path(os.environ.get("POSFLOCK_SCREENSHOTS", ROOT / "build" / "screenshots"))
ARGUMENTS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
SIZES = {"1280": {"width": 1280, "height": 900}, "390": {"width": 390, "height": 844}}


def a_run(name="ring", parameters=None):
    """Ten robots on a ring; two of them meet at 12 s, and half a second is missing at 20 s."""
    flock = known_flock("rotating", 0.1, duration=30.0)
    poses = flock.recording.poses.copy()
    poses[364:380, :2, 1] = poses[364:380, :2, 0] + 0.05
    keep = np.r_[0:606, 621 : len(poses)]
    return analyse(
        dataclasses.replace(
            flock.recording,
            name=name,
            t=flock.recording.t[keep],
            poses=poses[keep],
            parameters=parameters or {},
        ),
        radius=flock.radius,
    )


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield running
        running.close()


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    hostile = "</script><script>document.title='owned'</script><img src=x onerror=alert(1)>"
    path = tmp_path_factory.mktemp("page") / "report.html"
    return write_page([a_run(parameters={hostile: hostile})], path)


@pytest.fixture
def open_page(browser, page_file):
    """Open the page at a size; whatever it says to the console or asks the network for fails."""
    opened, complaints = [], []

    def opener(size="1280", scheme="light", file=page_file, touch=False):
        context = browser.new_context(
            viewport=SIZES[size], color_scheme=scheme, has_touch=touch, offline=True
        )
        page = context.new_page()
        page.set_default_timeout(10_000)
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("dialog", lambda dialog: complaints.append(dialog.message))
        page.on(
            "request",
            lambda request: (
                None
                if request.url.startswith(("file:", "data:"))
                else complaints.append(request.url)
            ),
        )
        page.goto(f"file://{file}")
        opened.append(context)
        return page

    yield opener
    for context in opened:
        context.close()
    assert complaints == []


def until(page, condition, seconds=10):
    """Wait for a condition; the page's own policy forbids what would wait inside it."""
    for _ in range(int(seconds * 50)):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(20)
    pytest.fail(f"{condition} did not come true in {seconds} s")


def now(page):
    return page.evaluate("posflock.state.time")


def cursor_of(page, k=0):
    """Time under the cursor of a plot, read back from where its line is drawn."""
    return page.evaluate(
        """k => {
            const line = document.querySelectorAll('.u-cursor-x')[k];
            const over = line.parentElement;
            const x = new DOMMatrix(getComputedStyle(line).transform).m41;
            return x / over.clientWidth;
        }""",
        k,
    )


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_opens_fits_and_is_photographed(open_page, size, scheme):
    page = open_page(size, scheme)
    assert "ring" in page.title()
    assert page.locator("figure").count() >= 8
    assert page.locator(".verdicts li").count() >= 5
    # Nothing sticks out to the side.
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.evaluate("posflock.seek(12.2)")
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    for name, whole in (("top", False), ("whole", True)):
        picture = page.screenshot(
            path=SCREENSHOTS / f"report-{size}-{scheme}-{name}.png", full_page=whole
        )
        assert len(picture) > 20_000


@pytest.mark.parametrize("size", SIZES)
def test_the_replay_plays_and_pauses(open_page, size):
    page = open_page(size)
    before = page.locator("#arena").screenshot()
    page.locator("#play").click()
    until(page, "posflock.state.time > 1")
    page.locator("#play").click()
    stopped = now(page)
    page.wait_for_timeout(150)
    assert now(page) == stopped
    assert page.locator("#arena").screenshot() != before
    assert page.locator("#play").get_attribute("aria-label") == "Play"


PACE = """() => new Promise((tell) => {
    const time = posflock.state.time, clock = performance.now();
    setTimeout(() => tell((posflock.state.time - time) / (performance.now() - clock) * 1000), 500);
})"""


def test_it_plays_at_the_speed_that_is_chosen(open_page):
    page = open_page()
    page.locator("#play").click()
    for speed in ("0.5", "8"):
        page.locator("#speed").select_option(speed)
        until(page, f"posflock.state.speed === {speed}")
        # Frames may be late on a busy machine, so the pace may lag, but never by much.
        assert 0.6 * float(speed) < page.evaluate(PACE) < 1.2 * float(speed)


def test_it_stops_at_the_end_and_begins_anew(open_page):
    page = open_page()
    page.keyboard.press("End")
    assert page.locator("#clock").inner_text() == "30.0 s"
    page.keyboard.press("Space")
    until(page, "posflock.state.time < 20 && posflock.state.time > 0.2")


@pytest.mark.parametrize("size", SIZES)
def test_scrubbing_moves_the_cursor_of_every_curve(open_page, size):
    page = open_page(size)
    page.locator("#scrub").fill("500")
    assert now(page) == pytest.approx(15, abs=0.1)
    for k in range(page.locator(".u-cursor-x").count()):
        assert cursor_of(page, k) == pytest.approx(0.5, abs=0.02)
    assert "15.0 s of 30.0 s" in page.locator("#scrub").get_attribute("aria-valuetext")


def test_the_curves_move_the_replay(open_page):
    page = open_page()
    plot = page.locator(".u-over").nth(3)
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 20)
    assert now(page) == pytest.approx(7.5, abs=0.2)
    assert cursor_of(page, 0) == pytest.approx(0.25, abs=0.02)


def test_a_finger_on_a_curve_moves_the_replay(open_page):
    page = open_page("390", touch=True)
    plot = page.locator(".u-over").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.touchscreen.tap(box["x"] + 0.75 * box["width"], box["y"] + box["height"] / 2)
    assert now(page) == pytest.approx(22.5, abs=0.5)


def test_zooming_one_curve_zooms_all_and_r_resets(open_page):
    page = open_page()
    plot = page.locator(".u-over").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 30, steps=4)
    page.mouse.up()
    low, high = page.evaluate("posflock.state.zoom")
    assert (low, high) == (pytest.approx(6, abs=0.3), pytest.approx(12, abs=0.3))
    assert page.locator("#unzoom").is_visible()
    page.evaluate("posflock.seek(9)")
    assert cursor_of(page, 5) == pytest.approx(0.5, abs=0.05)
    page.keyboard.press("r")
    assert page.evaluate("posflock.state.zoom") is None
    assert not page.locator("#unzoom").is_visible()


@pytest.mark.parametrize("size", SIZES)
def test_everything_works_from_the_keyboard(open_page, size):
    page = open_page(size)
    for key, time in [
        ("ArrowRight", 1),
        ("Shift+ArrowRight", 11),
        ("ArrowLeft", 10),
        (".", 10.032),
        (",", 9.999),
        ("Home", 0),
        ("End", 29.997),
    ]:
        page.keyboard.press(key)
        assert now(page) == pytest.approx(time, abs=0.04), key
    page.keyboard.press("Home")
    page.keyboard.press("Space")
    until(page, "posflock.state.time > 0.3")
    page.keyboard.press("Space")
    assert page.evaluate("posflock.state.playing") is False
    page.keyboard.press("+")
    assert page.evaluate("posflock.state.speed") == 8
    page.keyboard.press("-")
    assert page.evaluate("posflock.state.speed") == 4


def test_the_keys_of_form_elements_stay_theirs(open_page):
    page = open_page()
    page.locator("#trails").focus()
    page.keyboard.press("Space")
    assert not page.locator("#trails").is_checked()
    assert page.evaluate("posflock.state.playing") is False
    page.locator("#play").focus()
    page.keyboard.press("Space")
    assert page.evaluate("posflock.state.playing") is True


def test_tab_reaches_controls_and_curves(open_page):
    page = open_page()
    reached = []
    for _ in range(40):
        page.keyboard.press("Tab")
        reached.append(
            page.evaluate("document.activeElement.id || document.activeElement.className")
        )
    for wanted in ("theme", "trails", "play", "scrub", "speed", "plot"):
        assert wanted in reached


def test_a_screen_reader_hears_the_instant_and_the_curves(open_page):
    page = open_page()
    page.keyboard.press("ArrowRight")
    spoken = page.locator("#spoken").inner_text()
    assert spoken.startswith("At 1.0 seconds, γ from motion")
    assert "At 1.0 seconds" in page.locator("#arena").get_attribute("aria-label")
    label = page.locator(".plot").first.get_attribute("aria-label")
    assert "γ from motion: mean 0.80" in label
    unnamed = page.evaluate(
        """() => {
            const named = (e) => e.getAttribute('aria-label') || e.textContent.trim()
                || (e.labels && e.labels.length);
            const all = document.querySelectorAll('button, select, input, #arena, [role=img]');
            return [...all].filter((e) => !named(e)).map((e) => e.outerHTML);
        }"""
    )
    assert unnamed == []


def test_a_fault_in_the_table_leads_to_its_moment(open_page):
    page = open_page()
    page.locator("[data-seek]").first.click()
    assert now(page) == pytest.approx(12.0, abs=0.1)
    assert page.locator("#marks i.gap").count() == 1


def test_the_theme_can_be_turned(open_page):
    page = open_page("1280", "dark")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    background = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(background)
    page.locator("#theme").click()
    assert page.evaluate("document.documentElement.dataset.theme") == "light"
    assert page.evaluate(background) != dark


CONTRASTS = """() => {
    const linear = (v) =>
        v <= 10 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
    const light = (colour) => {
        const [r, g, b] = colour.match(/[\\d.]+/g).slice(0, 3).map(Number).map(linear);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ground = light(getComputedStyle(document.body).backgroundColor);
    const texts = ['.because', '.question', '.facts', '.answer', '.definition', 'figcaption',
        '.legend button', '.keys', '.unit', '.hint'];
    return texts.map((text) => {
        const ink = light(getComputedStyle(document.querySelector(text)).color);
        return (Math.max(ink, ground) + 0.05) / (Math.min(ink, ground) + 0.05);
    });
}"""


def test_text_contrasts_with_its_ground_in_both_themes(open_page):
    for scheme in ("light", "dark"):
        page = open_page("1280", scheme)
        ratios = page.evaluate(CONTRASTS)
        assert min(ratios) >= 4.5


def test_several_runs_replay_in_turn(open_page, tmp_path):
    file = write_page([a_run("first"), a_run("second"), a_run("third")], tmp_path / "runs.html")
    page = open_page(file=file)
    page.locator("#run").select_option("2")
    assert page.evaluate("posflock.run.name") == "third"
    page.locator("#scrub").fill("250")
    assert now(page) == pytest.approx(7.5, abs=0.1)
    assert page.locator(".legend").first.locator("button").count() == 3
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.screenshot(path=SCREENSHOTS / "report-runs.png", full_page=True)
