"""A table with a draw shows that and its odds, and its session's check covers the draw."""

from playwright.sync_api import expect

from tests.browser.conftest import Open, quick_table
from tests.kit.address import Address


def test_a_draw_shows_its_odds_and_its_session_is_proven(opened: Open, server: Address) -> None:
    odds = [1, 0, 0, 0, 9997, 0, 0, 0, 2]
    table = quick_table(server, "triangle-8", "draw", prize="Prize", odds=odds)
    screen = opened(f"{table.page}&seed=42").ready()
    page = screen.page
    expect(page.locator("#odds-note")).to_contain_text("published odds pick the bin")
    expect(page.locator("#draw")).to_be_visible()
    expect(page.locator("#draw-odds > li")).to_have_count(3)
    for place, words in enumerate(("1 in 10,000", "9,997 in 10,000", "1 in 5,000")):
        expect(page.locator("#draw-odds > li").nth(place)).to_contain_text(words)
    expect(page.locator("#draw-odds > li").first).to_contain_text("Prize")
    expect(page.locator("#start")).to_be_hidden()
    screen.drawer("For the curious")
    expect(page.get_by_label("Ghost trails")).to_be_visible()
    expect(screen.seed).to_be_hidden()
    expect(screen.seed).to_have_value("")
    screen.drawer("Game")
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    expect(screen.rows.get_by_role("link", name="Replay")).to_be_visible()
    expect(page.locator(".use-seed")).to_be_hidden()
    page.locator("#padlock").click()
    expect(page.locator("#fair-words")).to_contain_text("Together they draw a bin")
    page.get_by_role("button", name="Reveal and check").click()
    expect(page.locator("#fair-verdict")).to_contain_text("Proven: neither side could choose")
    drop = page.locator("#fair-steps details").nth(1)
    drop.locator("summary").click()
    said = drop.locator("[data-step=start]")
    expect(said).to_contain_text(
        "The bin was drawn by published odds, then a ball that falls there"
    )
    expect(drop.locator("[data-step=drawn-bin]")).to_have_attribute("data-ok", "true")
    screen.shot("draw")
    page.goto(f"{screen.url}/?room=main")
    expect(page.locator("#draw")).to_be_hidden()
    page = opened(table.page, locale="de-DE").ready().page
    expect(page.locator("#draw-odds > li").nth(1)).to_contain_text("9.997 von 10.000")
    expect(page.locator("#odds-note")).to_contain_text("Eine Ziehung")
