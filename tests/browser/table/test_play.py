"""A player drops a ball, watches it, and is paid."""

import itertools
import math
import re
from typing import Any

import pytest
from playwright.sync_api import expect

from plinko.engine import drop
from tests.browser.conftest import REAL_DISPLAY, Open, Quick, quick_table
from tests.browser.screen import COUNT_FRAMES, HEAR
from tests.kit.address import Address


def distance_to_path(place: list[float], path: list[list[float]]) -> float:
    """The least distance of a place from a polyline."""
    best = math.inf
    for (ax, ay), (bx, by) in itertools.pairwise(path):
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        s = ((place[0] - ax) * dx + (place[1] - ay) * dy) / square if square else 0.0
        s = min(1.0, max(0.0, s))
        best = min(best, math.hypot(place[0] - ax - s * dx, place[1] - ay - s * dy))
    return best


def places_of(sampled: Any) -> list[list[float]]:
    x, y = (sampled["fields"].index(name) for name in ("x", "y"))
    return [[row[x], row[y]] for row in sampled["frames"]]


@pytest.mark.parametrize("stream", ["seeds", "snapshots"])
def test_a_seeded_ball_falls_as_predicted_into_the_predicted_bin(opened: Open, stream: str) -> None:
    screen = opened(f"/?stream={stream}", before=HEAR + REAL_DISPLAY).ready()
    record = screen.api("drops/triangle-16/42")
    board = screen.api("boards/triangle-16")["board"]
    predicted = places_of(screen.api("drops/triangle-16/42/frames?fps=240"))
    drawn = screen.pixels(board, predicted)
    radius = board["ball"]["radius"] * drawn["scale"]

    fall = drawn["points"][-1][1] - drawn["points"][0][1]

    # On a busy machine most frames are extrapolated: then the same drop is watched again.
    places: list[list[float]] = []
    seen = 0.0
    for count in range(1, 21):
        screen.seed.fill("42")
        screen.drop.click()
        places += screen.track()
        expect(screen.rows).to_have_count(count)
        seen = max((y for _, y in places), default=0) - min((y for _, y in places), default=0)
        if len(places) > 60 and seen > 0.8 * fall:
            break
    assert len(places) > 60, "the ball was drawn in many frames"
    assert seen > 0.8 * fall, "it was seen from the top to the bottom"
    # The mean of the red pixels of a striped, glossy disc wobbles about its centre by a part of its
    # radius; another ball's path would be further away. A frame may show the picture of the frame
    # before, which was perhaps extrapolated: so one place in twenty may be further off.
    off = sorted(distance_to_path(place, drawn["points"]) for place in places)
    most = off[int(0.95 * len(off))]
    assert most < 0.5 * radius, f"{most:.2f} px off a path of a ball of {radius:.2f} px"

    screen.landed(record["bin"])
    expect(screen.result).to_have_text(f"{record['score']:g}x (practice)")
    screen.shot("landed")


# Run before the page: records the text of each ticket that rises from a bin.
TICKETS = """
window.tickets = [];
new MutationObserver((changes) => {
  for (const node of changes.flatMap(({ addedNodes }) => [...addedNodes])) {
    if (node.className === "ticket") window.tickets.push(node.textContent);
  }
}).observe(document, { childList: true, subtree: true });
"""


def test_amounts_rise_from_bins_and_results_stay_as_chips(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=TICKETS).ready()
    scores = []
    for count in range(1, 4):
        screen.drop.click()
        expect(screen.rows).to_have_count(count)
        scores.append(screen.last_dropped()["score"])
    newest = [f"{score:g}x" for score in reversed(scores)]
    expect(screen.page.locator("#last .paid")).to_have_text(newest)
    told = screen.page.evaluate("tickets")
    assert told == [f"{score:.2f}" for score in scores if score > 0.0], "payouts have no sign"


def test_a_click_above_the_pegs_aims_where_an_aim_matters(opened: Open, server: Address) -> None:
    quick = quick_table(server, "classic")
    screen = opened(quick.page).ready()
    canvas = screen.page.get_by_role("img", name=re.compile("Plinko board"))
    board = screen.api(f"boards/{quick.board}")["board"]
    slots = board["drop"]["slots"]
    at = screen.pixels(board, [[slots[2] + 0.1, board["drop"]["y"]]])["points"][0]
    canvas.click(position={"x": at[0], "y": at[1]})
    expect(screen.rows).to_have_count(1)
    link = screen.rows.first.locator("a").get_attribute("href") or ""
    assert f"aim={slots[2]!r}" in link, "the nearest slot"


