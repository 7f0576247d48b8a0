"""What a request's computing costs its client: processor time, however the work ends."""

import asyncio
import contextlib
import io
import os
import time
from collections.abc import Callable

import httpx
import pytest
from PIL import Image

from plinko.app.computing import prices
from plinko.app.computing.prices import Price
from plinko.app.computing.process import Done
from plinko.app.errors import BusyError, DeadlineError, EndedError
from plinko.app.web.computing import Computing
from plinko.app.web.limits import Budgets

PRICE = Price("pixels", 1.0, 1.0, 3.0)


@pytest.mark.parametrize(
    ("used", "end", "cost"),
    [
        ([5.0], None, 5.0),
        ([0.25], asyncio.CancelledError(), 0.25),
        ([], asyncio.CancelledError(), 0.0),
        ([10.0], DeadlineError("too long"), 10.0),
        ([], BusyError("refused before it began"), 0.0),
        ([], EndedError("nobody knows what it took"), PRICE.seconds),
    ],
    ids=["done", "the client left", "left in the queue", "too long", "refused", "process ended"],
)
async def test_a_client_pays_the_processor_time_that_its_work_took(
    used: list[float], end: BaseException | None, cost: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    budgets = Budgets(rate=1e-9, burst=100.0)

    async def measured(*_: object, spend: Callable[[float], None], **__: object) -> Done:
        for seconds in used:
            spend(seconds)
        if end is not None:
            raise end
        return Done(None, None, sum(used))

    computing = Computing(1)
    monkeypatch.setattr(computing.workers, "measured", measured)
    computing.budgets = budgets
    with contextlib.suppress(type(end)) if end else contextlib.nullcontext():
        await computing.compute("client", PRICE, os.getpid)
    left = budgets.allowance("client", time.monotonic(), "computing-ms").left
    assert 100.0 - left / 1000.0 == pytest.approx(cost, abs=0.01)


def test_a_film_is_priced_by_the_frames_that_it_has(
    http: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    priced: list[int] = []

    def noted(pixels: int, frames: int) -> Price:
        priced.append(frames)
        return PRICE

    monkeypatch.setattr(prices, "animation", noted)
    for fmt, fps in (("gif", 60), ("webp", 60), ("gif", 50)):
        film = http.get(f"/api/v1/drops/triangle-8/42.{fmt}?width=240&fps={fps}")
        with Image.open(io.BytesIO(film.content)) as image:
            assert priced.pop() == getattr(image, "n_frames", 1)
