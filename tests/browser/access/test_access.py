"""The page is playable without mouse, picture or motion, on a phone and on a wall."""

import re

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Open, Quick, quick_table
from tests.browser.looks import SCREENS, check_fit, context_for, each_screen, painted
from tests.browser.screen import COUNT_FRAMES
from tests.kit.address import Address


def test_a_whole_game_by_keyboard_alone(opened: Open, server: Address) -> None:
    quick = quick_table(server, "classic")
    screen = opened(quick.page).ready()
    keyboard = screen.page.keyboard
    keyboard.press("l")
    seed = screen.page.get_by_label("Seed", exact=True)
    expect(seed).to_be_visible()
    for _ in range(20):
        if seed.evaluate("field => field === document.activeElement"):
            break
        keyboard.press("Tab")
    expect(seed).to_be_focused()
    keyboard.type("42")
    keyboard.press("Enter")
    record = screen.api(f"drops/{quick.board}/42")
    screen.landed(record["bin"])
    expect(screen.page.locator("#staked")).to_have_text("0.00")  # a chosen seed is practice

    screen.seed.fill("")
    screen.seed.evaluate("field => field.blur()")
    keyboard.press("Space")
    expect(screen.page.locator("#staked")).to_have_text("1.00")
    expect(screen.rows).to_have_count(2)

    keyboard.press("t")
    screen.page.get_by_role("radio", name="Random").focus()
    keyboard.press("ArrowRight")
    expect(screen.page.get_by_role("radio", name="Slot 1")).to_be_checked()
    keyboard.press("Escape")
    keyboard.press("Space")  # presses the button More, which has the focus
    expect(screen.page.locator("#more")).to_have_attribute("aria-expanded", "true")
    screen.page.evaluate("document.activeElement.blur()")
    keyboard.press("Space")
    expect(screen.rows).to_have_count(3)
    link = screen.rows.first.locator("a")
    assert "aim=-" in (link.get_attribute("href") or "")


def test_space_in_the_seed_field_is_no_digit_and_does_not_drop(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.seed.focus()
    screen.page.keyboard.type("1 2")
    expect(screen.seed).to_have_value("12")
    assert screen.drops_sent == []


def test_what_has_the_focus_is_seen_to_have_it(opened: Open) -> None:
    screen = opened().ready()
    screen.page.keyboard.press("Tab")  # to the link that skips the head, which nothing may cover
    assert (
        screen.page.evaluate(
            """() => {
          const { x, y, width, height } = document.activeElement.getBoundingClientRect();
          return document.elementFromPoint(x + width / 2, y + height / 2).className;
        }"""
        )
        == "skip"
    )
    seen = 0
    for _ in range(13):
        screen.page.keyboard.press("Tab")
        outlined = screen.page.evaluate(
            """() => {
              const focused = document.activeElement;
              if (focused === document.body) return null;
              const shown = focused.matches(".chip input") ? focused.nextElementSibling : focused;
              return parseFloat(getComputedStyle(shown).outlineWidth) >= 2
                && getComputedStyle(shown).outlineStyle !== "none";
            }"""
        )
        assert outlined in (True, None)
        seen += outlined is True
    assert seen >= 8


def test_screen_readers_receive_the_result(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    expect(screen.result).to_have_attribute("aria-live", "polite")
    board = screen.page.get_by_role("img", name=re.compile(r"8 rows of pegs over 9 bins"))
    expect(board).to_have_count(1)
    screen.seed.fill("42")
    screen.drop.click()
    record = screen.api(f"drops/{quick.board}/42")
    expect(screen.page.get_by_role("status").filter(visible=True)).to_contain_text("(practice)")
    histogram = screen.page.get_by_role("img", name=re.compile("Histogram of"))
    expect(histogram).to_have_accessible_name(re.compile(rf"bin {record['bin']}: \d"))


def test_reduced_motion_shows_path_and_result_but_no_moving_ball(opened: Open) -> None:
    page = "/?room=triangle-8"
    screen = opened(page, before=COUNT_FRAMES, reduced_motion="reduce").ready()
    screen.seed.fill("42")
    screen.drop.click()
    screen.state("live")
    assert painted(screen, "board-moving") == 0
    screen.landed(screen.api("drops/triangle-8/42")["bin"])
    screen.ready().at_rest()  # the bin's light has faded, but the path stays
    first = painted(screen, "board-moving")
    assert first > 500, "the path is drawn"
    screen.frames(12)
    assert painted(screen, "board-moving") == first
    screen.shot("reduced-motion")


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_the_page_fits_its_screens(opened: Open, device: str) -> None:
    screen = opened(**context_for(device)).ready()
    for name in each_screen(screen, device):
        check_fit(screen)
        box, window = screen.drop.bounding_box(), screen.page.viewport_size
        assert box is not None
        assert window is not None
        assert box["y"] + box["height"] <= window["height"], "the button is seen without scrolling"
        (screen.drop.tap if device == "phone" else screen.drop.click)()
        screen.state("live")
        screen.shot(f"page-{name}")


@pytest.mark.parametrize("name", ["classic", "galton", "triangle-8-high", "triangle-16-high"])
def test_every_board_fits_a_phone(opened: Open, name: str) -> None:
    screen = opened(f"/?room={name}", **context_for("phone")).ready()
    check_fit(screen)
    screen.drop.tap()
    screen.state("live")
    screen.shot(f"{name}-360")


def test_a_touch_above_the_pegs_drops(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, **context_for("phone")).ready()
    screen.page.locator("#board-moving").tap(position={"x": 190, "y": 30})
    expect(screen.rows).to_have_count(1)


def test_the_canvas_is_as_fine_as_the_display(opened: Open) -> None:
    screen = opened(viewport={"width": 390, "height": 844}, device_scale_factor=3).ready()
    fine = """(within) => {
      const { width, clientWidth } = document.getElementById("board-still");
      return Math.abs(width / clientWidth - 3) <= within;
    }"""
    screen.page.wait_for_function(fine, arg=0)
    screen.page.set_viewport_size({"width": 844, "height": 390})
    screen.page.wait_for_function(fine, arg=0.01)


def test_nothing_is_loaded_from_elsewhere(opened: Open) -> None:
    screen = opened().ready()
    loaded = screen.page.evaluate(
        "performance.getEntriesByType('resource').map((entry) => entry.name)"
    )
    assert any(address.endswith("/js/play/all.en.js") for address in loaded)
    assert all(address.startswith(f"{screen.url}/") for address in loaded)
