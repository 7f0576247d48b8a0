"""The game as static files, below a path of a plain web server: everything works without Plinko's.

Each page fails its test if it writes an error to the console or a request fails.
"""

import json
import re
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, parse_qsl, urlsplit

import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from plinko.app.settings import static_directory
from plinko.app.web.site import write_site
from plinko.engine import Board, drop, verify
from tests.browser.conftest import ARTIFACTS, Complaints, Profiles
from tests.browser.screen import Screen
from tools.golden import session

FOLDER = "games/plinko"
GRANT = 1000.0


class _Files(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        """Write no log."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """URL of the site's folder on a server that knows nothing of Plinko."""
    root = tmp_path_factory.mktemp("host")
    write_site(static_directory(), root / FOLDER)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Files, directory=str(root)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/{FOLDER}/"
    server.shutdown()
    server.server_close()
    thread.join()


Visit = Callable[..., Screen]


@pytest.fixture
def visit(site: str, profiles: Profiles, complaints: Complaints) -> Iterator[Visit]:
    """Opens a page of the site in a new profile with these options of a context."""
    contexts: list[BrowserContext] = []

    def failed(request: Request) -> None:
        if request.failure != "net::ERR_ABORTED":  # by a page that was left
            complaints.seen.append(f"failed: {request.url}")

    def watch(page: Page) -> None:
        complaints.watch(page)
        page.on("requestfailed", failed)

    def open_page(path: str = "", **options: Any) -> Screen:
        contexts.append(profiles.new_context(options))
        page = contexts[-1].new_page()
        watch(page)
        page.goto(site + path)
        return Screen(page, site, ARTIFACTS)

    yield open_page
    for context in contexts:
        context.close()


def balance(screen: Screen) -> float:
    return float(screen.page.locator("#balance").inner_text().replace(",", ""))


def dropped(screen: Screen) -> Any:
    """The newest drop of the list, as the engine computes it from the link to its replay."""
    link = screen.rows.first.locator("a").get_attribute("href") or ""
    asked = dict(parse_qsl(urlsplit(link).query))
    return drop(Board.preset(asked["board"]), int(asked["seed"]))


def test_a_drop_falls_and_pays_what_the_engine_computes_and_a_reload_keeps_it(visit: Visit) -> None:
    screen = visit().ready()
    page = screen.page
    expect(page.locator("#state-text")).to_have_text("On this device")
    expect(screen.result).to_have_text("Ready when you are. Everything stays on this device.")
    page.get_by_role("radio", name="Turbo").check(force=True)
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    paid = dropped(screen).score
    assert balance(screen) == pytest.approx(GRANT - 1 + paid)

    screen.drop.click()
    expect(page.locator("#balance")).not_to_have_text(f"{GRANT - 1 + paid:,.2f}")
    page.reload()  # while the ball falls
    expect(screen.rows).to_have_count(2)
    assert balance(screen) == pytest.approx(GRANT - 2 + paid + dropped(screen).score)
    visits = page.evaluate("Object.values(JSON.parse(localStorage['plinko.account.1']).sessions)")
    assert [ended["total"] for ended in visits] == [2]


def test_a_replay_opens_from_the_list_and_is_the_drop_that_fell(visit: Visit) -> None:
    screen = visit("?room=moon-9-high").ready()
    page = screen.page
    page.get_by_role("radio", name="Instant").check(force=True)
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    fell = dropped(screen)
    screen.rows.first.get_by_role("button", name=re.compile("Verify")).click()
    expect(screen.rows.first).to_contain_text("every bit the same")
    screen.rows.first.get_by_role("link").last.click()
    screen.state("replay").landed(fell.bin)
    screen.curious()
    expect(screen.fact("digest")).to_have_text(fell.digest)
    page.get_by_role("button", name="Verify").click()
    expect(page.locator("#verdict")).to_contain_text("Reproduced in this page, every bit")
    with page.expect_download() as saved:
        page.get_by_role("link", name="Record", exact=True).click()
    assert verify(json.loads(Path(saved.value.path()).read_text())).ok
    page.goto(f"{screen.url}")  # leads back to the table that was visited last
    screen.ready()
    assert "room=moon-9-high" in page.url


@pytest.mark.parametrize(
    ("view", "said"), [("compare", "They separate"), ("embed", "Guess where it lands.")]
)
def test_a_link_compares_or_embeds_a_drop(visit: Visit, view: str, said: str) -> None:
    screen = visit(f"replay.html?board=triangle-16&seed=42&{view}").state("replay")
    expect(screen.root).to_have_attribute("data-view", view)
    expect(screen.result).to_contain_text(said)


def test_a_board_of_the_editor_is_tested_played_and_shared(visit: Visit) -> None:
    screen = visit("editor.html?board=triangle-8").ready()
    page = screen.page
    page.locator("#test").click()
    expect(page.locator("#tray-count")).to_have_text("100 test balls")
    page.get_by_label("Name").fill("my own")
    page.get_by_label("Name").blur()
    expect(page.locator("#check-text")).to_contain_text("Every value is allowed")
    page.get_by_role("button", name="Play it").click()
    screen.ready()
    page.get_by_role("radio", name="Instant").check(force=True)
    expect(page.locator("#practice-note")).to_have_text("Practice: no stakes on this board")
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    assert balance(screen) == GRANT
    screen.rows.first.get_by_role("link").last.click()
    screen.state("replay")
    shown = screen.result.inner_text()
    page.locator("#share-link").click()
    link = page.locator("#share-text").input_value()
    other = visit(link.removeprefix(screen.url).replace("&guess", "")).state("replay")
    expect(other.result).to_have_text(shown)


def test_balls_collide_in_the_sandbox(visit: Visit) -> None:
    screen = visit("sandbox.html?room=sandbox").state("live")
    expect(screen.result).to_have_text("Sandbox: 60 balls.")
    screen.page.get_by_role("button", name="Throw a ball").click()
    expect(screen.result).to_contain_text("Thrown")


def test_a_session_of_a_server_is_checked_and_the_ball_of_the_day_falls(visit: Visit) -> None:
    screen = visit("verify.html")
    screen.page.locator("#file").set_input_files(session.FILE)
    # The session's solver is not the page's. The verdict names it, so the page ran its checks.
    expect(screen.page.locator("#verdict")).to_contain_text("kernel")
    screen.page.goto(f"{screen.url}today.html")
    screen.state("replay").page.locator(".pick").first.click()
    expect(screen.root).to_have_attribute("data-last-bin", re.compile(r"\d+"))


def test_a_lesson_by_its_link_has_its_balls_and_needs_no_phones(visit: Visit) -> None:
    path = "class.html#rows=8&p=0.5&restitution=0.8&gravity=9.81&view=bins&size=10&runs=5x300"
    screen = visit(path, reduced_motion="reduce").state("live")
    expect(screen.result).to_have_text("300 balls have landed.")
    screen.page.get_by_text("Link, table, phones").click()
    expect(screen.page.get_by_role("button", name="Copy link")).to_be_visible()
    expect(screen.page.get_by_role("button", name="Invite phones")).to_be_hidden()
    screen.page.goto(f"{screen.url}de/{path}")
    expect(screen.result).to_have_text("300 Kugeln sind gelandet.")


def test_pages_speak_the_language_of_the_browser_or_the_chosen_one(visit: Visit) -> None:
    screen = visit("?room=mars-8", locale="de-AT").ready()
    page = screen.page
    assert urlsplit(page.url).path.endswith(f"/{FOLDER}/de/")
    assert parse_qs(urlsplit(page.url).query) == {"room": ["mars-8"]}
    expect(page.locator("#state-text")).to_have_text("Auf diesem Gerät")
    screen.drawer("Optionen").get_by_label("Sprache").select_option("en")
    expect(screen.root).to_have_attribute("lang", "en")
    assert urlsplit(page.url).path.endswith(f"/{FOLDER}/")


def test_after_a_visit_the_game_plays_with_the_network_cut(visit: Visit) -> None:
    screen = visit("es/", locale="es", service_workers="allow").ready()
    page = screen.page
    page.evaluate("navigator.serviceWorker.ready.then(() => null)")
    page.context.set_offline(True)
    page.reload()
    screen.ready()
    page.get_by_role("radio", name="Al instante").check(force=True)
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    assert balance(screen) != GRANT or dropped(screen).score == 1
    page.goto(f"{screen.url}es/replay.html?board=triangle-16&seed=42")
    screen.state("replay")


def test_what_needs_a_server_is_not_offered(visit: Visit) -> None:
    screen = visit().ready()
    page = screen.page
    for name in ("Fairness", "Invite", "Provably fair", "Balls collide (practice)", "Save video"):
        expect(page.get_by_text(name, exact=True)).to_be_hidden()
    page.keyboard.press("f")
    expect(page.locator("#fair")).to_be_hidden()
    page.goto(f"{screen.url}editor.html")
    expect(page.locator("#test")).to_be_visible()
    expect(page.locator("#solve, #solve-risk, #register").filter(visible=True)).to_have_count(0)
    page.goto(f"{screen.url}replay.html?board={'0' * 64}&seed=1")
    expect(screen.result).to_contain_text("This board is not on this device.")
    page.goto(f"{screen.url}?room={'0' * 64}")
    screen.state("closed")
