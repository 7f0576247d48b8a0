"""The seed field accepts seeds to the last digit, and names invalid ones."""

from playwright.sync_api import expect

from tests.browser.conftest import Open, Quick

BAD = ["-1", "18446744073709551616", "abc", "1.5", "1e3", "0x10", "NaN", "9" * 400, "１２"]


def test_a_bad_seed_is_named_and_a_good_one_is_practice_until_it_is_ended(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    note = screen.page.get_by_role("alert")
    for text in BAD:
        screen.seed.fill(text)
        screen.drop.click()
        expect(note).to_contain_text(text[:20])
        expect(note).to_contain_text("18446744073709551615")
        expect(screen.seed).to_have_attribute("aria-invalid", "true")
        expect(screen.seed).to_be_focused()
        assert screen.drops_sent == [], text
        screen.seed.blur()

    screen.seed.fill("42")
    expect(note).to_have_count(0)
    expect(screen.drop).to_contain_text("Practice")
    stake = screen.page.locator("#stake")
    expect(stake).to_be_hidden()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    assert [message["seed"] for message in screen.drops_sent] == ["42"]
    screen.page.get_by_role("button", name="Play for credits").click()
    expect(screen.drop).to_contain_text("Drop")
    expect(stake).to_be_visible()


def test_a_ball_of_the_list_falls_once_more_as_practice(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    screen.rows.first.get_by_role("button", name="Practice: the ball of seed").click()
    expect(screen.rows).to_have_count(2)
    expect(screen.result).to_contain_text("(practice)")
    links = [screen.rows.nth(row).locator("a").get_attribute("href") for row in (0, 1)]
    assert links[0] == links[1]
    expect(screen.drop).to_contain_text("Drop")  # practice has ended
    expect(screen.page.locator("#staked")).to_have_text("1.00")
