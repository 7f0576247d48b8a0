"""A room's QR code can be read by another library than the one that wrote it."""

import re

import httpx
import numpy as np
import numpy.typing as npt
import zxingcpp

from tests.app.conftest import TINY
from tests.kit.serving import Running

SCALE = 8  # pixels per module


def pixels(svg: str) -> npt.NDArray[np.uint8]:
    """Draw a code's SVG, in which modules are horizontal strokes."""
    found = re.search(r'viewBox="0 0 (\d+) (\d+)"', svg)
    assert found is not None
    width, height = map(int, found.groups())
    picture = np.full((height, width), 255, np.uint8)
    (strokes,) = re.findall(r'class="qrline"[^>]* d="([^"]+)"', svg)
    x = y = 0.0
    for kind, numbers in re.findall(r"([Mmh])([-\d. ]+)", strokes):
        values = [float(value) for value in re.findall(r"-?\d*\.?\d+", numbers)]
        if kind == "h":
            picture[int(y), int(x) : int(x + values[0])] = 0
            x += values[0]
        else:
            x, y = values if kind == "M" else (x + values[0], y + values[1])
    return picture.repeat(SCALE, 0).repeat(SCALE, 1)


def read(svg: str) -> str:
    (code,) = zxingcpp.read_barcodes(pixels(svg))
    text: str = code.text
    return text


def test_the_code_of_a_room_leads_to_its_page(server: Running) -> None:
    with server.client() as http:
        made = http.post("/api/v1/rooms", json={"board": TINY}).raise_for_status().json()["id"]
        answer = http.get(f"/api/v1/rooms/{made}/qr.svg").raise_for_status()
        assert answer.headers["content-type"] == "image/svg+xml"
        address = read(answer.text)
        assert address == f"{server.url}/?room={made}"
        assert http.get(address).status_code == 200
        phones = http.get(f"/api/v1/rooms/{made}/qr.svg", params={"page": "pupil"})
        address = read(phones.raise_for_status().text)
        assert address == f"{server.url}/pupil.html?room={made}"
        assert http.get(address).status_code == 200
        wrong = http.get(f"/api/v1/rooms/{made}/qr.svg", params={"page": "stage"})
        assert wrong.status_code == 422
        assert http.get("/api/v1/rooms/nope/qr.svg").status_code == 404
        # The main room's code is the address of the request.
        here = f"http://localhost:{httpx.URL(server.url).port}"
        code = http.get(f"{here}/api/v1/rooms/main/qr.svg")
        assert read(code.raise_for_status().text) == f"{here}/"
