"""Requests that end before they were answered, by a stop or a failure, are answered here."""

import asyncio
import logging

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.errors import BusyError
from app.web.problems import problem_response

_log = logging.getLogger("plinko")


class Ending:
    """An ASGI application around the framework: a request that it leaves unanswered is answered.

    uvicorn cancels those that the grace of a stop was too short for: they get 503, and what fails
    outside of the framework's own care 500; uvicorn would answer both in plain text. A failure that
    the framework has answered ends here, as the framework has logged it. A request whose answer has
    begun is cut off.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        begun = ended = False

        async def noting(message: Message) -> None:
            nonlocal begun, ended
            begun = True
            ended = message["type"] == "http.response.body" and not message.get("more_body", False)
            await send(message)

        error: Exception
        try:
            await self._app(scope, receive, noting)
            return
        except asyncio.CancelledError:
            if begun:
                raise
            error = BusyError("the server is stopping")
        except Exception as failed:
            if ended:
                return
            if begun:
                raise
            _log.exception("request failed")
            error = failed
        await problem_response(error, scope["path"])(scope, receive, send)
