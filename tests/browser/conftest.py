"""A server as its own process, a real Chromium, and pages whose every complaint fails the test."""

import json
import os
import re
import shutil
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Error,
    Page,
    ViewportSize,
    sync_playwright,
)

from engine import Board, find_draw
from tests.browser.screen import Screen
from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT

ROOT = Path(__file__).parents[2]
ARTIFACTS = ROOT / "artifacts"
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--process-per-site",  # pages of one profile share a renderer, see Profile
]

# The smallest that shows a page as on a desk: without a graphics card each pixel costs.
SMALL: ViewportSize = {"width": 1040, "height": 560}

# Of a page that is open for a moment: it does not load all the others, to have them offline.
BRIEF: dict[str, Any] = {"viewport": SMALL, "service_workers": "block"}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)


def browsed(folder: Path) -> ServerProcess:
    """A server whose ledger, in this folder, outlives it."""
    return ServerProcess(f"sqlite:///{folder}/plinko.db", ("--creator-rooms", "500"))


# One of each for all tests of this folder, which stay in one row: while Playwright's loop lives no
# asynchronous test could run, so neither may outlive the last of them.
@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    with browsed(tmp_path_factory.mktemp("server")) as running:
        yield running


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    program = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chrome")
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield running
        running.close()


@dataclass(frozen=True)
class Quick:
    """A fresh table where balls land in a second, for tests that need no certain board."""

    room: str
    token: str
    whole: Board

    @property
    def board(self) -> str:
        return self.whole.digest

    @property
    def page(self) -> str:
        return f"/?room={self.room}"


@pytest.fixture
def quick(server: ServerProcess) -> Quick:
    return quick_table(server, "triangle-8")


def quick_table(
    server: ServerProcess,
    preset: str,
    mode: str = "independent",
    pays: float | None = None,
    prize: str | None = None,
    odds: list[int] | None = None,
) -> Quick:
    """A preset five times as fast; `pays`, `prize`: every bin has that multiplier, that label.

    odds: of a draw over it, with mode `draw`.
    """
    # 25 times the gravity and five times the drag: the same paths, run five times as fast.
    board = Board.preset(preset).to_dict()
    board.update(name="quick", gravity=25 * board["gravity"], drag=5 * board["drag"])
    if pays is not None:
        board["bins"]["multipliers"] = [pays] * len(board["bins"]["multipliers"])
    if prize is not None:
        board["bins"]["labels"] = [{"text": prize, "colour": "#c0392b"}] * 9
    draw = None if odds is None else find_draw(Board.from_json(board), odds, per_bin=4)
    request = urllib.request.Request(
        f"{server.url}/api/v1/rooms",
        json.dumps({"board": board, "mode": mode, "draw": draw}).encode(),
        {"content-type": "application/json"},
    )
    with urllib.request.urlopen(request) as reply:
        room = json.load(reply)
    return Quick(room["id"], room["token"], Board.from_json(board))


def holding(room: str, token: str) -> str:
    """What a page is to run before its own, so that it may do in the room what its owner may."""
    tokens = json.dumps(json.dumps({room: token}))
    return f"sessionStorage.setItem('plinko.tokens.1', {tokens})"


