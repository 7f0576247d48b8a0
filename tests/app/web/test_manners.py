"""Every page can be installed on a phone."""

import json
import struct
from pathlib import Path

import httpx

STATIC = Path(__file__).parents[3] / "static"
THEME = json.loads((STATIC / "theme.json").read_text("utf-8"))


def test_the_pages_can_be_installed() -> None:
    manifest = json.loads((STATIC / "manifest.json").read_text("utf-8"))
    assert manifest["display"] == "standalone"
    assert manifest["start_url"] == manifest["scope"] == "./"
    assert manifest["theme_color"] == manifest["background_color"] == THEME["light"]["page"]
    assert {icon.get("purpose", "any") for icon in manifest["icons"]} == {"any", "maskable"}
    drawn = [icon for icon in manifest["icons"] if icon["type"] == "image/png"]
    assert {icon["sizes"] for icon in drawn} == {"192x192", "512x512"}
    for icon in drawn:
        header = (STATIC / icon["src"]).read_bytes()[:24]
        assert header[:8] == b"\x89PNG\r\n\x1a\n"
        width, height = struct.unpack(">II", header[16:])
        assert icon["sizes"] == f"{width}x{height}"


def test_each_page_names_what_installs_it(http: httpx.Client) -> None:
    for page in sorted(path.name for path in STATIC.glob("*.html")):
        text = http.get(f"/{page}").text
        root = "/" if page == "404.html" else ""  # shown for any path, so its links are absolute
        assert f'<link rel="manifest" href="{root}manifest.json">' in text, page
        assert f'<link rel="apple-touch-icon" href="{root}icons/192.png">' in text, page
