"""When the server dies, the page says so, reconnects, and loses no accepted drop."""

import signal

from playwright.sync_api import expect

from plinko.engine import drop
from tests.browser.conftest import Complaints, Open, quick_table
from tests.kit.process import ServerProcess

# Errors about requests to a killed server: Chromium names each way in which they fail.
GONE = r"WebSocket connection .* failed|net::ERR_\w+"


def test_play_goes_on_after_the_server_is_killed_and_restarted(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    quick = quick_table(mortal, "triangle-8")
    screen = opened(f"{mortal.url}{quick.page}").ready()
    screen.seed.fill("42")
    mortal.end(signal.SIGKILL)
    screen.state("reconnecting")
    expect(screen.page.locator("#state-text")).to_contain_text("Offline. Next try")
    screen.drop.click()
    expect(screen.result).to_contain_text("(practice)")
    expect(screen.page.locator("#staked")).to_have_text("0.00")
    screen.drawer("Game")
    screen.rows.get_by_role("button", name="Verify").click()
    expect(screen.rows).to_contain_text("Computed again in this page")

    mortal.start()
    screen.ready()
    expect(screen.result).to_have_text("Connected again.")
    expect(screen.seed).to_have_value("42")
    expect(screen.page.locator("#staked")).to_have_text("0.00")
    screen.drop.click()
    landing = drop(quick.whole, 42).bin
    assert landing is not None
    screen.landed(landing)
    expect(screen.rows).to_have_count(2)
    complaints.allow(GONE)


def test_a_ball_in_flight_is_paid_though_the_server_died(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    screen = opened(f"{mortal.url}/?room=triangle-8").ready()
    screen.drop.click()
    screen.state("live")
    mortal.end(signal.SIGKILL)
    screen.state("reconnecting")
    expect(screen.rows).to_have_count(0)
    mortal.start()
    expect(screen.rows).to_have_count(1)
    record = screen.last_dropped()
    screen.landed(record["bin"])
    expect(screen.page.locator("#staked")).to_have_text("1.00")
    expect(screen.page.locator("#returned")).to_have_text(f"{record['score']:.2f}")
    complaints.allow(GONE)
