"""The map of starts, and the proofs on the pages replay and compare."""

import re

import pytest
from playwright.sync_api import expect

from plinko.engine import Board, certify
from tests.browser.access.axe import check_axe_on
from tests.browser.conftest import Open
from tests.browser.looks import SCREENS, check_fit, context_for, each_screen


def test_the_map_asks_for_proven_tiles_and_a_click_zooms_in(opened: Open) -> None:
    screen = opened("/map.html?board=triangle-8&x=1/100")
    page = screen.page
    expect(page.locator(".map-width").first).to_have_text(re.compile(r"^\de[+-]\d+ m$"))
    expect(screen.result).to_contain_text("proofs")
    strip = page.locator(".map-strip").first
    box = strip.bounding_box()
    assert box is not None
    strip.click(position={"x": 1, "y": box["height"] / 2})
    page.wait_for_url(re.compile(r"x=-?\d+%2F\d+"))
    expect(page.locator(".map-width").first).to_have_text(re.compile(r" m$"))


def test_a_replay_shows_its_bin_as_certified_with_the_enclosure(opened: Open) -> None:
    screen = opened("/replay.html?board=triangle-8&seed=42").state("replay")
    proven = certify(Board.preset("triangle-8"), 42)
    screen.page.get_by_role("button", name="Certify").click()
    verdict = screen.page.locator("#verdict")
    expect(verdict).to_contain_text(f"Certified: bin {proven.bin}")
    assert proven.x_end is not None
    expect(verdict).to_contain_text(proven.x_end.text)


def test_compare_shows_where_two_proven_paths_part(opened: Open) -> None:
    screen = opened("/compare.html?board=triangle-8&seed=42&shift=seed&with=43").state("replay")
    screen.page.get_by_role("button", name="Prove where they part").click()
    expect(screen.page.locator("#proven")).to_contain_text("events are common to both, then the")


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_the_map_fits_every_screen_and_axe_has_nothing_to_say(opened: Open, device: str) -> None:
    screen = opened("/map.html?board=triangle-8&x=1/100", **context_for(device))
    expect(screen.result).to_contain_text("proofs")
    for name in each_screen(screen, device):
        check_fit(screen)
        check_axe_on(screen, name)
        screen.shot(f"map-{name}", full_page=True)
