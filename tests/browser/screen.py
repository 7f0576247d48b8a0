"""An open page as its user sees it: find, wait for, click and measure what it shows."""

import json
import re
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import parse_qsl, urlsplit

from playwright.sync_api import Locator, Page, WebSocket, expect

from tests.kit.waiting import LIMIT, until
from tests.long import LONG

T = TypeVar("T")

expect.set_options(timeout=1000 * LIMIT)

# Run before the page: `late` is the newest picture's delay in ms, relative to the fastest one.
HEAR = """
window.received = { at: 0, late: 0, knows: false };
const samples = [];
window.WebSocket = class extends WebSocket {
  constructor(...all) {
    super(...all);
    received.knows = /stream=seeds/.test(String(all[0]));
    this.addEventListener("message", ({ data }) => {
      // The ticks of a room that slept have a new offset.
      if (typeof data === "string" && data.includes('"accepted"')) samples.length = 0;
      if (typeof data === "string" || received.knows) return;
      received.at = performance.now();
      samples.push(received.at - (1000 / 60) * new DataView(data).getUint32(4, true));
      if (samples.length > 120) samples.shift();
      received.late = samples.at(-1) - Math.min(...samples);
    });
  }
};
"""

# Run before the page: counts the frames it requests.
COUNT_FRAMES = """
{
  const ask = window.requestAnimationFrame;
  window.frames_asked = 0;
  window.requestAnimationFrame = (draw) => { window.frames_asked += 1; return ask(draw); };
}
"""

# Run before the page: keeps all states of the connection, of which some last only a moment.
STATES = """
window.states = [];
new MutationObserver(() => states.push(document.documentElement.dataset.state))
  .observe(document, { subtree: true, attributeFilter: ["data-state"] });
"""

# Wait for `count` frames, in which the page draws if it wants to.
_FRAMES = """
async (count) => {
  for (let i = 0; i < count; i += 1) {
    window.show?.();
    await new Promise(window.turn ?? requestAnimationFrame);
  }
}
"""

# Wait until the page has not requested any of `count` consecutive frames, which it draws at once.
_REST = """
async (count) => {
  let [asked, still] = [frames_asked, 0];
  for (let tries = 0; still < count; tries += 1) {
    if (tries > 3600) throw new Error("the page still draws after 3600 frames");
    show();
    await new Promise(turn);
    still = asked === frames_asked ? still + 1 : 0;
    asked = frames_asked;
  }
}
"""

# The picture is at least three ticks (50 ms) behind the fastest snapshots. If the newest snapshot
# is older, a busy machine has delayed it, and the page extrapolates the ball's flight.
_KNOWN_MS = 50

# The place of the player's ball on the moving canvas in each frame until a ball lands: the mean of
# the pixels with the ball's red, in CSS pixels. Trails are too faint to count. Extrapolated frames
# are left out, for which the page needs HEAR.
_TRACK = """
async (known) => {
  const canvas = document.querySelector("#board-moving");
  const ctx = canvas.getContext("2d");
  const density = canvas.width / canvas.clientWidth;
  const places = [];
  const deadline = performance.now() + 60_000;
  const rows = document.querySelectorAll("#drops > li");
  while (document.querySelectorAll("#drops > li").length === rows.length) {
    await new Promise(requestAnimationFrame);
    if (performance.now() > deadline) throw new Error("nothing landed within a minute");
    // A page that knows the path needs no news.
    if (!received.knows && performance.now() - received.at + received.late > known) continue;
    const { data } = ctx.getImageData(0, 0, canvas.width, canvas.height);
    let count = 0, x = 0, y = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] < 250 || data[i] < 150 || data[i] < 2.2 * data[i + 2]) continue;
      if (data[i] < 2 * data[i + 1]) continue;
      const pixel = i / 4;
      x += pixel % canvas.width;
      y += Math.floor(pixel / canvas.width);
      count += 1;
    }
    if (count > 8) places.push([x / count / density, y / count / density]);
  }
  return places;
}
"""

# The middle of the player's ball on the moving canvas, after the next frame.
_RED_MIDDLE = """
async () => {
  const canvas = document.querySelector("#board-moving");
  const density = canvas.width / canvas.clientWidth;
  const drawn = () => {
    window.show?.();
    return new Promise(window.turn ?? requestAnimationFrame);
  };
  await drawn();
  for (let tries = 0; tries < 300; tries += 1) {
    await drawn();
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0, x = 0, y = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] < 250 || data[i] < 150 || data[i] < 2.2 * data[i + 2]) continue;
      if (data[i] < 2 * data[i + 1]) continue;
      x += (i / 4) % canvas.width;
      y += Math.floor(i / 4 / canvas.width);
      count += 1;
    }
    if (count) return [x / count / density, y / count / density];
  }
  throw new Error("no ball is drawn");
}
"""

# Metres to CSS pixels of the canvas, by the page's layout.
_TO_PIXELS = """
async ([board, points]) => {
  const { layOut } = await import("/js/paint/geometry.js");
  const { px, py, scale } = layOut(board, document.querySelector("#board").clientWidth);
  return { points: points.map(([x, y]) => [px(x), py(y)]), scale };
}
"""


