"""The desk's controls: fields of auto on phones, keys, the card of a win, what is said first."""

import re
from typing import Any

import pytest
from playwright.sync_api import Route, ViewportSize, expect

from tests.browser.conftest import Complaints, Open, Quick, quick_table
from tests.browser.screen import Screen
from tests.kit.address import Address

PHONES = [
    *((390, 844), (360, 740), (390, 664), (360, 640), (320, 568), (600, 700)),
    *((820, 1180), (768, 1024)),
]

# The board's box, and the parts of the page that cover one of its bins.
_BOARD = """
async (board) => {
  const { layOut } = await import("/js/paint/geometry.js");
  const canvas = document.getElementById("board-moving");
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const { px, py } = layOut(board, width);
  const { edges, y } = board.bins;
  const covered = edges.slice(1).map((edge, bin) => document.elementFromPoint(
    left + px((edge + edges[bin]) / 2), Math.min(top + py(y) + 8, top + height - 2)));
  return {
    box: [left, top, width, height],
    covered: covered.filter((part) => part !== canvas).map((part) => part?.outerHTML.slice(0, 80)),
  };
}
"""


def board_of(screen: Screen, quick: Quick) -> Any:
    screen.frames(2)  # the layout changes in the next frame, which the one after shows
    seen = screen.page.evaluate(_BOARD, quick.whole.to_dict())
    assert seen["covered"] == [], "no bin is covered"
    return seen["box"]


def test_auto_leaves_the_board_its_size_and_its_bins_in_view(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, locale="de").ready()  # German has the longest words
    page = screen.page
    one, auto = (page.locator(f"input[name=balls][value='{value}']") for value in ("1", "auto"))
    before = {}
    for width, height in PHONES:
        page.set_viewport_size({"width": width, "height": height})
        one.check(force=True)
        before[width, height] = board_of(screen, quick)
        auto.check(force=True)
        expect(page.locator("#auto-panel")).to_be_visible()
        expect(page.locator("#worlds")).to_be_hidden()
        assert board_of(screen, quick) == before[width, height]
    page.locator("#auto-count").fill("")
    screen.drop.click()
    expect(screen.rows.nth(1)).to_be_attached()
    for size in PHONES:
        page.set_viewport_size({"width": size[0], "height": size[1]})
        assert board_of(screen, quick) == before[size]
    screen.drop.click()
    screen.ready()
    for size in PHONES:
        page.set_viewport_size({"width": size[0], "height": size[1]})
        assert board_of(screen, quick) == before[size]


# Texts of controls that are smaller than 16 px, into which a phone zooms.
_ZOOMED = """
[...document.querySelectorAll("select, input:not([type=radio], [type=checkbox], [type=range])")]
  .filter((field) => field.checkVisibility() && parseFloat(getComputedStyle(field).fontSize) < 16)
  .map((field) => field.id)
"""


@pytest.mark.parametrize("viewport", [{"width": 390, "height": 844}, {"width": 844, "height": 390}])
def test_a_phone_zooms_into_no_field(opened: Open, quick: Quick, viewport: ViewportSize) -> None:
    screen = opened(quick.page, viewport=viewport).ready()
    screen.page.locator("input[name=balls][value=auto]").check(force=True)
    screen.page.locator("#auto-on-win").select_option("times")
    assert screen.page.evaluate(_ZOOMED) == []
    for drawer in ("Game", "Table", "Fairness", "For the curious", "Settings"):
        screen.drawer(drawer)
        assert screen.page.evaluate(_ZOOMED) == [], drawer


