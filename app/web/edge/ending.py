"""Answers requests that a stop or a failure would leave without an answer."""

import asyncio
import logging

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from plinko.app.errors import BusyError
from plinko.app.web.problems import problem_response

_log = logging.getLogger("plinko")


class Ending:
    """An ASGI application around the framework: it answers what the framework leaves unanswered.

    When the server stops, uvicorn cancels the requests that take longer than the grace period: they
    get 503. A failure outside the framework's own error handling gets 500. uvicorn would answer
    both in plain text. If the answer has already begun, the connection is cut off instead. If it is
    complete, the framework has logged the failure, and it ends here.
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
