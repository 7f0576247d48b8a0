"""axe finds no fault in the table, on phone and desk, in light and dark."""

import pytest
from playwright.sync_api import expect

from tests.browser.access.axe import asks_axe, check_axe
from tests.browser.conftest import Open, quick_table
from tests.browser.looks import SCREENS, context_for, each_screen
from tests.kit.address import Address


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_axe_has_nothing_to_say(opened: Open, server: Address, device: str) -> None:
    quick = quick_table(server, "classic")  # its drops can be aimed
    screen = opened(quick.page, **context_for(device)).ready()
    screen.drawer("For the curious").locator("#measure summary").click()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    for name in each_screen(screen, device, asks_axe):
        check_axe(screen)
        screen.shot(f"whole-{name}", full_page=True)
