"""Only the connection breaks, not the server: the player keeps the drops."""

import httpx
import pytest
from playwright.sync_api import expect

from plinko.app.cli import main
from tests.browser.conftest import Complaints, Open
from tests.browser.screen import STATES
from tests.kit.address import Address
from tests.kit.process import OPERATOR
from tests.kit.waiting import LIMIT


def test_a_ball_in_flight_stays_ours_when_only_the_line_broke(opened: Open) -> None:
    screen = opened("/?room=triangle-8", before=STATES + _BREAKABLE).ready()
    screen.drop.click()
    screen.state("live")
    screen.page.evaluate("last_socket.close()")
    screen.passed("reconnecting", "live")
    expect(screen.rows).to_have_count(1)
    screen.landed(screen.last_dropped()["bin"])
    expect(screen.page.locator("#staked")).to_have_text("1.00")


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (820, 1180), (390, 844)])
def test_a_lost_line_moves_nothing_on_the_desk(
    opened: Open, complaints: Complaints, width: int, height: int
) -> None:
    german = {"viewport": {"width": width, "height": height}, "locale": "de"}
    screen = opened("/?room=triangle-8", before=_LOSABLE, **german).ready()
    before = screen.steady(screen.drop.bounding_box)  # once the odds have come
    screen.page.evaluate("lose()")
    screen.state("reconnecting")
    expect(screen.page.locator("#line-key")).to_be_visible()
    assert screen.drop.bounding_box() == before
    complaints.allow("WebSocket")


def test_a_drop_whose_acceptance_was_lost_is_kept(opened: Open) -> None:
    screen = opened("/?room=triangle-8", before=STATES + _BREAKS_AFTER_A_DROP).ready()
    screen.drop.click()
    screen.passed("reconnecting", "live")
    expect(screen.rows).to_have_count(1)
    screen.landed(screen.last_dropped()["bin"])
    expect(screen.page.locator("#staked")).to_have_text("1.00")


def test_a_halted_table_says_so_and_takes_no_drop(
    opened: Open, server: Address, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", OPERATOR)
    rooms = f"{server.url}/api/v1/rooms"
    room = httpx.post(rooms, json={"board": "triangle-8"}, timeout=LIMIT).json()["id"]
    screen = opened(f"/?room={room}").ready()
    screen.drop.click()
    screen.state("live")
    assert main(["halt", server.url, "--room", room]) == 0
    expect(screen.result).to_have_text("This table is paused. Balls in flight land and are paid.")
    expect(screen.rows).to_have_count(1)  # the ball in flight has landed
    screen.drop.click()
    expect(screen.result).to_contain_text("This table is paused.")
    assert main(["halt", server.url, "--room", room, "--release"]) == 0
    expect(screen.result).to_have_text("This table is open again.")
    screen.drop.click()
    expect(screen.rows).to_have_count(2)


def test_an_announcement_is_shown_until_it_ends(
    opened: Open, server: Address, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", OPERATOR)
    notice = opened("/").ready().page.locator("#notice")
    expect(notice).to_be_hidden()
    assert main(["announce", "Maintenance at 18:00", server.url]) == 0
    expect(notice).to_have_text("Maintenance at 18:00")
    expect(notice).to_be_visible()
    assert main(["announce", "", server.url]) == 0
    expect(notice).to_be_hidden()


_BREAKS_AFTER_A_DROP = """
window.WebSocket = class extends WebSocket {
  send(data) {
    super.send(data);
    if (window.broken || !data.includes('"drop"')) return;
    window.broken = true;
    this.onmessage = null;
    this.close();
  }
};
"""

# After `lose()` no connection opens.
_LOSABLE = """
window.WebSocket = class extends WebSocket {
  constructor(...all) {
    super(...all);
    if (window.lost) this.close();
    window.lose = () => { window.lost = true; this.close(); };
  }
};
"""

_BREAKABLE = """
window.WebSocket = class extends WebSocket {
  constructor(...all) { super(...all); window.last_socket = this; }
};
"""
