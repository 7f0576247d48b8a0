"""A first visit: few bytes before the first drop, and no shifts of the layout."""

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, ViewportSize, expect

from tests.browser.conftest import NO_DEMO, Complaints
from tests.kit.address import Address

Visit = Callable[..., Page]

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


@pytest.fixture
def visit(browser: Browser, server: Address, complaints: Complaints) -> Iterator[Visit]:
    """Opens a page of this size in a fresh profile."""
    contexts: list[BrowserContext] = []

    def opened(path: str, size: tuple[int, int], slower: int = 1) -> Page:
        viewport: ViewportSize = {"width": size[0], "height": size[1]}
        contexts.append(browser.new_context(service_workers="block", viewport=viewport))
        contexts[-1].add_init_script(NO_DEMO)
        contexts[-1].add_init_script(WATCH)
        page = contexts[-1].new_page()
        complaints.watch(page)
        session = contexts[-1].new_cdp_session(page)
        session.send("Emulation.setCPUThrottlingRate", {"rate": slower})
        page.goto(f"{server.url}/{path}")
        return page

    yield opened
    for context in contexts:
        context.close()


def check_still(page: Page) -> None:
    assert page.evaluate("shifted") <= 0.02


@pytest.mark.parametrize("size", SCREENS)
def test_little_comes_before_the_first_drop_and_nothing_moves(
    visit: Visit, size: tuple[int, int]
) -> None:
    page = visit("", size)
    expect(page.locator("#drop")).to_be_enabled()
    page.wait_for_load_state("networkidle")
    sizes = page.evaluate(FETCHED)
    check_still(page)
    assert len(sizes) > 3, "the browser counts what it fetches"
    assert 50_000 < sum(sizes) <= 110_000


@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390)])
def test_no_drawer_covers_the_board_before_the_first_script(
    browser: Browser, server: Address, width: int, height: int
) -> None:
    page = browser.new_page(viewport={"width": width, "height": height}, java_script_enabled=False)
    page.goto(server.url)
    expect(page.locator(".stage")).to_be_visible()
    expect(page.locator("#sheet")).to_be_hidden()
    page.close()


def test_nothing_moves_when_the_browser_paints_half_the_page(visit: Visit) -> None:
    for _ in range(2):
        page = visit("", PHONE, slower=8)
        expect(page.locator("#drop")).to_be_enabled()
        check_still(page)


@pytest.mark.parametrize(("path", "size"), PAGES)
def test_no_page_moves_about_while_it_opens(visit: Visit, path: str, size: tuple[int, int]) -> None:
    page = visit(path, size)
    page.wait_for_load_state("networkidle")
    check_still(page)
