"""A live room in an image tag shows falling balls, without a script in the page."""

import io
from typing import Any

import httpx
import numpy as np
from PIL import Image
from playwright.sync_api import expect

from tests.browser.conftest import Open
from tests.kit.address import Address
from tests.kit.waiting import LIMIT


def test_an_image_tag_shows_a_room_as_it_moves(opened: Open, server: Address) -> None:
    screen = opened().ready()
    page = screen.page
    rooms = f"{server.url}/api/v1/rooms"
    room = httpx.post(rooms, json={"board": "triangle-8"}, timeout=LIMIT).json()["id"]
    page.evaluate(
        """source => {
          const image = document.createElement("img");
          image.src = source;
          image.alt = "the room";
          document.body.prepend(image);
        }""",
        f"/api/v1/rooms/{room}/stream.mjpg?width=400",
    )
    image = page.get_by_alt_text("the room")
    expect(image).to_have_js_property("naturalWidth", 400)
    still = pixels(image.screenshot())
    moving: list[Any] = []
    for seed in range(8):
        httpx.post(
            f"{rooms}/{room}/drops", json={"seed": str(seed)}, timeout=LIMIT
        ).raise_for_status()
        before = moving[-1] if moving else still

        def moved(before: Any = before) -> bool:
            moving.append(pixels(image.screenshot()))
            return changed(before, moving[-1]) > 0

        screen.until(moved)
    assert changed(still, moving[-1]) > 50
    assert len({frame.tobytes() for frame in moving}) > 3


def changed(one: Any, other: Any) -> int:
    """How many pixels of two pictures differ clearly."""
    return int((abs(one - other).max(axis=-1) > 60).sum())


def pixels(picture: bytes) -> Any:
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image.convert("RGB")).astype(int)
