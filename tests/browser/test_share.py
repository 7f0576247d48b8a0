"""A drop is shared by link, as pictures, as a record, and in a frame on another site."""

import re
import threading
import urllib.request
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Complaints, Open
from tests.kit.address import Address

DROP = "board=triangle-8&seed=42"


@pytest.fixture
def other_site(server: Address) -> Iterator[str]:
    """Another site, whose page shows the requested page of the server in a frame."""

    class Blog(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("content-type", "text/html")
            self.end_headers()
            page = f'<iframe src="{server.url}{self.path}" width="520" height="580"></iframe>'
            self.wfile.write(page.encode())

        def log_message(self, *_: object) -> None:
            """Write no log."""

    site = ThreadingHTTPServer(("127.0.0.1", 0), Blog)
    thread = threading.Thread(target=site.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{site.server_port}"
    site.shutdown()
    site.server_close()
    thread.join()


def test_another_site_shows_a_drop_in_a_frame_its_end_only_last(
    opened: Open, other_site: str, complaints: Complaints
) -> None:
    screen = opened(f"{other_site}/replay.html?{DROP}&embed")
    frame = screen.page.frame_locator("iframe")
    result = frame.locator("#result")
    expect(result).to_have_text("Guess where it lands.")
    frame.get_by_role("button", name="Drop").click()
    expect(result).to_have_text(re.compile("Falling…|Bin"))
    record = screen.api("drops/triangle-8/42")
    expect(result).to_have_text(f"Bin {record['bin']} pays {record['score']:g}x.")
    expect(frame.get_by_role("link")).to_have_attribute("href", f"replay.html?{DROP}")

    screen.page.goto(f"{other_site}/replay.html?{DROP}")
    expect(screen.page.frame_locator("iframe").locator("#result")).to_have_count(0)
    complaints.allow("frame-ancestors")


def test_a_frame_of_any_shape_shows_the_whole_board_and_its_key(opened: Open) -> None:
    for width, height in ((1280, 800), (520, 580), (360, 400)):
        screen = opened(f"/replay.html?{DROP}&embed", viewport={"width": width, "height": height})
        screen.state("replay")
        for part in ("#drop", "#board"):
            box = screen.page.locator(part).bounding_box()
            assert box is not None
            assert box["y"] + box["height"] <= height


def test_the_chart_is_there_at_200_percent(opened: Open) -> None:
    screen = opened(f"/replay.html?{DROP}", viewport={"width": 640, "height": 400})
    box = screen.state("replay").page.locator("#energy").bounding_box()
    assert box is not None
    assert box["height"] >= 40
    assert box["y"] + box["height"] <= 400


def test_a_shared_link_keeps_the_end_until_the_ball_has_landed(opened: Open) -> None:
    screen = opened(f"/replay.html?{DROP}&guess", reduced_motion="reduce").state("replay").curious()
    page = screen.page
    tells = page.locator(".tells")
    expect(screen.result).to_have_text("Where will it land?")
    for part in tells.all():
        expect(part).to_be_hidden()
    board = screen.api("boards/triangle-8")["board"]
    ((x, y),) = screen.pixels(board, [[board["bins"]["edges"][0] + 0.1, board["bins"]["y"]]])[
        "points"
    ]
    page.locator("#board-moving").click(position={"x": x, "y": y + 12})
    expect(page.get_by_role("radio", name="Bin 0,")).to_be_checked()
    widths = page.evaluate(
        "[...document.querySelectorAll('#guess-bins label')].map((one) => one.offsetWidth)"
    )
    assert max(widths) - min(widths) <= 1, "the last answer is as wide as the others"
    page.get_by_role("button", name="Let it fall").click()
    landed = screen.api("drops/triangle-8/42")["bin"]
    screen.landed(landed)
    expect(screen.result).to_contain_text(f"lands in bin {landed} and pays")
    expect(screen.result).to_contain_text(f"Your guess was bin 0: {landed} bins off.")
    for part in tells.all():
        expect(part).to_be_visible()


def test_a_drop_is_shared_as_link_frame_poster_film_and_record(opened: Open) -> None:
    screen = opened(f"/replay.html?{DROP}").state("replay").curious()
    page = screen.page
    text = page.get_by_role("textbox", name="What was copied")
    page.get_by_role("button", name="Copy link").click()
    expect(text).to_have_value(f"{screen.url}/replay.html?{DROP}&guess")
    page.get_by_role("button", name="Copy HTML frame").click()
    source = f"{screen.url}/replay.html?{DROP}&embed".replace("&", "&amp;")
    assert f'<iframe src="{source}" title="Seed 42 – Plinko"' in text.input_value()
    kinds = {"Poster": "image/png", "Film": "image/webp", "Record": "application/json"}
    for name, kind in kinds.items():
        link = page.get_by_role("link", name=name, exact=True).get_attribute("href")
        with urllib.request.urlopen(f"{screen.url}/{link}") as reply:
            assert reply.headers["content-type"] == kind
    with page.expect_download() as saved:
        page.get_by_role("button", name="Video").click()
    assert saved.value.suggested_filename == "plinko-42.mp4"
    assert saved.value.path().read_bytes()[4:8] == b"ftyp"
    expect(page.locator("#share-note")).to_contain_text("the video")
