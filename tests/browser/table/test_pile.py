"""The pile of landed balls: its code is fetched when needed, each ball is a disc, it sleeps."""

import re
from typing import Any

from playwright.sync_api import ViewportSize, expect

from tests.browser.conftest import Open, Quick
from tests.browser.screen import COUNT_FRAMES, STATES, Screen

PHONE: ViewportSize = {"width": 360, "height": 780}

# For each bin the longest painted row in its column, and the column's width at the floor, in CSS
# pixels: bars are as wide as their column, discs are not.
_WIDEST = """
async ([board, walls]) => {
  const { layOut } = await import("/js/paint/geometry.js");
  const { spreadOut, trayGeometry } = await import("/js/instruments/pile/columns.js");
  const canvas = document.querySelector("#histogram");
  const above = layOut(board, document.querySelector("#board").clientWidth);
  const { px, spread } = trayGeometry(board, above, canvas.clientWidth);
  const density = canvas.width / canvas.clientWidth;
  const ctx = canvas.getContext("2d");
  const edges = spreadOut(board.bins.edges, spread);
  return edges.slice(1).map((edge, bin) => {
    const [left, right] = [edges[bin], edge].map((x) => Math.round(px(x) * density));
    const inside = [left + walls * density, right - left - 2 * walls * density].map(Math.round);
    const low = 12 * density; // the rows at the floor
    const at = [inside[0], canvas.height - low, inside[1], low];
    const { data, width, height } = ctx.getImageData(...at);
    let widest = 0;
    for (let row = 0; row < height; row += 1) {
      for (let column = 0, run = 0; column < width; column += 1) {
        run = data[4 * (row * width + column) + 3] > 200 ? run + 1 : 0;
        widest = Math.max(widest, run);
      }
    }
    return [widest / density, (right - left) / density];
  });
}
"""

# The addresses of all files that the page has fetched.
_FETCHED = "performance.getEntriesByType('resource').map(({ name }) => name)"


def widest(screen: Screen, quick: Quick) -> list[list[float]]:
    found: list[list[float]] = screen.page.evaluate(_WIDEST, [quick.whole.to_dict(), 4])
    return found


def fetched(screen: Screen) -> bool:
    return any("touching.wasm" in name for name in screen.page.evaluate(_FETCHED))


def landed(screen: Screen, quick: Quick, seed: int) -> int:
    """Drop a ball by its seed, and wait until nothing moves; returns its bin."""
    rows = screen.rows.count()
    screen.seed.fill(str(seed))
    screen.drop.click()
    expect(screen.rows).to_have_count(rows + 1)
    screen.ready().at_rest()
    bin_: int = screen.api(f"drops/{quick.board}/{seed}")["bin"]
    return bin_


def test_the_pile_loads_at_first_touch_with_a_disc_for_each_ball(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page, before=COUNT_FRAMES).ready()
    assert not fetched(screen)
    pile = screen.page.get_by_role("button", name="Pile", exact=True)
    expect(pile).to_have_attribute("aria-pressed", "true")
    first = landed(screen, quick, 1)
    screen.until(lambda: fetched(screen))
    screen.at_rest()
    second = next(bin_ for seed in range(2, 9) if (bin_ := landed(screen, quick, seed)) != first)
    discs = widest(screen, quick)
    for bin_ in (first, second):
        wide, column = discs[bin_]
        assert 0 < wide < 0.6 * column, "a disc, or some next to each other"
    expect(screen.page.locator("#histogram")).to_have_attribute(
        "aria-label", re.compile(rf"bin {first}: \d")
    )
    screen.shot("pile")

    pile.click()
    expect(pile).to_have_attribute("aria-pressed", "false")
    screen.at_rest()
    wide, column = widest(screen, quick)[first]
    assert wide > 0.6 * column, "bars"
    screen.page.reload()
    screen.ready()
    expect(pile).to_have_attribute("aria-pressed", "false")
    screen.at_rest()
    wide, column = widest(screen, quick)[first]
    assert wide > 0.6 * column, "what was chosen is remembered"


# Run before the page: the first connection breaks as soon as it is open.
_CUT = """
let cut = false;
window.WebSocket = class extends WebSocket {
  constructor(...all) {
    super(...all);
    if (!cut) this.addEventListener("open", () => this.close());
    cut = true;
  }
};
"""


def test_a_lost_connection_loads_no_pile(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=COUNT_FRAMES + STATES + _CUT)
    screen.passed("reconnecting", "asleep").at_rest(60)
    assert not fetched(screen)


def test_with_reduced_motion_discs_lie_where_balls_landed(opened: Open, quick: Quick) -> None:
    screen = opened(
        quick.page, before=COUNT_FRAMES, viewport=PHONE, device_scale_factor=3, is_mobile=True,
        has_touch=True, reduced_motion="reduce",
    ).ready()  # fmt: skip
    bin_ = landed(screen, quick, 1)
    screen.until(lambda: fetched(screen))
    screen.at_rest()
    wide, column = widest(screen, quick)[bin_]
    assert 0 < wide < 0.6 * column
    note = screen.page.locator(".tray-note").bounding_box()
    assert note is not None
    assert note["x"] + note["width"] <= PHONE["width"]
    screen.shot("pile-phone")


def test_a_pile_that_cannot_be_fetched_leaves_the_bars(
    opened: Open, quick: Quick, complaints: Any
) -> None:
    complaints.allow("404")
    screen = opened(quick.page, before=COUNT_FRAMES)
    screen.page.route("**/touching.wasm", lambda route: route.fulfill(status=404))
    screen.page.reload()  # now no request of the page comes before the route
    screen.ready()
    pile = screen.page.get_by_role("button", name="Pile", exact=True)
    screen.page.keyboard.press("Shift")
    expect(screen.result).to_contain_text("The pile could not be loaded")
    expect(pile).to_have_attribute("aria-pressed", "false")
    bin_ = landed(screen, quick, 1)
    wide, column = widest(screen, quick)[bin_]
    assert wide > 0.6 * column
