"""Every page that the product makes, judged by axe-core on wide, middling and narrow screens."""

import dataclasses
from importlib import resources

import pytest

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.report import analyse
from posflock_robotarium.report.outputs import write_report
from tests.test_report_browser import ARGUMENTS, CHROMIUM, a_run

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium on the PATH"),
]
WIDTHS = (1280, 768, 390)
PAGES = ("report", "compare", "verify")
VIOLATIONS = """async () => (await axe.run()).violations.map(
    (v) => `${v.id}: ${v.nodes.map((node) => node.html.slice(0, 120)).join(" | ")}`)"""


@pytest.fixture(scope="module")
def axe():
    package = pytest.importorskip("axe_playwright_python")
    return (resources.files(package) / "axe.min.js").read_text("utf-8")


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    flocks = [known_flock("parallel", 0.1, duration=10.0, seed=k) for k in range(2)]
    runs = [
        analyse(dataclasses.replace(f.recording, name=f"run {k}"), radius=f.radius)
        for k, f in enumerate(flocks)
    ]
    made = {
        "report": write_report([a_run()], folder / "report", figures=False)[0],
        "compare": write_report(
            runs, folder / "compare", figures=False, labels=["simulated", "returned"]
        )[0],
        "verify": folder / "verify.html",
    }
    made["verify"].write_text(verified(folder), "utf-8")
    return made


def verified(folder):
    from posflock_robotarium.verify import verify
    from posflock_robotarium.verify.pages import html

    script = folder / "main.py"
    script.write_text(
        "import numpy as np\n"
        "from rps.robotarium import Robotarium\n"
        "r = Robotarium(number_of_robots=2, show_figure=False)\n"
        "for _ in range(20):\n"
        "    r.get_poses()\n"
        "    r.set_velocities(np.arange(2), np.full((2, 2), 0.05))\n"
        "    r.step()\n"
    )
    return html(verify(script, trials=1))


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield running
        running.close()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_no_violation(browser, pages, axe, name, width):
    # The page's own policy lets no other script in.
    context = browser.new_context(viewport={"width": width, "height": 900}, bypass_csp=True)
    page = context.new_page()
    page.goto(f"file://{pages[name]}")
    page.evaluate(axe)
    assert page.evaluate(VIOLATIONS) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator("main").count() == 1
    context.close()


def test_what_is_pressed_is_large_enough_for_a_finger(browser, pages):
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.goto(f"file://{pages['report']}")
    low = page.evaluate(
        "[...document.querySelectorAll('button')].filter((b) => b.offsetParent)"
        ".map((b) => b.getBoundingClientRect()).filter((r) => r.height < 24 || r.width < 24).length"
    )
    page.close()
    assert low == 0


def test_paper_shows_closed_sections_and_the_screen_closes_them_again(browser, pages):
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.goto(f"file://{pages['report']}")
    closed = "document.querySelectorAll('details:not([open])').length"
    before = page.evaluate(closed)
    assert before > 0
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate(closed) == 0
    assert page.evaluate("document.documentElement.dataset.theme") == "light"
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate(closed) == before
    page.close()


def test_letters_of_the_verify_drawing_can_be_read_on_a_phone(browser, pages):
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.goto(f"file://{pages['verify']}")
    heights = page.evaluate(
        "[...document.querySelectorAll('svg text')].filter((t) => t.getClientRects().length)"
        ".map((t) => t.getBoundingClientRect().height)"
    )
    page.close()
    assert heights
    assert min(heights) >= 11
