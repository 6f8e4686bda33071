"""The built site in Chromium: axe-core, narrow and wide, light and dark; search; no network."""

from pathlib import Path

import pytest
from test_accessible_pages import VIOLATIONS, axe, browser  # noqa: F401
from test_report_browser import CHROMIUM

SITE = Path(__file__).parents[1] / "build/docs/html"
PAGES = sorted(path.relative_to(SITE).as_posix() for path in SITE.rglob("*.html"))
#: Of pages that are made from code, some; of those written by hand, all.
MADE = ("reference/api/", "source/")
SOME = (
    "index.html",
    "flocking.law.html",
    "alignment.metrics.html",
    "barrier_certificates.unicycle.html",
    "v2.robotarium.html",
    "flocking/law.py.html",
    "claims.html",
)
OF_EVERY_SORT = [page for page in PAGES if not page.startswith(MADE) or page.endswith(SOME)]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium on the PATH"),
    pytest.mark.skipif(not PAGES, reason="there is no site; `make docs` builds it"),
]


@pytest.fixture(params=[(1280, "light"), (390, "dark")], ids=str)
def page(request, browser):  # noqa: F811
    width, scheme = request.param
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme, offline=True
    )
    opened = context.new_page()
    asked = []
    opened.on("request", lambda request: asked.append(request.url))
    yield opened
    context.close()
    assert asked
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


def test_axe_finds_no_violation_and_no_page_is_wider_than_its_window(page, axe):  # noqa: F811
    found = {}
    for name in OF_EVERY_SORT:
        page.goto(f"file://{SITE / name}")
        page.evaluate(axe)
        faults = page.evaluate(VIOLATIONS)
        if page.evaluate("document.documentElement.scrollWidth > innerWidth"):
            faults.append("wider than its window")
        if faults:
            found[name] = faults
    assert found == {}


def test_search_finds_a_page_and_a_name(page):
    for asked, answer in (("imprint", "Glossary"), ("UnicycleCertificate", "UnicycleCertificate")):
        page.goto(f"file://{SITE / 'search.html'}?q={asked}")
        page.wait_for_selector("ul.search li a")
        assert answer in page.locator("ul.search").inner_text()