def test_a_click_above_the_pegs_drops_and_one_among_them_does_not(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    canvas = screen.page.get_by_role("img", name=re.compile("Plinko board"))
    box = canvas.bounding_box()
    assert box is not None
    canvas.click(position={"x": box["width"] / 2, "y": box["height"] / 2})  # among the pegs
    canvas.click(position={"x": 200, "y": 20})
    expect(screen.rows).to_have_count(1)
    assert len(screen.drops_sent) == 1, "the drop above the pegs, and no other"
    assert "aim=" not in (screen.rows.first.locator("a").get_attribute("href") or "")
    screen.drawer("Table")
    expect(screen.page.locator("#start")).to_be_hidden()
    screen.page.keyboard.press("?")
    expect(screen.page.locator("#keys-aim")).to_be_hidden()


def test_the_ball_starts_in_the_chosen_slot(opened: Open, server: Address) -> None:
    quick = quick_table(server, "classic")
    screen = opened(quick.page).ready()
    slots = quick.whole.drop.slots
    screen.drawer("Table").get_by_role("radio", name="Slot 3").check()
    screen.seed.fill("7")
    screen.drop.click()
    bin_there = drop(quick.whole, 7, aim=slots[2]).bin
    assert bin_there is not None
    screen.landed(bin_there)
    link = screen.rows.first.locator("a").get_attribute("href") or ""
    assert f"aim={slots[2]!r}" in link


def test_rows_and_risk_choose_another_table_with_other_payouts(opened: Open) -> None:
    screen = opened().ready()
    screen.page.get_by_label("Rows", exact=True).select_option("8")
    screen.page.get_by_label("Risk", exact=True).select_option("High")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("House · 8 · High.*9 bins.*31x")
    )
    screen.ready()
    assert screen.page.url.endswith("?room=triangle-8-high")
    screen.seed.fill("5")
    screen.drop.click()
    screen.landed(screen.api("drops/triangle-8-high/5")["bin"])
    screen.page.reload()
    screen.ready()
    expect(screen.page.get_by_label("Rows", exact=True)).to_have_value("8")
    expect(screen.page.get_by_label("Risk", exact=True)).to_have_value("high")
    screen.page.go_back()
    expect(screen.page.get_by_label("Risk", exact=True)).to_have_value("medium")
    screen.ready()
    assert screen.page.url.endswith("?room=triangle-8")


def test_everyone_at_a_table_sees_the_same_histogram(opened: Open, quick: Quick) -> None:
    one = opened(quick.page).ready()
    two = opened(quick.page).ready()
    for seed in ("1", "2", "3"):
        one.seed.fill(seed)
        one.drop.click()
    count = "3 balls landed at this table"
    expect(one.page.locator("#tray-count")).to_have_text(count)
    expect(two.page.locator("#tray-count")).to_have_text(count)
    # The label follows the picture some moments later.
    for each in (one, two):
        label = re.compile("^Histogram of 3 balls")
        expect(each.page.locator("#histogram")).to_have_attribute("aria-label", label)
    described = two.page.locator("#histogram").get_attribute("aria-label")
    assert one.page.locator("#histogram").get_attribute("aria-label") == described
    expect(two.page.locator("#staked")).to_have_text("0.00")
    late = opened(quick.page).ready()
    expect(late.page.locator("#tray-count")).to_have_text(count)


def test_nothing_is_drawn_while_nothing_moves(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=REAL_DISPLAY + COUNT_FRAMES).ready().at_rest()
    before = screen.frames_asked()
    # During one fall a slow machine may draw too few frames.
    for count in range(1, 6):
        screen.seed.fill("42")
        screen.drop.click()
        expect(screen.rows).to_have_count(count)
        if screen.frames_asked() - before > 60:
            break
    assert screen.frames_asked() - before > 60, "the count is of what is drawn"
    # After the bin's light has faded, the page requests no frame for half a second.
    screen.ready().at_rest()


# Run before the page: each drop is answered with the error `rate-limited`.
_REFUSE = """
window.WebSocket = class extends WebSocket {
  send(data) {
    const { type, ref } = JSON.parse(data);
    if (type !== "drop") return super.send(data);
    const refusal = { type: "error", code: "rate-limited", detail: "more than 20 drops", ref };
    const told = JSON.stringify(refusal);
    setTimeout(() => this.onmessage(new MessageEvent("message", { data: told })));
  }
};
"""


def test_a_refused_drop_is_explained_and_paid_back(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=_REFUSE, locale="es-ES").ready()
    screen.drop.click()
    expect(screen.result).to_contain_text("Demasiado rápido")
    expect(screen.page.locator("#balance")).to_have_text("1000,00")
    expect(screen.page.locator("#staked")).to_have_text("0,00")


def test_a_missing_room_is_reported_in_the_page_s_language(
    opened: Open,
) -> None:
    screen = opened("/?room=nonsense", locale="de-DE").state("closed")
    gone = screen.page.locator("#gone")
    expect(gone).to_contain_text("Diesen Tisch gibt es nicht mehr.")
    expect(screen.page.locator("#drop")).to_be_disabled()
    gone.get_by_role("button", name="Zum Haupttisch").click()
    screen.ready()
    expect(gone).to_be_hidden()
    expect(screen.page.locator("#drop")).to_be_enabled()
