"""Pictures over HTTP: all formats, cached and computed once; refusals give the reason."""

import asyncio
import io
import math
from collections.abc import Callable

import httpx
import pytest
from PIL import Image

from plinko.app.errors import BusyError
from plinko.app.pictures.cache import Pictures, drawing_version
from plinko.app.render import drop_animation, drop_picture
from plinko.engine import Board, drop, drop_many
from tests.app.conftest import TINY
from tests.kit.serving import Running

BOARD = Board.preset("triangle-12")
DROP = "/api/v1/drops/triangle-12/42"


def opened(response: httpx.Response) -> Image.Image:
    assert response.status_code == 200, response.text
    return Image.open(io.BytesIO(response.content))


FORMATS = {"png": "PNG", "jpg": "JPEG", "gif": "GIF", "webp": "WEBP", "apng": "PNG"}


def test_a_drop_comes_in_every_format_and_as_a_video(http: httpx.Client) -> None:
    for suffix, fmt in FORMATS.items():
        moves = suffix not in {"png", "jpg"}
        response = http.get(f"{DROP}.{suffix}?width=240{'&fps=10' * moves}")
        assert response.headers["content-type"] == f"image/{suffix.replace('jpg', 'jpeg')}"
        with opened(response) as picture:
            assert (picture.format, picture.width) == (fmt, 240)
            frames = math.ceil(drop(BOARD, 42).duration * 10) + 1
            assert getattr(picture, "n_frames", 1) == (frames if moves else 1)
    response = http.get(f"{DROP}.mp4?width=240&fps=5")
    assert response.headers["content-type"] == "video/mp4"
    assert response.content == drop_animation(drop(BOARD, 42), "mp4", 240, 5)


def test_what_is_asked_for_is_what_is_drawn(http: httpx.Client) -> None:
    done = drop(BOARD, 42)
    query = "width=300&theme=dark&t=1.5"
    assert http.get(f"{DROP}.png?{query}").content == drop_picture(done, "png", 300, "dark", 1.5)
    slow = http.get(f"{DROP}.gif?width=240&fps=5&theme=dark").content
    assert slow == drop_animation(done, "gif", 240, 5, "dark")
    other = drop(BOARD, 42, x=0.0625)
    assert http.get(f"{DROP}.png?x=0.0625&width=300").content == drop_picture(other, "png", 300)


def test_a_picture_is_cacheable_under_a_tag_for_each_query(http: httpx.Client) -> None:
    tags = set()
    for query in ("png", "png?width=320", "png?t=1", "png?theme=dark", "jpg", "gif?fps=2"):
        response = http.get(f"{DROP}.{query}")
        assert "max-age" in response.headers["cache-control"]
        tag = response.headers["etag"]
        assert drawing_version() in tag
        tags.add(tag)
        again = http.get(f"{DROP}.{query}", headers={"if-none-match": tag})
        assert (again.status_code, again.content) == (304, b"")
    assert len(tags) == 6


