"""A request's body that can be read again, for a request that is tried again."""

from starlette.types import Message, Receive


class Body:
    """What `receive` has given, and what it will give."""

    def __init__(self, receive: Receive) -> None:
        self._receive = receive
        self._read: list[Message] = []

    async def whole(self) -> bytes:
        """All of it; what came of it when the client has left."""
        receive, parts = self.again(), []
        while True:
            message = await receive()
            parts.append(message.get("body", b""))
            if not message.get("more_body", False):
                return b"".join(parts)

    def again(self) -> Receive:
        """From the beginning."""
        place = 0

        async def receive() -> Message:
            nonlocal place
            if place == len(self._read):
                message = await self._receive()
                if message["type"] == "http.disconnect":
                    return message
                self._read.append(message)
            place += 1
            return self._read[place - 1]

        return receive

    async def until_left(self) -> None:
        """Return when the client has left; its body was read before."""
        while (await self._receive())["type"] != "http.disconnect":
            pass
