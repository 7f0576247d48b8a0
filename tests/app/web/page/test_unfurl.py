"""Other sites can preview links to drops, and show one of the pages in a frame."""

import html
import re
from urllib.parse import urlsplit

import httpx

from plinko.app.web.routes.page import card
from tests.kit.serving import serving

BASE = "https://plinko.example/"


def properties(text: str) -> dict[str, str]:
    """The properties of the `<meta>` elements."""
    found = re.findall('<meta property="([^"]+)" content="([^"]*)">', text)
    return {name: html.unescape(content) for name, content in found}


def test_a_link_to_a_drop_has_its_title_its_text_and_its_picture(http: httpx.Client) -> None:
    asked = "board=triangle-8&seed=18446744073709551615&x=0.25"
    about = properties(http.get(f"/replay.html?{asked}").text)
    assert about["og:title"] == "Seed 18446744073709551615 on triangle-8"
    assert "bin" not in about["og:title"] + about["og:image:alt"], "where it lands stays untold"
    assert about["og:url"] == str(http.base_url.join(f"/replay.html?{asked}"))
    assert urlsplit(about["og:image"]).netloc == http.base_url.netloc.decode()
    picture = http.get(about["og:image"])
    assert picture.status_code == 200, picture.text
    assert picture.headers["content-type"] == about["og:image:type"]


def test_a_riddle_stays_one_on_other_sites() -> None:
    about = properties(card({"board": "classic", "seed": "1", "aim": "0.1", "guess": ""}, BASE))
    assert about["og:url"] == f"{BASE}replay.html?board=classic&seed=1&aim=0.1&guess="
    assert "aim=0.1&t=1.5&" in about["og:image"], "of this drop, before it lands"


NO_DROPS: list[dict[str, str]] = [
    {},
    {"board": "triangle-8"},
    {"seed": "1"},
    {"board": "../x", "seed": "1"},
    {"board": '"><script>', "seed": "1"},
    {"board": "triangle-8", "seed": "-1"},
    {"board": "triangle-8", "seed": "1" * 21},
]


def test_a_link_without_a_drop_has_a_card_without_a_picture() -> None:
    for query in NO_DROPS:
        text = card(query, BASE)
        assert properties(text).keys() == {"og:type", "og:site_name", "og:title", "og:description"}
        assert "<script" not in text
    # A link's parameters cannot leave their attribute.
    about = card({"board": "classic", "seed": "1", "x": '"><script>'}, BASE)
    assert "<script>" not in about
    assert properties(about)["og:image"].startswith(f"{BASE}api/v1/drops/classic/1.png?x=%22%3E")


def test_one_page_may_be_framed_by_other_sites_and_no_other(http: httpx.Client) -> None:
    framed = http.get("/replay.html?board=triangle-8&seed=42&embed")
    assert framed.status_code == 200
    assert "frame-ancestors *" in framed.headers["content-security-policy"]
    assert "x-frame-options" not in framed.headers
    for path in ("/", "/replay.html", "/?embed", "/embed", "/api/v1/boards"):
        headers = http.get(path).headers
        assert "frame-ancestors 'none'" in headers["content-security-policy"], path
        assert headers["x-frame-options"] == "DENY"


def test_addresses_of_the_first_version_lead_to_the_replay(http: httpx.Client) -> None:
    query = "board=classic&seed=1&shift=1e-9"
    for former, view in (("/compare.html", "compare"), ("/embed/replay", "embed")):
        answer = http.get(f"{former}?{query}", follow_redirects=True)
        assert answer.status_code == 200
        assert str(answer.url).endswith(f"/replay.html?{query}&{view}")
        assert f'data-view="{view}"' in answer.text


def test_a_site_below_a_path_names_itself_by_that_path() -> None:
    with serving(root_path="/games/plinko") as below, below.client() as http:
        about = properties(http.get("/replay.html?board=triangle-8&seed=1").text)
        assert about["og:url"].startswith(f"{below.url}/games/plinko/replay.html?")
        assert about["og:image"].startswith(f"{below.url}/games/plinko/api/v1/drops/")
        made = http.post("/api/v1/rooms", json={"board": "triangle-8"})
        assert made.headers["location"] == f"/games/plinko/api/v1/rooms/{made.json()['id']}"
        more = http.get("/api/v1/rooms?limit=1")
        assert more.headers["link"].startswith("</games/plinko/api/v1/rooms?limit=1&after=")
        assert 'href="/games/plinko/' in http.get("/nowhere", headers={"accept": "text/html"}).text
