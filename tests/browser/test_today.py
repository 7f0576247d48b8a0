"""The ball of the day: one guess on the board, a streak, a text to share."""

import pytest
from playwright.sync_api import expect

from tests.browser.access.axe import check_axe_on
from tests.browser.conftest import Open
from tests.browser.looks import check_fit, context_for, each_screen

DAY = "Date.now = () => Date.parse('2027-01-0{}T12:00:00Z');"
SEEDS = {1: "20270101", 2: "20270102"}


def test_a_tap_on_a_bin_lets_the_ball_fall_and_begins_a_streak(opened: Open) -> None:
    screen = opened("/today.html", before=DAY.format(1), **context_for("phone")).state("replay")
    page = screen.page
    expect(screen.result).to_have_text("Where will today's ball land? Tap a bin.")
    record = screen.api(f"drops/triangle-9/{SEEDS[1]}")
    pays = f"{record['score']:g}x"
    page.get_by_role("button", name=f"Bin {record['bin']}, ").tap()
    screen.landed(record["bin"])
    expect(screen.result).to_have_text(f"Right! It landed on {pays}.")
    expect(page.locator("#streak")).to_have_text("1")
    expect(page.locator("#right")).to_have_text("1 of 1")
    text = page.get_by_label("Text to share").input_value()
    first, *others = text.split("\n")
    assert first == "Plinko ball of the day, January 1, 2027"
    assert others == ["🎯", "1 day in a row", f"{screen.url}/today.html"]

    page.reload()
    screen.landed(record["bin"])
    expect(page.get_by_role("button", name="Bin 0")).to_be_disabled()
    expect(page.locator("#streak")).to_have_text("1")

    page.add_init_script(DAY.format(2))
    page.reload()
    screen.state("replay")
    record = screen.api(f"drops/triangle-9/{SEEDS[2]}")
    guess = record["bin"] + 1 if record["bin"] < 9 else record["bin"] - 1
    page.get_by_role("button", name=f"Bin {guess}, ").tap()
    expect(screen.result).to_have_text(f"1 bin off: it landed on {record['score']:g}x.")
    expect(page.locator("#streak")).to_have_text("2")
    expect(page.locator("#right")).to_have_text("1 of 2")


def test_with_reduced_motion_and_keys_alone_the_result_is_shown_at_once(opened: Open) -> None:
    screen = opened("/today.html", before=DAY.format(1), reduced_motion="reduce").state("replay")
    screen.page.get_by_role("button", name="Bin 0, ").focus()
    screen.page.keyboard.press("Enter")
    expect(screen.page.get_by_role("button", name="Share")).to_be_visible()


@pytest.mark.parametrize("device", ["phone", "desk"])
def test_the_ball_of_the_day_fits_its_screens(opened: Open, device: str) -> None:
    screen = opened("/today.html", **context_for(device)).state("replay")
    for name in each_screen(screen, device):
        check_fit(screen)
        check_axe_on(screen, name)
        screen.shot(f"today-{name}")


def test_the_front_page_leads_to_the_ball_of_the_day(opened: Open) -> None:
    screen = opened("/", **context_for("phone")).ready()
    screen.page.get_by_role("link", name="Ball of the day").first.click()
    screen.state("replay")
    assert screen.page.url.endswith("/today.html")
    screen.page.goto(f"{screen.url}/replay.html?today")
    screen.page.wait_for_url("**/today.html")
