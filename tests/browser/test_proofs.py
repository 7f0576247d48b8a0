"""Proofs on the pages of one drop and of two."""

from playwright.sync_api import expect

from plinko.engine import Board, certify
from tests.browser.conftest import Open


def test_a_replay_shows_its_bin_as_certified_with_the_enclosure(opened: Open) -> None:
    screen = opened("/replay.html?board=triangle-8&seed=42").state("replay").curious()
    proven = certify(Board.preset("triangle-8"), 42)
    screen.page.get_by_role("button", name="Certify").click()
    verdict = screen.page.locator("#verdict")
    expect(verdict).to_contain_text(f"Certified: bin {proven.bin}")
    assert proven.x_end is not None
    expect(verdict).to_contain_text(proven.x_end.text)


def test_compare_shows_where_two_proven_paths_part(opened: Open) -> None:
    screen = opened("/replay.html?board=triangle-8&seed=42&compare&with=43").state("replay")
    screen.page.get_by_role("button", name="Prove where they part").click()
    expect(screen.page.locator("#proven")).to_contain_text("events are common to both, then the")
