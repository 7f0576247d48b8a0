"""What the table shows besides the fall: profit, last drops, odds, others' wins."""

import re

import pytest
from playwright.sync_api import Page, ViewportSize, expect

from plinko.engine import Board
from tests.browser.conftest import Open, Quick, quick_table
from tests.browser.looks import context_for
from tests.kit.address import Address


def swipe(page: Page, start: int, end: int, x: int = 180) -> None:
    """A finger goes from one height to another, in CSS pixels."""
    session = page.context.new_cdp_session(page)

    def touch(kind: str, *points: dict[str, int]) -> None:
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})

    touch("touchStart", {"x": x, "y": start})
    for y in ((start + end) // 2, end):
        touch("touchMove", {"x": x, "y": y})
    touch("touchEnd")
    session.detach()


def curve(page: Page) -> list[float]:
    """The heights of the profit curve's points, from 0 at the top to 64."""
    points = page.locator("#curve-line").get_attribute("points") or ""
    return [float(point.split(",")[1]) for point in points.split()]


def test_profit_is_drawn_around_a_zero_in_the_middle(opened: Open, server: Address) -> None:
    screen = opened(quick_table(server, "triangle-8", pays=0.5).page).ready()
    assert set(curve(screen.page)) == {32}, "a flat curve lies on zero"
    for count in (1, 2):
        screen.drop.click()
        expect(screen.rows).to_have_count(count)
    net = screen.page.locator("#net")
    expect(net).to_have_text("−1.00")
    expect(net).to_have_attribute("data-sign", "-1")
    first, second, third = curve(screen.page)[:3]
    assert first == 32 < second < third <= 64

    shown = screen.page.locator("#curve")
    box = shown.bounding_box()
    assert box
    shown.hover(position={"x": 1, "y": 20})
    expect(net).to_have_text("0.00")
    shown.hover(position={"x": 0.34 * box["width"], "y": 5})
    expect(net).to_have_text("−0.50")
    expect(screen.page.locator("#net-of")).to_have_text("Profit after 1")
    screen.page.mouse.move(5, 5)
    expect(net).to_have_text("−1.00")


def test_the_main_table_has_the_game_s_name_and_an_invitation(opened: Open) -> None:
    screen = opened("/").ready()
    page = screen.page
    expect(page.get_by_role("heading", level=1, name="Plinko", exact=True)).to_have_count(1)
    page.get_by_role("button", name="Invite").click()
    expect(page.locator("#invite-link")).to_have_value(f"{screen.url}/?room=main")


def test_a_phone_shows_the_profit_after_one_swipe(opened: Open) -> None:
    screen = opened("/", **context_for("phone")).ready()
    profit = screen.page.locator("#net")
    expect(profit).to_be_hidden()
    swipe(screen.page, 600, 400)
    expect(profit).to_be_in_viewport()
    swipe(screen.page, 200, 400)
    expect(profit).to_be_hidden()


def test_a_shower_is_one_sentence_and_a_dozen_links_to_replays(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_role("radio", name="20 balls").check()
    screen.drop.click()
    said = re.compile(r"^20 balls: staked 20\.00, won [\d.]+ \([+−]?[\d.]+\)$")
    expect(screen.result).to_contain_text(said)
    expect(screen.page.locator("#staked")).to_have_text("20.00")
    expect(screen.rows).to_have_count(20)
    chips = screen.page.locator("#last a")
    expect(chips).to_have_count(12)
    expect(chips.last).to_be_in_viewport(ratio=1)
    seed = screen.last_dropped()["seed"]
    chips.first.click()
    screen.state("replay")
    expect(screen.fact("seed")).to_have_text(seed)


@pytest.mark.parametrize("size", [(820, 1180), (1024, 768)])
def test_the_walls_keep_a_margin_on_tablets(opened: Open, size: tuple[int, int]) -> None:
    width, height = size
    screen = opened("/", viewport={"width": width, "height": height}).ready()
    board = screen.page.locator("#board").bounding_box()
    stage = screen.page.locator(".stage").bounding_box()
    assert board
    assert stage
    assert board["x"] - stage["x"] >= 16


def test_a_desk_s_tray_is_high_and_as_wide_as_the_window_s_side(opened: Open) -> None:
    screen = opened("/", viewport={"width": 1920, "height": 1080}).ready()
    tray = screen.page.locator(".tray-glass").bounding_box()
    stage = screen.page.locator(".stage").bounding_box()
    assert tray
    assert stage
    assert tray["height"] >= 0.165 * 1080
    assert tray["width"] == stage["width"]


def test_over_a_bin_are_its_chance_and_its_payout_for_the_stake(opened: Open) -> None:
    screen = opened("/?room=triangle-8", viewport={"width": 1280, "height": 800}).ready()
    record = screen.api("boards/triangle-8")["board"]["bins"]
    odds = screen.api("boards/triangle-8/odds")["aims"][0]["chances"]
    screen.page.get_by_label("Stake", exact=True).fill("2.50")
    screen.page.get_by_label("Stake", exact=True).blur()
    board = Board.preset("triangle-8").to_dict()
    tip = screen.page.locator(".bin-odds")
    for bin_ in (4, 1):
        x = (record["edges"][bin_] + record["edges"][bin_ + 1]) / 2
        (place,) = screen.pixels(board, [[x, record["y"] + 0.1]])["points"]
        screen.page.locator("#board-moving").hover(position={"x": place[0], "y": place[1]})
        pays = record["multipliers"][bin_]
        expect(tip.locator("b")).to_have_text(f"{pays:g}x pays {2.5 * pays:.2f}")
        expect(tip).to_contain_text(f"{100 * odds[bin_]:.1f} % of balls")
    screen.page.mouse.move(300, 200)
    expect(tip).to_be_hidden()
    keyboard = screen.page.keyboard
    keyboard.press("t")
    summary = screen.page.get_by_text("What each bin pays")
    expect(summary).to_be_visible()  # a hidden one would take no focus
    summary.focus()
    keyboard.press("Enter")
    listed = screen.page.get_by_role("listitem").filter(has_text=" pays ")
    expect(listed).to_have_count(9)
    for bin_, (pays, chance) in enumerate(zip(record["multipliers"], odds, strict=True)):
        rare = f"about 1 ball in {round(1 / chance)} lands here"
        words = rare if chance < 0.01 else f"{100 * chance:.1f} % of balls land here"
        expect(listed.nth(bin_)).to_have_text(f"{pays:g}x pays {2.5 * pays:.2f}{words}")


def test_a_great_win_is_saved_as_a_video_in_one_tap(opened: Open, server: Address) -> None:
    screen = opened(quick_table(server, "triangle-8", pays=150.0).page).ready()
    screen.drop.click()
    with screen.page.expect_download() as saved:
        screen.page.get_by_role("button", name="Save video").click()
    seed = screen.last_dropped()["seed"]
    assert saved.value.suggested_filename == f"plinko-{seed}.mp4"
    assert saved.value.path().read_bytes()[4:8] == b"ftyp"
    expect(screen.page.locator("#card")).to_be_hidden()


def test_a_win_is_above_zero_and_the_best_of_the_day_has_its_replay(
    opened: Open, server: Address
) -> None:
    quick = quick_table(server, "triangle-8", pays=12.0)
    wide: ViewportSize = {"width": 1280, "height": 800}
    player = opened(quick.page, viewport=wide).ready()
    expect(player.page.locator("#best-key")).to_be_hidden()
    player.drop.click()
    expect(player.page.locator("#best-key")).to_have_text("Best today: 12x, 12.00")
    expect(player.page.locator("#net")).to_have_attribute("data-sign", "1")
    assert curve(player.page)[1] < 32, "a win is drawn above zero"
    other = opened(quick.page, viewport=wide).ready()
    other.page.mouse.move(400, 300)
    expect(other.page.locator("#best-key")).to_have_text("Best today: 12x, 12.00")
    seed = player.last_dropped()["seed"]
    expect(player.page.locator("#best")).to_have_text("12x")
    expect(player.page.locator("#best")).to_be_visible()
    link = other.page.locator("#best-row a")
    expect(link).to_be_visible()
    expect(link).to_have_attribute("href", re.compile(f"seed={seed}"))
