"""A first visit: few bytes before the first drop, and no shifts of the layout."""

from typing import Any

import pytest
from playwright.sync_api import Browser, ViewportSize, expect

from tests.browser.conftest import NO_DEMO, Complaints
from tests.kit.address import Address

DESK, PHONE = (1280, 800), (390, 844)
PAGES = [
    *((f"{page}.html", DESK) for page in ("replay", "editor", "sandbox")),
    *(("replay.html?compare", size) for size in (DESK, PHONE)),
]
SCREENS = [(360, 640), (390, 844), (700, 900), (1280, 800)]

# Run before the page: sums up how far parts move after they are painted, as browsers measure it
# (https://wicg.github.io/layout-instability).
WATCH = """
window.shifted = 0;
new PerformanceObserver((list) => {
  for (const { value } of list.getEntries()) window.shifted += value;
}).observe({ type: "layout-shift", buffered: true });
"""

# The transferred bytes of the page and of each file that it has fetched.
FETCHED = """
["navigation", "resource"].flatMap((kind) => performance.getEntriesByType(kind))
  .map(({ transferSize }) => transferSize)
"""


@pytest.mark.parametrize(("width", "height"), SCREENS)
def test_little_comes_before_the_first_drop_and_nothing_moves(
    browser: Browser, server: Address, complaints: Complaints, width: int, height: int
) -> None:
    new: dict[str, Any] = {"viewport": {"width": width, "height": height}}
    context = browser.new_context(service_workers="block", **new)
    context.add_init_script(NO_DEMO)
    context.add_init_script(WATCH)
    page = context.new_page()
    complaints.watch(page)
    page.goto(server.url)
    expect(page.locator("#drop")).to_be_enabled()
    page.wait_for_load_state("networkidle")
    sizes, shifted = page.evaluate(FETCHED), page.evaluate("shifted")
    context.close()
    assert len(sizes) > 3, "the browser counts what it fetches"
    assert 50_000 < sum(sizes) <= 110_000
    assert shifted <= 0.02


@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390)])
def test_no_drawer_covers_the_board_before_the_first_script(
    browser: Browser, server: Address, width: int, height: int
) -> None:
    page = browser.new_page(viewport={"width": width, "height": height}, java_script_enabled=False)
    page.goto(server.url)
    expect(page.locator(".stage")).to_be_visible()
    expect(page.locator("#sheet")).to_be_hidden()
    page.close()


def test_nothing_moves_when_the_browser_paints_half_the_page(
    browser: Browser, server: Address, complaints: Complaints
) -> None:
    width, height = PHONE
    viewport: ViewportSize = {"width": width, "height": height}
    for _ in range(2):
        context = browser.new_context(service_workers="block", viewport=viewport)
        context.add_init_script(NO_DEMO)
        context.add_init_script(WATCH)
        page = context.new_page()
        complaints.watch(page)
        context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": 8})
        page.goto(server.url)
        expect(page.locator("#drop")).to_be_enabled()
        shifted = page.evaluate("shifted")
        context.close()
        assert shifted <= 0.02


@pytest.mark.parametrize(("path", "size"), PAGES)
def test_no_page_moves_about_while_it_opens(
    browser: Browser,
    server: Address,
    complaints: Complaints,
    path: str,
    size: tuple[int, int],
) -> None:
    width, height = size
    viewport: ViewportSize = {"width": width, "height": height}
    context = browser.new_context(service_workers="block", viewport=viewport)
    context.add_init_script(NO_DEMO)
    context.add_init_script(WATCH)
    page = context.new_page()
    complaints.watch(page)
    page.goto(f"{server.url}/{path}")
    page.wait_for_load_state("networkidle")
    shifted = page.evaluate("shifted")
    context.close()
    assert shifted <= 0.02
