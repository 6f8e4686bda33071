"""The live page in a real browser, with the command that serves it, from its start to Ctrl-C.

Screenshots are kept as those of the report are (see `test_report_browser`).
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.test_accessible_pages import VIOLATIONS, axe  # noqa: F401 - a fixture
from tests.test_report_browser import ARGUMENTS, CHROMIUM, ROOT, SCREENSHOTS, SIZES, until

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium on the PATH"),
]
NINE = ROOT / "experiments" / "robotarium_9bot.py"
FACE_TO_FACE = """
import numpy as np
from rps.robotarium import Robotarium
from rps.utilities.barrier_certificates import create_unicycle_barrier_certificate
start = np.array([[-0.3, 0.3], [0.0, 0.0], [0.0, np.pi]])
r = Robotarium(number_of_robots=2, initial_conditions=start)
safe = create_unicycle_barrier_certificate()
print("face to face")
for k in range(60):
    x = r.get_poses()
    r.set_leds(np.arange(2), np.array([[0, 255], [255, 0], [0, 0]]))
    r.set_velocities(np.arange(2), safe(np.array([[0.15, 0.15], [0.0, 0.0]]), x))
    r.step()
raise ValueError("the <b>end</b>")
"""


@contextmanager
def served(folder, *words, end=signal.SIGINT):
    """Run the command; give the page's address, and in the end what it said and left."""
    said = {}
    temporary = folder / "tmp"
    temporary.mkdir()
    command = [sys.executable, "-m", "posflock_robotarium", "watch", "--no-open", *words]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        cwd=folder, env=os.environ | {"TMPDIR": str(temporary)},
    )  # fmt: skip
    try:
        before = []
        for line in process.stdout:
            before.append(line)
            if found := re.search(r"http://127\.0\.0\.1:(\d+)/\S+/", line):
                said["url"] = found[0]
                break
        else:
            pytest.fail("".join(before))
        yield said
        process.send_signal(end)
        said["rest"] = process.communicate(timeout=60)[0]
        said["code"] = process.returncode
    finally:
        process.kill()
        process.wait()
    deadline = time.monotonic() + 10
    while list(temporary.iterdir()) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert list(temporary.iterdir()) == []
    assert not [p for p in Path("/proc").glob("[0-9]*/environ") if _told_of(p, temporary)]


def _told_of(environment, folder):
    try:
        return os.fsencode(folder) in environment.read_bytes()
    except OSError:
        return False


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api")
    pytest.importorskip("uvicorn")
    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield running
        running.close()


def opened(browser, url, size="1280", scheme="light", **more):
    """Open the page; whatever it says to the console is kept in `complaints`."""
    context = browser.new_context(viewport=SIZES[size], color_scheme=scheme, **more)
    page = context.new_page()
    page.set_default_timeout(30_000)
    page.complaints = []
    page.on("console", lambda message: page.complaints.append(message.text))
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    page.goto(url)
    return page


def in_state(page, condition):
    until(page, f"(() => {{ const s = posflock.state; return Boolean({condition}); }})()", 60)


def test_the_nine_robots_are_held_stepped_and_retuned_from_the_page(browser, tmp_path):
    words = ["--speed", "max", "--paused", "-o", "kept", str(NINE), "--duration", "500"]
    with served(tmp_path, *words) as said:
        page = opened(browser, said["url"])
        in_state(page, "s.frame && s.phase === 'running'")
        assert page.locator("#phase").text_content() == "paused, driving to the start"
        page.keyboard.press(" ")
        in_state(page, "s.frame && s.frame.links && s.flock && !s.frame.driving_to_start")
        page.keyboard.press(" ")
        in_state(page, "s.settings.paused")
        assert page.locator("#phase").text_content() == "paused"
        step = page.evaluate("posflock.state.frame.step")
        assert page.locator("#beside-clock").text_content() == f"step {step}"
        legend = page.locator("#legend li:visible")
        assert legend.count() == 7
        page.locator("#links").uncheck()
        page.locator("#barriers").uncheck()
        assert [text[:8] for text in legend.all_text_contents()] == ["trail, t", "robot to"]
        page.keyboard.press(".")
        in_state(page, f"s.frame.step === {step + 1}")
        page.locator("#law-radius").fill("1.5")
        page.get_by_label("velocity-based").check()
        page.locator("#profile").select_option("gritsbot_x")
        page.locator("#step").click()
        in_state(page, f"s.frame.step === {step + 2} && s.flock.radius === 1.5")
        in_state(page, "s.flock.model === 'velocity' && s.settings.profile === 'gritsbot_x'")
        assert page.locator("#value-radius").text_content() == "1.5 m"
        page.locator("#speed").select_option("8")
        page.locator("#play").click()
        in_state(page, f"!s.settings.paused && s.settings.speed === 8 && s.frame.step > {step + 9}")
        assert page.complaints == []
        page.context.close()
    assert said["code"] == 0  # the script takes Ctrl-C for the testbed's end of a run
    log = json.loads((tmp_path / "kept" / "poses.json").read_text())
    assert {"law", "profile"} <= {name for c in log["changed_while_watched"] for name in c}
    own = json.loads((tmp_path / "kept" / "script" / "nine_robots.json").read_text())
    assert own["retuned"][-1]["model"] == "velocity"
    assert own["retuned"][-1]["law"]["radius"] == 1.5


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    path = tmp_path_factory.mktemp("script") / "face_to_face.py"
    path.write_text(FACE_TO_FACE)
    return path


@pytest.mark.slow
def test_pages_come_and_go_and_the_end_is_told(browser, script, tmp_path):
    with served(tmp_path, "--speed", "max", "--paused", str(script), end=signal.SIGTERM) as said:
        first, second = opened(browser, said["url"]), opened(browser, said["url"], "390")
        in_state(first, "s.settings && s.settings.paused && s.frame && s.frame.step === 0")
        assert first.locator("#law").is_hidden()
        assert first.locator("#links-label").is_hidden()
        first.locator("#speed").select_option("null")
        first.locator("#play").click()
        in_state(second, "s.phase === 'ended'")
        assert second.locator("#phase").text_content() == "failed"
        reason = second.locator("#reason").text_content()
        assert reason == "ValueError: the <b>end</b> (line 14 of face_to_face.py)"
        assert "face to face" in second.locator("#printed").text_content()
        second.reload()
        in_state(second, "s.phase === 'ended' && s.frame && s.past.length > 1")
        assert second.evaluate("posflock.state.frame.leds") == ["#00ff00", "#ff0000"]
        assert second.evaluate("posflock.state.frame.barrier.pairs") == [[0, 1]]
        second.locator("#again").click()
        in_state(first, "s.phase !== 'ended'")
        in_state(first, "s.phase === 'ended' && s.outcome.ended === 'failed'")
        first.context.close()
        second.context.close()
    assert said["code"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_axe_finds_no_violation_whatever_is_shown(browser, script, axe, size, scheme, tmp_path):  # noqa: F811
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    shown = {"nine": [str(NINE), "--duration", "500"], "ended": [str(script)]}
    for name, words in shown.items():
        (tmp_path / name).mkdir()
        with served(tmp_path / name, "--speed", "max", *words) as said:
            page = opened(browser, said["url"], size, scheme, bypass_csp=True)
            in_state(page, "s.phase === 'ended'" if name == "ended" else "s.frame && s.flock")
            page.evaluate(axe)
            assert page.evaluate(VIOLATIONS) == []
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            path = SCREENSHOTS / f"watch-{name}-{size}-{scheme}.png"
            page.screenshot(path=path, full_page=True)
            page.context.close()
