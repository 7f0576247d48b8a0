"""A server process and a real Chromium; an error in a page's console fails the test."""

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

from plinko.engine import Board, find_draw
from tests.browser.screen import Screen
from tests.kit import stakes
from tests.kit.address import Address
from tests.kit.process import OPERATOR, SERVE, ServerProcess
from tests.kit.serving import constants, serving
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
    "--process-per-site",  # pages of one profile share a renderer: see Profile
]

# The smallest desk layout: without a graphics card every pixel takes time.
SMALL: ViewportSize = {"width": 1040, "height": 560}

# Options of a short-lived page: it must not fetch all other pages to keep them offline.
BRIEF: dict[str, Any] = {"viewport": SMALL, "service_workers": "block"}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)


# All tests of this folder share one server and one browser, and run in sequence. Both fixtures end
# with the folder's last test: no asynchronous test can run while Playwright's event loop exists.
@pytest.fixture(scope="package")
def server() -> Iterator[Address]:
    patched = constants(**{"plinko.app.rooms.independent.takes_stakes": stakes.taken})
    usual = {"drop_rate": 1000, "max_rooms": 10_000, "operator_token": OPERATOR}
    with patched, serving(**usual) as running:
        yield running


@pytest.fixture(scope="package")
def mortal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server for tests to kill, with its ledger in a file, which survives restarts."""
    program = (
        "-c",
        "from tests.kit import stakes; stakes.begin(); import plinko.__main__",
        *SERVE,
    )
    folder = tmp_path_factory.mktemp("server")
    with ServerProcess(f"sqlite:///{folder}/plinko.db", program=program) as running:
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
    """A new table where balls land within a second, for tests that need no certain board."""

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
def quick(server: Address) -> Quick:
    return quick_table(server, "triangle-8")


def quick_table(
    server: Address,
    preset: str,
    mode: str = "independent",
    pays: float | None = None,
    prize: str | None = None,
    odds: list[int] | None = None,
) -> Quick:
    """Create a table with a preset's board that runs five times as fast.

    pays, prize: the multiplier and the label of every bin; odds: those of a draw (mode `draw`).
    """
    # 25 times the gravity and 5 times the drag: balls follow the same paths 5 times as fast.
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
    """A script for a page to run first, which gives it the owner's token of the room."""
    tokens = json.dumps(json.dumps({room: token}))
    setting = f"sessionStorage.setItem('plinko.tokens.1', {tokens})"
    return f"if (location.protocol.startsWith('http')) {setting}"


@dataclass
class Complaints:
    """The errors that pages wrote to the console or threw."""

    seen: list[str] = field(default_factory=list)
    allowed: list[str] = field(default_factory=list)  # patterns

    def watch(self, page: Page) -> None:
        page.on("console", self._console)
        page.on("pageerror", self._thrown)

    def leave(self, page: Page) -> None:
        """Ignore further errors of a page, which belong to another test."""
        page.remove_listener("console", self._console)
        page.remove_listener("pageerror", self._thrown)

    def allow(self, pattern: str) -> None:
        """Ignore past and future errors that a test provokes on purpose."""
        self.allowed.append(pattern)

    @property
    def left(self) -> list[str]:
        """The errors that the test has not allowed."""
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


# Run before the page: a display of 10 Hz, for pages whose motion is not tested. Without a graphics
# card the usual 60 Hz need nearly all of a processor. `show` draws what waits in the next frame;
# `turn` waits for a frame of the real display.
SLOW_DISPLAY = """
{
  const next = window.requestAnimationFrame.bind(window);
  const waiting = new Map();
  let count = 0;
  const pass = (handle) => next((now) => {
    const draw = waiting.get(handle);
    if (waiting.delete(handle)) draw(now);
  });
  window.requestAnimationFrame = (draw) => {
    const handle = (count += 1);
    waiting.set(handle, draw);
    setTimeout(() => { if (waiting.has(handle)) pass(handle); }, 84);
    return handle;
  };
  window.cancelAnimationFrame = (handle) => waiting.delete(handle);
  window.turn = next;
  window.show = () => { for (const handle of waiting.keys()) pass(handle); };
}
"""

# Run before the page: the display's own rate again, for pages whose motion is tested.
REAL_DISPLAY = "window.requestAnimationFrame = window.turn;"

# Run before the page: no demo balls fall while a test waits.
NO_DEMO = """
if (location.protocol.startsWith("http")) localStorage.setItem("plinko.demo.1", "off");
"""

Open = Callable[..., Screen]
Run = Callable[..., Any]


@pytest.fixture(scope="package")
def run(browser: Browser, server: Address) -> Iterator[Run]:
    """Calls a JavaScript function with a module of js/ and an argument, on an empty page."""
    page = browser.new_page()
    complaints = Complaints()
    complaints.watch(page)
    page.goto(f"{server.url}/theme.json")

    def call(module: str, function: str, argument: Any = None) -> Any:
        script = f"async (given) => ({function})(await import('/js/{module}'), given)"
        return page.evaluate(script, argument)

    yield call
    page.close()
    complaints.allow("404")  # the page has no icon; a missing module fails by itself
    assert not complaints.left


# Options that can differ between pages of one context; other options need a new context.
OF_A_PAGE = ("viewport", "color_scheme", "reduced_motion")
USUAL = {"device_scale_factor": 1, "is_mobile": False, "has_touch": False}


@dataclass
class Profile:
    """A browser profile that tests use in sequence; each finds it empty.

    The page `keeper` stays open to keep the renderer process alive: a new process costs more than
    most pages. Each test gets a new page.
    """

    context: BrowserContext
    keeper: Page | None = None

    def new_page(self, url: str) -> Page:
        """A page for the server at `url`."""
        if self.keeper is None:  # one for all servers: browsers ignore the port of a site
            self.keeper = self.context.new_page()
            self.keeper.goto(f"{url}/theme.json")
        return self.context.new_page()

    def clear(self, url: str) -> None:
        """Remove cookies and everything that pages of `url` stored; cached files stay."""
        assert self.keeper is not None
        self.context.clear_cookies()
        session = self.context.new_cdp_session(self.keeper)
        session.send("Storage.clearDataForOrigin", {"origin": url, "storageTypes": "all"})
        session.detach()


@dataclass
class Profiles:
    """One shared profile for each kind of device."""

    browser: Browser
    kept: dict[str, Profile] = field(default_factory=dict)

    def of(self, device: dict[str, Any]) -> Profile:
        """The profile shared by all tests with these options of a context."""
        kind = json.dumps(device, sort_keys=True)
        if kind not in self.kept:
            self.kept[kind] = Profile(self.new_context(device))
        return self.kept[kind]

    def new_context(self, device: dict[str, Any]) -> BrowserContext:
        """A new context, for one test only."""
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
def opened(profiles: Profiles, server: Address, complaints: Complaints) -> Iterator[Open]:
    """Opens a path or an address in an empty profile, with options of `Browser.new_context`.

    A test's first page of each kind of device uses the shared profile. Its further pages, and
    those with service workers, get a new context.
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
        addresses = {server.url, urljoin(page.url, "/").rstrip("/")}
        page.goto("about:blank")  # ends the document, which could still store something in `close`
        page.close()
        for url in addresses:
            profile.clear(url)
