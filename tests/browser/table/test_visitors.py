"""Two visitors of a table see each other and their wins; real balls replace demo balls."""

import re

from playwright.sync_api import expect

from tests.browser.conftest import Complaints, Open, Quick


def test_two_visitors_meet_and_the_demo_ends_with_the_first_ball(
    opened: Open, quick: Quick
) -> None:
    one = opened(quick.page).ready()
    expect(one.page.locator("#visitors-here")).to_have_text("Nobody else is here.")
    two = opened(quick.page, viewport={"width": 390, "height": 844}).ready()
    expect(one.page.locator("#people")).to_have_text("Guest 2")
    two.drawer("Game")
    two.page.get_by_text("Your name and colour").click()
    two.page.get_by_label("Name").fill("Ada")
    two.page.get_by_label("Colour 5").check()
    expect(one.page.locator("#people")).to_have_text("Ada")
    expect(one.page.locator("#people .swatch")).to_have_css("background-color", "rgb(79, 227, 177)")

    one.drawer("Settings").get_by_label("Demo balls").check()
    mark = one.page.locator("#demo-mark")
    expect(mark).to_be_visible()
    assert not one.drops_sent, "demo balls are no server's business"
    expect(one.page.locator("#tray-count")).to_have_text("Nothing has landed here yet")
    two.drop.click()
    expect(mark).to_be_hidden()
    one.drawer("Game")
    landing = one.page.locator("#landings > li")
    expect(landing).to_have_text(re.compile(r"^Ada[\d.]+x\d+\.\d\dReplay$"))
    expect(one.page.locator("#feed > li")).to_have_text(re.compile(r"^Ada[\d.]+x\d+\.\d\d$"))
    expect(two.page.locator("#feed > li")).to_have_count(0)
    expect(landing.get_by_role("link")).to_have_attribute("href", re.compile(quick.board))
    expect(one.page.locator("#tray-count")).to_have_text("1 ball landed at this table")

    two.page.close()
    expect(one.page.locator("#visitors-here")).to_have_text("Nobody else is here.")
    one.page.get_by_role("button", name="Invite").click()
    expect(one.page.locator("#invite-link")).to_have_value(f"{one.url}{quick.page}")


def test_a_name_typed_before_its_code_has_come_is_kept(
    opened: Open, quick: Quick, complaints: Complaints
) -> None:
    one = opened(quick.page).ready()
    two = opened(quick.page, viewport={"width": 390, "height": 844}).ready()
    code = "**/visitors-parts*.js"
    complaints.allow(r"net::ERR_FAILED .*/visitors-parts.*js")
    two.page.route(code, lambda route: route.abort())
    two.drawer("Game")
    with two.page.expect_event("requestfailed"):
        two.page.get_by_text("Your name and colour").click()
    two.page.get_by_label("Name").fill("Ada")
    two.page.get_by_label("Name").blur()
    two.page.unroute(code)

    def comes() -> int:
        two.page.keyboard.press("Shift")  # a key tries again, unless a try still fails
        return two.page.locator("#self-colours input").count()

    two.until(comes)
    expect(one.page.locator("#people")).to_have_text("Ada")
    expect(two.page.get_by_label("Name")).to_have_value("Ada")
