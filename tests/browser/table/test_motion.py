"""Hidden tabs do not confuse the page."""

import re

from playwright.sync_api import expect

from tests.browser.conftest import Open, Quick

_HIDEABLE = """
let seen = "visible";
Object.defineProperty(document, "visibilityState", { get: () => seen });
Object.defineProperty(document, "hidden", { get: () => seen === "hidden" });
const ask = window.requestAnimationFrame.bind(window);
const waiting = [];
window.requestAnimationFrame = (draw) => {
  if (seen === "visible") return ask(draw);
  waiting.push(draw);
  return 1e9 + waiting.length;
};
window.look = (how) => {
  seen = how;
  document.dispatchEvent(new Event("visibilitychange"));
  if (how === "visible") for (const draw of waiting.splice(0)) ask(draw);
};
"""

_PAINTED = """() => {
  const canvas = document.querySelector("#board-moving");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 3; i < data.length; i += 4) count += data[i] > 0;
  return count;
}"""


def test_a_hidden_tab_catches_up_without_a_burst(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=_HIDEABLE).ready()
    for _ in range(12):
        screen.drop.click()
    screen.state("live")
    screen.page.evaluate("look('hidden')")
    expect(screen.rows).to_have_count(12)  # all have landed and are counted while hidden
    expect(screen.page.locator("#staked")).to_have_text("12.00")
    screen.frames(90)
    screen.page.evaluate("look('visible')")
    # The first pictures afterwards: no ball, light or ticket of past landings.
    painted = screen.page.evaluate(
        f"""async () => {{
          const painted = [];
          for (let i = 0; i < 5; i += 1) {{
            await new Promise(requestAnimationFrame);
            painted.push(({_PAINTED})());
          }}
          return painted;
        }}"""
    )
    assert painted == [0] * 5
    # By chance a bin may fill so high that a disc stands for two balls: the text then adds that.
    expect(screen.page.locator("#tray-count")).to_have_text(re.compile("^12 balls"))

    # The script watches before the drop: on a busy machine the ball may land before the next call.
    screen.page.evaluate(
        f"""() => {{
          const look = (done) => (({_PAINTED})() ? done(true)
            : requestAnimationFrame(() => look(done)));
          new Promise(look).then(() => {{ window.painted_again = true; }});
        }}"""
    )
    screen.drop.click()
    screen.page.wait_for_function("() => window.painted_again")
    expect(screen.rows).to_have_count(13)
