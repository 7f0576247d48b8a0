"""A reload, another table or a new tab loses nothing of a player; credits limit stakes."""

import json

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import Open, Quick, quick_table
from tests.kit.address import Address

GRANT = 1000


@pytest.fixture
def other(server: Address) -> Quick:
    """Another table, whose drops can be aimed."""
    return quick_table(server, "classic")


def settled(page: Page, drops: int) -> None:
    """Check that all staked drops have landed, and that score and balance agree."""
    expect(page.locator("#drops > li")).to_have_count(drops)
    expect(page.locator("#staked")).to_have_text(f"{drops:.2f}")
    net = float(page.locator("#net").inner_text().replace("−", "-").replace(",", ""))
    expect(page.locator("#balance")).to_have_text(f"{GRANT + net:,.2f}")


def test_balls_and_score_survive_a_reload_and_open_in_a_new_tab(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_label("Stake", exact=True).fill("1")
    screen.staked(5)
    screen.page.reload()
    settled(screen.page, 5)
    tab = screen.page.context.new_page()
    tab.goto(f"{screen.url}{quick.page}")
    settled(tab, 5)
    expect(tab.get_by_role("radio", name="5 balls")).to_be_checked()
    tab.close()


def test_balls_are_paid_though_their_player_changed_tables(
    opened: Open, quick: Quick, other: Quick
) -> None:
    screen = opened(quick.page).ready()
    screen.staked(5)
    screen.page.goto(f"{screen.url}{other.page}")
    settled(screen.page, 5)


def test_no_more_is_staked_than_there_is_and_a_top_up_gives_more(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_label("Stake", exact=True).fill("1000.01")
    screen.drop.click()
    expect(screen.result).to_have_text("Not enough credits. Lower your stake or top up.")
    assert not screen.drops_sent
    void = {"board": "classic", "name": "classic", "seed": "1", "x": None, "bin": None, "score": 1,
            "stake": 1, "paid": 1}  # fmt: skip
    account = {"grants": 1, "sessions": {}, "before": {"staked": 99_950, "paid": 0}, "away": [],
               "last": [void]}  # fmt: skip
    screen.page.evaluate(
        "(account) => { localStorage['plinko.account.1'] = account; }", json.dumps(account)
    )
    screen.page.reload()
    expect(screen.page.locator("#balance")).to_have_text("0.50")
    expect(screen.rows).to_have_count(1)
    expect(screen.rows).to_contain_text("returned")
    screen.page.get_by_role("button", name="Top up").click()
    expect(screen.page.locator("#balance")).to_have_text("1,000.00")
    expect(screen.result).to_have_text("Topped up by 999.50 credits.")


def test_table_and_aim_are_kept_and_drops_found_by_a_mark(opened: Open, other: Quick) -> None:
    screen = opened(other.page).ready()
    screen.drawer("Table").get_by_role("radio", name="Slot 7").check()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    expect(screen.page.locator("#practice-note")).to_have_text("Practice: you chose the start")
    (sent,) = screen.drops_sent
    tab = screen.page.context.new_page()
    tab.goto(screen.url)
    expect(tab.get_by_label("Slot 7")).to_be_checked()
    assert sent["aim"] == other.whole.drop.slots[6]
    plays = tab.locator("#plays-json").get_attribute("href")
    (play,) = json.loads(tab.evaluate("(url) => fetch(url).then((reply) => reply.text())", plays))[
        "plays"
    ]
    assert (play["room"], play["aim"], play["stake"]) == (other.room, sent["aim"], 0)
    tab.close()
    screen.page.get_by_role("button", name="Play for credits").click()
    expect(screen.page.get_by_role("radio", name="Random")).to_be_checked()
    expect(screen.page.locator("#drop-label")).to_have_text("Drop")
