"""Every field for a number takes a decimal comma, and names an invalid number."""

import re
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Open

REPLAY = "/replay.html?board=triangle-8&seed=1"
COMPARE = "/replay.html?board=triangle-8&seed=1&compare"


@pytest.mark.parametrize("address", [REPLAY, COMPARE])
def test_a_start_may_have_a_comma(opened: Open, address: str) -> None:
    page = opened(address).state("replay").curious().page
    page.locator("#other-x").fill("0,0625")
    page.locator("#other-x").press("Enter")
    page.wait_for_url(re.compile(r"[?&]x=0\.0625"))
    expect(page.locator("html")).to_have_attribute("data-state", "replay")
    if address == REPLAY:
        page.locator("#curious summary").click()
    expect(page.locator("#other-x")).to_have_value("0.0625")
    page.locator("#other-x").fill("here")
    page.locator("#other-x").press("Enter")
    expect(page.locator("#other-note")).to_have_text("“here” is not a number.")
    expect(page.locator("#other-x")).to_be_focused()
    page.locator("#other-x").fill("")
    page.locator("#other-x").press("Enter")
    page.wait_for_url(lambda url: "x=" not in url)


def test_the_sandbox_s_sizes_may_have_a_comma(opened: Open) -> None:
    screen = opened("/sandbox.html").state("live", "asleep")
    page = screen.page
    page.get_by_role("heading", name="More").click()
    page.get_by_label("Width, m").fill("3,5")
    page.get_by_label("Balls", exact=True).fill("7")
    page.get_by_role("button", name="Begin", exact=True).click()
    expect(page.locator("#board-moving")).to_have_attribute("aria-label", re.compile(r"\b7 balls"))
    expect(page.get_by_label("Width, m")).to_have_value("3.5")
    page.get_by_label("Width, m").fill("wide")
    page.get_by_role("button", name="Begin", exact=True).click()
    expect(screen.result).to_have_text("“wide” is not a number.")
    expect(page.get_by_label("Width, m")).to_be_focused()


def test_the_editor_s_arrow_keys_step_from_a_number_with_a_comma(opened: Open) -> None:
    page: Any = opened("/editor.html").state("asleep").page
    field = page.locator("#at-gravity")
    field.fill("1,5")
    field.press("ArrowUp")
    expect(field).to_have_value(re.compile(r"^1\.[5-9]\d*$"))
