"""HEAD on every path that GET has: the same status and headers, and no body (RFC 9110, 9.3.2)."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send


class HeadAsGet:
    """Has the application answer as to GET, and sends only the head.

    After the head the application receives `http.disconnect`, which ends a live stream.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return
        ended = False

        async def send_head(message: Message) -> None:
            nonlocal ended
            if message["type"] == "http.response.start":
                await send(message)
            elif not ended:
                ended = True
                await send({"type": "http.response.body", "body": b"", "more_body": False})

        async def receive_until_then() -> Message:
            return {"type": "http.disconnect"} if ended else await receive()

        # A head describes the whole, never a part of it (RFC 9110, 14.2).
        headers = [each for each in scope["headers"] if each[0] != b"range"]
        asked = {**scope, "method": "GET", "headers": headers}
        await self.app(asked, receive_until_then, send_head)