def test_keys_and_buttons_halve_double_and_stake_all(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    stake = screen.page.get_by_label("Stake", exact=True)
    for key, value in (("+", "2"), ("+", "4"), ("-", "2"), ("=", "4"), ("−", "2")):
        if key == "−":  # on some keyboards
            screen.page.locator("body").dispatch_event("keydown", {"key": key, "bubbles": True})
        else:
            screen.page.keyboard.press(key)
        expect(stake).to_have_value(value)
    stake.fill("3")
    stake.press("+")
    expect(stake).to_have_value("3+")  # typed into the field
    stake.fill("1")
    for name, value in (("Double", "2"), ("Double", "4"), ("Halve", "2"), ("Stake all", "1000")):
        screen.page.get_by_role("button", name=name).click()
        expect(stake).to_have_value(value)
    # The balance lasts for all balls of a press; auto drops one after another.
    for balls, name, value in (("20", "Double", "50"), ("auto", "Stake all", "1000")):
        screen.page.locator(f"input[name=balls][value='{balls}']").check(force=True)
        screen.page.get_by_role("button", name=name).click()
        expect(stake).to_have_value(value)
    assert screen.drops_sent == []


@pytest.fixture
def rich(server: Address) -> Quick:
    """A table where each ball pays 110 times its stake."""
    return quick_table(server, "triangle-8", pays=110)


# Run before the page: what the page would do after six seconds waits for `after6s`.
_HOLD = """
const set = window.setTimeout.bind(window);
window.setTimeout = (call, ms, ...all) => {
  if (ms !== 6000) return set(call, ms, ...all);
  window.after6s = call;
  return 0;
};
"""


def jackpot(opened: Open, rich: Quick) -> Screen:
    """A page with the card of a win."""
    screen = opened(rich.page, reduced_motion="reduce", before=_HOLD).ready()
    screen.drop.click()
    expect(screen.page.locator("#card")).to_be_visible()
    return screen


def test_the_card_of_a_win_covers_no_bin(opened: Open, rich: Quick) -> None:
    screen = jackpot(opened, rich)
    for width, height in [*PHONES, (844, 390), (1280, 800)]:
        screen.page.set_viewport_size({"width": width, "height": height})
        board_of(screen, rich)
        expect(screen.page.locator("#card")).to_be_visible()


def test_the_card_of_a_win_closes_after_six_seconds_on_escape_or_a_drop(
    opened: Open, rich: Quick
) -> None:
    screen = jackpot(opened, rich)
    card = screen.page.locator("#card")
    screen.page.evaluate("after6s()")
    expect(card).to_be_hidden()
    screen.drop.click()
    expect(card).to_be_visible()
    screen.page.keyboard.press("Space")
    expect(card).to_be_hidden()
    expect(card).to_be_visible()  # of the next win
    expect(screen.drawer("For the curious")).to_be_visible()
    screen.page.keyboard.press("Escape")
    expect(card).to_be_hidden()
    expect(screen.page.locator("#lab")).to_be_visible()  # Escape closes one thing at a time
    screen.page.keyboard.press("Escape")
    expect(screen.page.locator("#lab")).to_be_hidden()


def test_ready_is_said_only_when_it_is_so(opened: Open, quick: Quick) -> None:
    held = "window.WebSocket = class { constructor() { window.socket = this; } close() {} };"
    screen = opened(quick.page, before=held)
    screen.page.wait_for_function("() => window.socket")
    expect(screen.result).to_have_text("Connecting…")
    ready = opened(quick.page).ready()
    expect(ready.result).to_have_text("Ready when you are.")
    gone = opened("/?room=nonsense").state("closed")
    expect(gone.result).not_to_have_text(re.compile("Ready|Connecting"))


def test_auto_in_practice_asks_for_nothing_about_stakes(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    page = screen.page
    page.locator("input[name=balls][value=auto]").check(force=True)
    page.locator("#auto-count").fill("2")
    page.locator("#auto-loss").fill("-1")
    page.locator("#auto-loss").press("Tab")
    expect(page.locator("#fault")).to_be_visible()
    screen.seed.fill("5")
    expect(page.locator("#fault")).to_be_hidden()
    for field in ("#auto-win", "#auto-loss", "#auto-on-win", "#auto-on-loss"):
        expect(page.locator(field)).to_be_hidden()
    screen.drop.click()
    expect(screen.result).to_have_text("Auto finished: 2 balls, practice")


def test_the_drawer_that_was_asked_for_last_is_open(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    screen.page.route("**/panels/fit*.js", hold)
    screen.page.keyboard.press("l")
    screen.until(lambda: held)
    screen.page.keyboard.press("s")
    expect(screen.page.locator("#settings")).to_be_visible()
    held[0].continue_()
    screen.page.evaluate("async (url) => { await import(url); }", held[0].request.url)
    screen.frames(2)
    expect(screen.page.locator("#settings")).to_be_visible()


def test_a_drawer_that_cannot_be_fetched_says_so_and_opens_later(
    opened: Open, quick: Quick, complaints: Complaints
) -> None:
    complaints.allow("net::ERR_FAILED")
    screen = opened(quick.page, viewport={"width": 390, "height": 844}).ready()
    for code, key, drawer in (("panels/sheet", "g", "game"), ("panels/fit", "l", "lab")):
        screen.page.route(f"**/{code}*.js", lambda route: route.abort())
        screen.page.keyboard.press(key)
        expect(screen.result).to_have_text("This part could not be loaded. Please try again.")
        expect(screen.page.locator(f"#{drawer}")).to_be_hidden()
        screen.page.unroute(f"**/{code}*.js")
        screen.page.keyboard.press(key)
        expect(screen.page.locator(f"#{drawer}")).to_be_visible()
