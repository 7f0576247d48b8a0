"""axe finds nothing to complain about, on a phone and on a desk, in light and in dark."""

import pytest
from playwright.sync_api import expect

from tests.browser.axe import check_axe
from tests.browser.conftest import Open, Quick
from tests.browser.looks import context_for


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("width", "height"), [(360, 740), (1400, 900)])
def test_axe_has_nothing_to_say(
    opened: Open, quick: Quick, width: int, height: int, scheme: str
) -> None:
    screen = opened(quick.page, **context_for(width, height, scheme)).ready()
    panel = screen.page.locator("#measure")
    if panel.get_attribute("open") is None:
        panel.locator("summary").click()
    screen.page.get_by_role("radio", name="I choose").check()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    check_axe(screen)
    screen.page.screenshot(path=screen._artifacts / f"whole-{width}-{scheme}.png", full_page=True)
