"""A flood of requests is served one at a time, so that ticks and other clients come in between."""

import asyncio
import math
from collections.abc import Callable, Iterator

from starlette.types import Receive, Scope, Send

from app.web.edge.turns import Turns


class Begun:
    """An application that notes whose requests begin; a tick is due in each turn of the loop."""

    def __init__(self, due_in: Callable[[], float] = lambda: math.inf) -> None:
        self.order: list[str] = []
        self.turns = Turns(self, due_in)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self.order.append(scope["client"][0])

    def ask(self, client: str) -> "asyncio.Task[None]":
        async def nothing() -> Scope:
            raise AssertionError("nothing is received here")

        async def nobody(_: object) -> None:
            raise AssertionError("nothing is sent here")

        scope = {"type": "http", "client": (client, 1)}
        return asyncio.ensure_future(self.turns(scope, nothing, nobody))

    def tick(self) -> None:
        self.order.append("tick")
        asyncio.get_running_loop().call_soon(self.tick)

    def between_ticks(self) -> Iterator[list[str]]:
        begun: list[str] = []
        for each in self.order:
            if each == "tick":
                yield begun
                begun = []
            else:
                begun.append(each)


async def test_a_tick_waits_for_one_request_of_a_flood() -> None:
    app = Begun()
    flood = [app.ask("192.0.2.1") for _ in range(100)]
    app.tick()
    await asyncio.gather(*flood)
    assert app.order.count("192.0.2.1") == 100
    assert max(map(len, app.between_ticks())) == 1


async def test_who_asks_once_waits_for_one_of_those_who_ask_a_hundred_times() -> None:
    app = Begun()
    flood = [app.ask("192.0.2.1") for _ in range(100)]
    flood += [app.ask("192.0.2.2") for _ in range(100)]
    await asyncio.sleep(0)
    before = len(app.order)
    await app.ask("192.0.2.3")
    assert len(app.order) - before <= 4
    await asyncio.gather(*flood)


async def test_shortly_before_a_tick_a_flood_waits_for_it() -> None:
    due = [0.1]
    app = Begun(lambda: due[0])
    flood = [app.ask("192.0.2.1") for _ in range(10)]
    for _ in range(3):
        await asyncio.sleep(0)
    assert len(app.order) > 1, "a tick that is far off keeps nobody waiting"
    due[0] = 0.004
    await asyncio.sleep(0)
    begun = len(app.order)
    for _ in range(20):
        await asyncio.sleep(0)
    assert len(app.order) - begun <= 1, "one may have had its turn already"
    due[0] = 0.0166  # it has come
    await asyncio.gather(*flood)


async def test_ticks_that_leave_no_time_keep_no_request_out() -> None:
    app = Begun(lambda: 0.0)
    flood = [app.ask("192.0.2.1") for _ in range(10)]
    app.tick()
    await asyncio.gather(*flood)
    assert app.order.count("192.0.2.1") == 10
    # Four turns of the loop each, in which a tick that is due has begun.
    assert app.order.count("tick") >= 30


async def test_a_request_alone_begins_at_once() -> None:
    app = Begun()
    for _ in range(3):
        asked = app.ask("192.0.2.1")
        await asyncio.sleep(0)
        assert asked.done()
        await asyncio.sleep(0)


async def test_those_who_give_up_hold_up_nobody() -> None:
    app = Begun()
    flood = [app.ask("192.0.2.1") for _ in range(10)]
    await asyncio.sleep(0)
    for each in flood[1:]:
        each.cancel()
    await app.ask("192.0.2.2")
    assert app.order == ["192.0.2.1", "192.0.2.2"]
    await asyncio.gather(*flood, return_exceptions=True)
    await asyncio.sleep(0)
    asked = app.ask("192.0.2.3")
    await asyncio.sleep(0)
    assert asked.done()
