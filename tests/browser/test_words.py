"""Players read no words of the laboratory before they open its door."""

import json
import re

import pytest
from playwright.sync_api import ViewportSize, expect

from tests.browser.conftest import ROOT, Open
from tests.browser.screen import Screen

TEXTS = {
    path.stem: json.loads(path.read_text()) for path in (ROOT / "static/js/texts").glob("??.json")
}
INNER = r"\b(?:fm|[Gp]|digest|Prüfsumme|resumen|[Tt]icks?|triangle-\d+|Seed|semilla)\b"
DESK: ViewportSize = {"width": 1280, "height": 800}
PHONE: ViewportSize = {"width": 390, "height": 844}


def read(screen: Screen, language: str) -> str:
    """What the page shows; fails if it has a word that belongs behind the door."""
    shown = screen.page.locator("body").inner_text()
    behind = [re.escape(TEXTS[language][key]) for key in ("lab.seed-place", "lab.fit-to")]
    found = re.search("|".join([INNER, *behind]), shown)
    assert not found, f"{found[0]!r} in {shown[max(0, found.start() - 80) : found.end() + 80]!r}"
    return shown


@pytest.mark.parametrize("language", sorted(TEXTS))
def test_the_table_says_nothing_of_the_laboratory(opened: Open, language: str) -> None:
    screen = opened(f"/?language={language}", viewport=DESK).ready()
    page, texts = screen.page, TEXTS[language]
    read(screen, language)
    page.locator("input[name=pace][value=instant]").check(force=True)
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    screen.ready()
    read(screen, language)
    for size in (DESK, PHONE):
        page.set_viewport_size(size)
        read(screen, language)
        for name in ("play.score", "play.table", "play.fairness", "play.settings"):
            tab = page.get_by_role("button", name=texts[name], exact=True)
            if not tab.is_visible():
                page.locator("#more").click()
            if tab.get_attribute("aria-expanded") != "true":
                tab.click()
            assert texts[name] in read(screen, language)


@pytest.mark.parametrize("language", sorted(TEXTS))
@pytest.mark.parametrize("option", ["", "&embed"])
def test_a_replay_says_nothing_of_the_laboratory(opened: Open, language: str, option: str) -> None:
    screen = opened(f"/replay.html?board=triangle-8&seed=42&language={language}{option}").state(
        "replay"
    )
    read(screen, language)
    if not option:
        for name in ("certify", "share-film", "save-table", "facts"):
            expect(screen.page.locator(f"#{name}")).to_be_hidden()
        screen.page.get_by_text(TEXTS[language]["play.lab"], exact=True).click()
        expect(screen.page.locator("#facts")).to_be_visible()


def test_the_words_are_found_where_they_are(opened: Open) -> None:
    screen = opened("/replay.html?board=triangle-8&seed=42").state("replay")
    screen.page.locator("#curious summary").click()
    with pytest.raises(AssertionError, match="triangle-8"):
        read(screen, "en")