@dataclass
class Complaints:
    """What pages wrote to the console as errors, or threw."""

    seen: list[str] = field(default_factory=list)
    allowed: list[str] = field(default_factory=list)  # patterns

    def watch(self, page: Page) -> None:
        page.on("console", self._console)
        page.on("pageerror", self._thrown)

    def leave(self, page: Page) -> None:
        """Note no more of what it says, which another test may."""
        page.remove_listener("console", self._console)
        page.remove_listener("pageerror", self._thrown)

    def allow(self, pattern: str) -> None:
        """Forget what a test provokes on purpose, told already or still on its way."""
        self.allowed.append(pattern)

    @property
    def left(self) -> list[str]:
        """What nobody has allowed."""
        return [text for text in self.seen if not any(re.search(one, text) for one in self.allowed)]

    def _thrown(self, error: Error) -> None:
        self.seen.append(f"page error: {error}")

    def _console(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.seen.append(f"console error: {message.text} ({message.location['url']})")


@pytest.fixture
def complaints() -> Iterator[Complaints]:
    collected = Complaints()
    yield collected
    assert not collected.left


# To be run before the page: a display of 20 Hz, for pages whose motion nobody judges. Without a
# graphics card a second of the usual 60 Hz costs most of a second of the processor.
SLOW_DISPLAY = """
{
  const next = window.requestAnimationFrame.bind(window);
  const waiting = new Map();
  let count = 0;
  const after = (frames, handle, draw) => next((now) => {
    if (!waiting.has(handle)) return;
    if (frames > 1) return after(frames - 1, handle, draw);
    waiting.delete(handle);
    draw(now);
  });
  window.requestAnimationFrame = (draw) => {
    waiting.set(++count, true);
    after(3, count, draw);
    return count;
  };
  window.cancelAnimationFrame = (handle) => waiting.delete(handle);
}
"""

# To be run before the page: nothing falls over a table but what a test drops, however long that
# waits.
NO_DEMO = """
if (location.protocol.startsWith("http")) localStorage.setItem("plinko.demo.1", "off");
"""

Open = Callable[..., Screen]
Run = Callable[..., Any]


@pytest.fixture(scope="package")
def run(browser: Browser, server: ServerProcess) -> Iterator[Run]:
    """Calls a JavaScript function with a module of js/ and an argument, away from the page."""
    page = browser.new_page()
    complaints = Complaints()
    complaints.watch(page)
    page.goto(f"{server.url}/theme.json")

    def call(module: str, function: str, argument: Any = None) -> Any:
        script = f"async (given) => ({function})(await import('/js/{module}'), given)"
        return page.evaluate(script, argument)

    yield call
    page.close()
    complaints.allow("404")  # a bare file has no icon; a missing module fails by itself
    assert not complaints.left


# What one page may have that others of its context have not; for the rest it takes a context.
OF_A_PAGE = ("viewport", "color_scheme", "reduced_motion")
USUAL = {"device_scale_factor": 1, "is_mobile": False, "has_touch": False}


@dataclass
class Profile:
    """A browser profile that tests use one after the other, each finding it empty.

    A page that stays open keeps the renderer's process alive: to start one anew costs more than
    most pages do. What a test does to a page ends with the page.
    """

    context: BrowserContext
    keeper: Page | None = None

    def new_page(self, url: str) -> Page:
        """A page for the server at `url`."""
        if self.keeper is None:  # of any server: a port is no other site
            self.keeper = self.context.new_page()
            self.keeper.goto(f"{url}/theme.json")
        return self.context.new_page()

    def clear(self, url: str) -> None:
        """Forget cookies and all that pages of `url` stored, but not the files they are made of."""
        assert self.keeper is not None
        self.context.clear_cookies()
        session = self.context.new_cdp_session(self.keeper)
        session.send("Storage.clearDataForOrigin", {"origin": url, "storageTypes": "all"})
        session.detach()


@dataclass
class Profiles:
    """A profile for each kind of device."""

    browser: Browser
    kept: dict[str, Profile] = field(default_factory=dict)

    def of(self, device: dict[str, Any]) -> Profile:
        """The one that all tests share, for options of a context."""
        kind = json.dumps(device, sort_keys=True)
        if kind not in self.kept:
            self.kept[kind] = Profile(self.new_context(device))
        return self.kept[kind]

    def new_context(self, device: dict[str, Any]) -> BrowserContext:
        """One of a test's own."""
        context = self.browser.new_context(**(BRIEF | device))
        context.set_default_timeout(1000 * LIMIT)
        context.add_init_script(SLOW_DISPLAY)
        context.add_init_script(NO_DEMO)
        return context


@pytest.fixture(scope="package")
def profiles(browser: Browser) -> Iterator[Profiles]:
    shared = Profiles(browser)
    yield shared
    for profile in shared.kept.values():
        profile.context.close()


@pytest.fixture
def opened(profiles: Profiles, server: ServerProcess, complaints: Complaints) -> Iterator[Open]:
    """Opens the page at a path, or another address, in an empty profile.

    With options of `Browser.new_context`.

    A test's first page of a kind of device is in the profile that all tests share; others have
    their own, as has one with service workers.
    """
    contexts: list[BrowserContext] = []
    shared: list[tuple[Profile, Page]] = []

    def new_page(device: dict[str, Any]) -> Page:
        if "service_workers" not in device:
            profile = profiles.of(device)
            if all(profile is not other for other, _ in shared):
                shared.append((profile, profile.new_page(server.url)))
                return shared[-1][1]
        contexts.append(profiles.new_context(device))
        return contexts[-1].new_page()

    def open_page(path: str = "/", *, before: str | None = None, **options: Any) -> Screen:
        of_page = {name: options.pop(name) for name in OF_A_PAGE if name in options}
        page = new_page(
            {name: value for name, value in options.items() if value != USUAL.get(name)}
        )
        if "viewport" in of_page:
            page.set_viewport_size(of_page.pop("viewport"))
        if of_page:
            page.emulate_media(**of_page)
        complaints.watch(page)
        if before is not None:
            page.add_init_script(before)
        screen = Screen(page, server.url, ARTIFACTS)
        page.goto(urljoin(server.url, path))
        return screen

    yield open_page
    for context in contexts:
        context.close()
    for profile, page in shared:
        page.close()
        profile.clear(server.url)
