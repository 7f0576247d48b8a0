"""Requests that a stop of the server cuts off are answered, in the server's own words."""

import asyncio

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.errors import BusyError
from app.web.edge.middleware import SecurityHeaders
from app.web.problems import problem_response


class Ending:
    """An ASGI application, the outermost: a request that is cancelled gets 503.

    uvicorn cancels those that the grace was too short for, and would answer 500 in plain text.
    One whose answer has begun is cut off.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, and answer it if it is cancelled before that was done."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        begun = False

        async def noting(message: Message) -> None:
            nonlocal begun
            begun = True
            await send(message)

        try:
            await self._app(scope, receive, noting)
        except asyncio.CancelledError:
            if begun:
                raise
            answer = problem_response(BusyError("the server is stopping"), scope["path"])
            await SecurityHeaders(answer)(scope, receive, send)
