"""After a visitor chooses German on a phone, every page is German, and no text overflows."""

import re

import pytest
from playwright.sync_api import ViewportSize, expect

from tests.browser.conftest import Open, Quick
from tests.long import tries

PHONE: ViewportSize = {"width": 390, "height": 844}
PAGES = tries(
    ["replay.html?board=triangle-8&seed=1"],
    [
        *(
            "replay.html?board=triangle-8&seed=1",
            "replay.html?compare",
            "editor.html",
            "sandbox.html",
        ),
        *(
            "verify.html",
            "today.html",
            "class.html",
            "stage.html",
            "replay.html?board=triangle-8&seed=1&embed",
        ),
    ],
)

# Elements that reach beyond the window, and controls narrower than their text.
OVERFLOWING = """
[...document.querySelectorAll("body *")]
  .filter((element) => element.offsetParent !== null && !element.closest(".visually-hidden, .skip"))
  .filter((element) => element.getBoundingClientRect().right > innerWidth + 1
    || (element.matches("button, legend, output, .chip span, .places a")
        && element.scrollWidth > element.clientWidth + 1 && element.clientWidth > 0))
  .map((element) => `${element.tagName} ${element.id}: ${element.textContent.trim()}`)
"""


@pytest.mark.long
def test_german_once_chosen_is_used_everywhere_and_fits_a_phone(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, viewport=PHONE, locale="es-ES").ready()
    page = screen.page
    german = page.locator("html[lang=de]")
    expect(page.locator("html")).to_have_attribute("lang", "es")
    page.get_by_role("button", name="Más").click()
    page.keyboard.press("s")  # opens the drawer with the choice, if the page has one
    page.get_by_label("Idioma").select_option("Deutsch")
    expect(german).to_be_attached()
    screen.ready()
    drop = page.get_by_role("button", name="Werfen")
    expect(drop).to_be_visible()
    for drawer in ("Tisch", "Fairness", "Mehr wissen"):
        page.get_by_role("button", name=drawer, exact=True).click()
        assert page.evaluate(OVERFLOWING) == []
    drop.click()
    expect(screen.result).to_have_text(
        re.compile(r"^[\d,]+x: [\d,]+ gesetzt, [\d,]+ gewonnen \([+−]?[\d,]+\)$")
    )
    for path in PAGES:
        page.goto(f"{screen.url}/{path}")
        expect(german).to_be_attached()
        expect(page.locator("html:not([data-state=connecting])")).to_be_attached()
        assert page.evaluate(OVERFLOWING) == [], path
