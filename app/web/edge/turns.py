"""Requests begin one in a turn of the event loop, clients in turn: a flood is not one piece."""

import asyncio
import math
from collections.abc import Callable
from typing import Final

from starlette.types import ASGIApp, Receive, Scope, Send

from app.concurrency.fair_queue import FairQueue
from app.web.edge.addresses import one_client

_AHEAD: Final = 0.005
"""s before a tick in which none of many requests begins: what the last ones still have to do, and
their answers, has these to come to its end."""

_TRIES: Final = 4
"""Times that the next one waits for a tick: until it is due, and the turns of the loop in which it
begins. A ticker that leaves no time at all does not keep requests out."""


class Turns:
    """An ASGI application whose requests begin one by one.

    What a request computes before it first waits is done in one piece, some 0.5 ms. A hundred that
    come at once would hold up the ticks of all rooms for as long as all of them take; between two
    turns of the event loop it does what else is due. Shortly before a tick they wait for it; else
    each tick would find the loop at what some request has left to do. Nothing waits that comes
    alone.
    """

    def __init__(self, app: ASGIApp, due_in: Callable[[], float] = lambda: math.inf) -> None:
        """`due_in` says in how many s the event loop is wanted elsewhere, on time."""
        self._app = app
        self._due_in = due_in
        self._queue: FairQueue[asyncio.Future[None]] = FairQueue()
        self._begun = False  # in this turn of the event loop
        self._waited = 0  # times for a tick

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on when it is its turn."""
        if scope["type"] != "lifespan":
            await self._turn(one_client((scope.get("client") or ("",))[0]))
        await self._app(scope, receive, send)

    async def _turn(self, client: str) -> None:
        loop = asyncio.get_running_loop()
        if self._begun:
            waiting = loop.create_future()
            self._queue.put(client, waiting)
            await waiting
        else:
            self._begun = True
            loop.call_soon(self._next, loop)

    def _next(self, loop: asyncio.AbstractEventLoop) -> None:
        """In the turn after: let the next one begin that has not given up."""
        due = self._due_in()
        if due < _AHEAD and self._waited < _TRIES:
            self._waited += 1
            loop.call_later(due, self._next, loop)
            return
        self._waited = 0
        while (waiting := self._queue.take()) is not None:
            if not waiting.done():
                waiting.set_result(None)
                loop.call_soon(self._next, loop)
                return
        self._begun = False