@pytest.fixture
def no_worker(server: Running, monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """A function; after it is called, every computation in a worker fails."""

    async def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a worker was asked")

    return lambda: monkeypatch.setattr(server.services.computing.workers, "measured", refuse)


def test_a_kept_picture_and_a_caller_s_current_copy_cost_no_worker(
    http: httpx.Client, no_worker: Callable[[], None]
) -> None:
    suffixes = (".png?width=250", ".apng?fps=3&width=250", ".gif?fps=2", ".mp4?fps=2")
    first = [http.get(f"{DROP}{each}") for each in (*suffixes, "/frames?fps=10")]
    no_worker()
    for each, answer in zip((*suffixes, "/frames?fps=10"), first, strict=True):
        tag = {"if-none-match": answer.headers["etag"]}
        assert http.get(f"{DROP}{each}", headers=tag).status_code == 304
        if each in suffixes:
            assert http.get(f"{DROP}{each}").content == answer.content


def test_drops_that_differ_in_anything_have_other_pictures(http: httpx.Client) -> None:
    stepped = "12/42?solver=stepped"
    drops = "12/42", "12/43", "11/42", "12/42?x=0", "16/42", "16/42?aim=0.01"
    tags = set()
    for path in (*drops, stepped, f"{stepped}&dt=0.01", f"{stepped}&substeps=5"):
        board, _, query = path.partition("?")
        answer = http.get(f"/api/v1/drops/triangle-{board}.png?width=240&{query}")
        assert answer.status_code == 200, path
        tags.add(answer.headers["etag"])
    assert len(tags) == len(drops) + 3
    # A registered board is drawn by its digest.
    digest = http.post("/api/v1/boards", json={**TINY, "name": "drawn"}).json()["digest"]
    with opened(http.get(f"/api/v1/drops/{digest}/7.png?width=300")) as picture:
        assert picture.width == 300


# many drops


@pytest.mark.parametrize("kind", ["sheet", "density", "histogram"])
@pytest.mark.parametrize("suffix", ["png", "jpg", "webp"])
def test_many_drops_come_in_every_still_format(http: httpx.Client, kind: str, suffix: str) -> None:
    path = f"/api/v1/boards/triangle-12/{kind}.{suffix}?drops=9&width=400"
    response = http.get(path)
    with opened(response) as picture:
        assert (picture.format, picture.width) == (FORMATS[suffix], 400)
    assert response.headers["content-type"] == f"image/{suffix.replace('jpg', 'jpeg')}"
    tag = {"if-none-match": response.headers["etag"]}
    assert http.get(path, headers=tag).status_code == 304
    assert http.get(f"{path}&seed=1", headers=tag).status_code == 200


def test_many_drops_are_those_of_the_seeds(http: httpx.Client) -> None:
    from plinko.app.render import contact_sheet, density_picture, histogram_picture

    seeds, query = range(5, 105), "drops=100&seed=5&width=300&theme=dark"
    path = "/api/v1/boards/triangle-12"
    drawn = http.get(f"{path}/density.png?{query}").content
    assert drawn == density_picture(BOARD, seeds, width=300, theme="dark")
    drawn = http.get(f"{path}/histogram.png?{query}").content
    counts = drop_many(BOARD, seeds).histogram
    assert drawn == histogram_picture(BOARD, counts, width=300, theme="dark")
    drawn = http.get(f"{path}/sheet.png?drops=4&seed=5&columns=4").content
    assert drawn == contact_sheet(BOARD, range(5, 9), columns=4)


# made once


async def test_simultaneous_callers_share_one_drawing() -> None:
    pictures, go, started = Pictures(100), asyncio.Event(), []

    async def draw() -> bytes:
        started.append(1)
        await go.wait()
        return b"picture"

    asking = [asyncio.create_task(pictures.get("a", draw)) for _ in range(20)]
    await asyncio.sleep(0)  # all tasks begin
    asking[0].cancel()
    go.set()
    assert await asyncio.gather(*asking[1:]) == [b"picture"] * 19
    assert (len(started), pictures.drawn) == (1, 1)
    assert await pictures.get("a", draw) == b"picture"
    assert len(started) == 1


async def test_cached_pictures_are_bounded_and_the_unused_go_first() -> None:
    async def picture(size: int) -> bytes:
        return bytes(size)

    pictures = Pictures(100)
    for name in ("a", "b"):
        await pictures.get(name, lambda: picture(45))
    await pictures.get("a", lambda: picture(0))
    await pictures.get("c", lambda: picture(45))
    assert pictures.size == 90
    drawn = pictures.drawn
    await pictures.get("a", lambda: picture(0))
    assert pictures.drawn == drawn
    await pictures.get("b", lambda: picture(45))
    await pictures.get("too large", lambda: picture(101))
    assert pictures.drawn == drawn + 2
    assert pictures.size <= 100


async def test_a_picture_without_callers_is_not_drawn() -> None:
    begun, ended = asyncio.Event(), asyncio.Event()

    async def draw() -> bytes:
        begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()
        return b""

    async def again() -> bytes:
        return b"again"

    pictures = Pictures(100)
    asking = [asyncio.create_task(pictures.get("a", draw)) for _ in range(2)]
    await begun.wait()
    asking[0].cancel()
    await asyncio.wait(asking[:1])
    assert not ended.is_set()
    asking[1].cancel()
    await ended.wait()
    assert await pictures.get("a", again) == b"again"


async def test_a_drawing_that_failed_is_tried_again() -> None:
    async def fail() -> bytes:
        raise BusyError("3 jobs wait already")

    async def draw() -> bytes:
        return b"now"

    pictures = Pictures(100)
    with pytest.raises(BusyError):
        await pictures.get("c", fail)
    assert await pictures.get("c", draw) == b"now"


def test_a_busy_server_says_when_to_come_back(
    server: Running, http: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    workers = server.services.computing.workers
    monkeypatch.setattr(workers, "max_jobs", -workers.processes)
    refused = http.get(f"{DROP}.gif?width=241")
    assert refused.status_code == 503
    assert int(refused.headers["retry-after"]) >= 1