class Screen:
    """One open page."""

    def __init__(self, page: Page, url: str, artifacts: Path) -> None:
        self.page = page
        self.url = url
        self.root = page.locator("html")
        self.result = page.locator("#result")
        self.drop = page.locator("#drop")
        self.rows = page.locator("#drops > li")
        self._sent: list[str | bytes] = []
        self._artifacts = artifacts
        page.on("websocket", self._listen)

    @property
    def seed(self) -> Locator:
        """The field for a seed, behind the door for the curious, which is opened."""
        if self.page.locator("#curious").count():
            self.curious()
        if self.page.locator("#lab").count():
            self.drawer("For the curious")
        return self.page.get_by_label("Seed", exact=True)

    def curious(self) -> "Screen":
        """Open a replay's door for the curious if it is closed."""
        door = self.page.locator("#curious:not([open]) > summary")
        if door.count():
            door.click()
        return self

    def drawer(self, name: str) -> Locator:
        """Open the drawer Table, Fairness or For the curious if it is closed; returns it."""
        tab = self.page.get_by_role("button", name=name, exact=True)
        if not tab.is_visible():
            self.page.get_by_role("button", name="More", exact=True).click()
        if tab.get_attribute("aria-expanded") != "true":
            tab.click()
        return self.page.locator(f"#{tab.get_attribute('aria-controls')}")

    def ready(self) -> "Screen":
        """Wait until the table is connected and nothing moves."""
        return self.state("asleep")

    def state(self, *names: str) -> "Screen":
        """Wait for one of these connection states."""
        expect(self.root).to_have_attribute("data-state", re.compile(f"^({'|'.join(names)})$"))
        return self

    def passed(self, *names: str) -> "Screen":
        """Wait until these states have followed each other; the page must be opened with STATES."""
        self.page.wait_for_function("names => states.join().includes(names)", arg=",".join(names))
        return self

    def paused(self) -> "Screen":
        """Wait for a replay, and stop it at its start."""
        self.state("replay")
        self.page.locator("#time").fill("0")
        return self

    def landed(self, bin_: int) -> None:
        """Wait until the page reports a landing in this bin."""
        expect(self.root).to_have_attribute("data-last-bin", str(bin_))

    def frames(self, count: int) -> None:
        """Wait for `count` frames, in which the page draws if it wants to."""
        self.page.evaluate(_FRAMES, count)

    def frames_asked(self) -> int:
        """How many frames the page has requested; it must be opened with COUNT_FRAMES."""
        asked: int = self.page.evaluate("frames_asked")
        return asked

    def at_rest(self, frames: int = 30) -> "Screen":
        """Wait until the page has requested none of `frames` consecutive frames.

        It must be opened with COUNT_FRAMES.
        """
        self.page.evaluate(_REST, frames)
        return self

    def until(self, condition: Callable[[], object]) -> None:
        """Poll a condition once a frame of the display until it holds."""
        until(condition, lambda: self.page.evaluate("new Promise(window.turn)"))

    def steady(self, look: Callable[[], T], frames: int = 18) -> T:
        """Call `look` every `frames` frames until two results are equal; returns the last."""
        seen = look()

        def same() -> bool:
            nonlocal seen
            before = seen
            self.frames(frames)
            seen = look()
            return seen == before

        until(same, lambda: None)
        return seen

    def _listen(self, socket: WebSocket) -> None:
        socket.on("framesent", self._keep)

    def _keep(self, frame: str | bytes) -> None:
        self._sent.append(frame)

    @property
    def sent(self) -> list[str | bytes]:
        """The messages that the page has sent over its WebSockets."""
        # A key's or a click's end may overtake the message that it sent; an evaluation cannot.
        self.page.evaluate("null")
        return list(self._sent)

    @property
    def drops_sent(self) -> list[dict[str, Any]]:
        """The drop messages that the page sent, without its other messages."""
        messages = [json.loads(frame) for frame in self.sent]
        return [message for message in messages if message["type"] == "drop"]

    def staked(self, balls: int) -> None:
        """Drop this many balls, and wait until the table has accepted their stakes."""
        self.page.get_by_role("radio", name=f"{balls} balls").check(force=True)
        self.drop.click()
        self.page.wait_for_function(
            "(balls) => JSON.parse(localStorage['plinko.account.1'] ?? 'null') !== null"
            " && Object.values(JSON.parse(localStorage['plinko.account.1']).sessions)"
            ".flatMap(({ drops }) => Object.values(drops)).length === balls",
            arg=balls,
        )

    def last_dropped(self) -> Any:
        """The drop in the top row of the list, requested from REST by board and seed."""
        link = self.rows.first.locator("a").get_attribute("href") or ""
        asked = dict(parse_qsl(urlsplit(link).query))
        return self.api(f"drops/{asked['board']}/{asked['seed']}")

    def fact(self, name: str) -> Locator:
        return self.page.locator(f"[data-fact={name}]")

    def api(self, path: str) -> Any:
        """A REST reply, requested without the page."""
        with urllib.request.urlopen(f"{self.url}/api/v1/{path}") as reply:
            return json.load(reply)

    def track(self) -> list[list[float]]:
        """The ball's place in each frame until the next landing, CSS pixels.

        Extrapolated frames are left out. The page must be opened with HEAR.
        """
        places: list[list[float]] = self.page.evaluate(_TRACK, _KNOWN_MS)
        return places

    def ball(self) -> list[float]:
        """The ball's place when it is first drawn, CSS pixels."""
        place: list[float] = self.page.evaluate(_RED_MIDDLE)
        return place

    def pixels(self, board: Any, points: list[list[float]]) -> Any:
        """Metres as CSS pixels of the canvas: `points`, and the `scale` in pixels per metre."""
        self.frames(2)  # the layout changes in the next frame
        return self.page.evaluate(_TO_PIXELS, [board, points])

    def shot(self, name: str, *, full_page: bool = False) -> None:
        """With LONG=1, save a screenshot for people; no test reads it."""
        if not LONG:
            return
        self._artifacts.mkdir(exist_ok=True)
        self.page.screenshot(path=self._artifacts / f"{name}.png", full_page=full_page)
