"""At every size each control of the desk is visible, uncovered, hittable and has all its text."""

import json
import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Open
from tests.browser.screen import Screen
from tests.long import tries

TEXTS = Path(__file__).parents[3] / "static/js/texts"
SIZES = [
    *((1280, 800), (1366, 768), (1920, 1080), (2560, 1440), (1024, 768)),
    *((768, 1024), (810, 1080), (834, 1112), (820, 1180), (700, 900), (600, 1000)),
    *((600, 700), (390, 844), (360, 640), (320, 568), (844, 390), (568, 320)),
    (640, 400),  # 1280x800 at 200 %
]

# All faults of the controls of the head, the board and the desk.
_FAULTS = """
() => {
  const faults = [];
  const ink = document.createElement("canvas").getContext("2d");
  const parts = ".marquee, .corner, .told, .play, .worlds, .drawer-tabs";
  const controls = [...document.querySelectorAll("button, input, select, a")]
    .filter((control) => control.closest(parts) && !control.disabled)
    .filter((control) => control.checkVisibility({ visibilityProperty: true }));
  for (const control of controls) {
    const name = control.id || `${control.name}=${control.value}` || control.textContent;
    const swiped = control.closest(".auto-panel"); // on low phones its fields lie in one row
    if (swiped) swiped.scrollLeft = control.offsetLeft - swiped.offsetLeft;
    const { left, top, right, bottom } = control.getBoundingClientRect();
    if (left < -0.5 || top < -0.5 || right > innerWidth + 0.5 || bottom > innerHeight + 0.5) {
      faults.push(`${name} is not in view: ${[left, top, right, bottom].map(Math.round)}`);
      continue;
    }
    if (right - left < 24 || bottom - top < 24) faults.push(`${name} is too small`);
    const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    if (!control.contains(hit) && !control.closest("label")?.contains(hit)) {
      faults.push(`${name} is covered by ${hit?.id || hit?.className}`);
    }
    if (control instanceof HTMLSelectElement) {
      const style = getComputedStyle(control);
      ink.font = style.font;
      const padding = parseFloat(style.paddingLeft) + parseFloat(style.paddingRight);
      const text = control.selectedOptions[0]?.text ?? "";
      if (ink.measureText(text).width > control.clientWidth - padding + 1) {
        faults.push(`${name}: ${text} is cut`);
      }
    }
  }
  const written = ":is(button, label, legend, .chip span, .place span)";
  for (const words of document.querySelectorAll(`:is(${parts}) ${written}`)) {
    if (!words.checkVisibility() || words.closest(".visually-hidden")) continue;
    if (words.clientWidth < 2) continue;
    if (words.scrollWidth <= words.clientWidth + 1) continue;
    faults.push(`${words.textContent.trim()} is cut`);
  }
  if (document.documentElement.scrollWidth > innerWidth) faults.push("the page scrolls sideways");
  return faults;
}
"""


def faults_at(screen: Screen, width: int, height: int) -> list[str]:
    screen.page.set_viewport_size({"width": width, "height": height})
    screen.frames(2)  # the layout changes in the next frame, which the one after shows
    return [f"{width}x{height}: {fault}" for fault in screen.page.evaluate(_FAULTS)]


@pytest.mark.parametrize("touch", [False, *tries([], [True])])
# German has the longest words.
@pytest.mark.parametrize("language", tries(["de"], ["en", "de", "es"]))
def test_every_control_is_visible_uncovered_large_and_whole(
    opened: Open, language: str, touch: bool
) -> None:
    screen = opened("/?room=triangle-8", locale=language, has_touch=touch, is_mobile=touch).ready()
    faults = [fault for width, height in SIZES for fault in faults_at(screen, width, height)]
    # In practice mode, and with the fields of auto-drop.
    screen.page.locator("input[value=auto]").check(force=True)
    faults += [fault for size in SIZES for fault in faults_at(screen, *size)]
    screen.page.set_viewport_size({"width": 1280, "height": 800})
    screen.page.goto(f"{screen.url}/?room=interacting-triangle-8")
    screen.ready()
    expect(screen.root).to_have_attribute("data-practice", "colliding")
    faults += [fault for size in SIZES for fault in faults_at(screen, *size)]
    assert not faults, "\n".join(faults)


# Messages of the bar, with long values in their placeholders.
MESSAGES = re.compile(
    r"auto\.(win|loss|finished|cut|player|refused|credits)$|refused\.|practice\.seed$|play\.(first|full$|refilled"
    r"|damaged|too-few|table-fails|no-line|line-broke|back|foreign|other-path|halted|resumed|unknown|stakes-back"
    r"|adopted|round|rests|pays|found|pile-fails|link-copied)"
)
FAULTS = ["fault.count", "fault.limit", "fault.factor", "play.stake-range"]
VALUES = {
    **{"n": "1,000", "all": "1,000", "profit": "−195.60", "staked": "2,000.00", "paid": "1,804.40"},
    **{"pays": "110x", "board": "triangle-16", "mean": "12.34", "added": "999.50", "least": "0.01"},
    **{"balance": "1,000.00", "most": "1,000,000", "typed": "−12,345,678x", "stake": "1,000.00"},
}

# Of texts by their elements, those that are not whole.
_CUT = """
async (texts) => {
  const { putMessage } = await import("/js/util/dom.js");
  document.getElementById("hand-on").hidden = false;
  const cut = [];
  for (const [id, words] of texts) {
    const line = document.getElementById(id);
    line.hidden = false;
    putMessage(line, words);
    if (line.scrollHeight > line.clientHeight + 1) cut.push(words);
    document.getElementById("fault").hidden = true;
  }
  return cut;
}
"""


def said_in(language: str) -> list[tuple[str, str]]:
    """The longest form of each message in a language, with the element that shows it."""
    texts = json.loads((TEXTS / f"{language}.json").read_text("utf-8"))
    forms = {key: text if isinstance(text, str) else text["other"] for key, text in texts.items()}
    said = [("result", text) for key, text in forms.items() if MESSAGES.match(key)]
    said += [("fault", f"{forms['fault.typed']} {forms[key]}") for key in FAULTS]
    said.append(("fault", forms["fault.loss"]))
    return [(id_, text.format_map(VALUES)) for id_, text in said]


@pytest.mark.parametrize("language", ["en", "de", "es"])
def test_every_message_of_the_bar_is_whole(opened: Open, language: str) -> None:
    screen = opened("/?room=triangle-8", locale=language).ready()
    texts = said_in(language)
    assert len(texts) > 35
    cut = []
    for width, height in SIZES:
        screen.page.set_viewport_size({"width": width, "height": height})
        screen.frames(2)
        cut += [f"{width}x{height}: {text}" for text in screen.page.evaluate(_CUT, texts)]
    assert not cut, "\n".join(cut)


def test_the_board_keeps_its_size_next_to_the_desk(opened: Open) -> None:
    screen = opened("/?room=triangle-16").ready()
    balance = screen.page.locator("#balance")
    expect(balance).to_have_text(re.compile(r"[\d.,]+"))
    for width, height in SIZES:
        screen.page.set_viewport_size({"width": width, "height": height})
        screen.frames(2)
        box = screen.page.locator("#board").bounding_box()
        assert box is not None
        assert box["width"] >= min(0.55 * width, 0.6 * height), (width, height)
        expect(balance).to_be_in_viewport(ratio=1)
