"""Adds to every response the request's id and what is left of the client's limits."""

import re
import secrets

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from plinko.app.web.limits import Allowance
from plinko.app.web.problems import HOPS

REQUEST_ID = "x-request-id"

_ID = re.compile(r"[A-Za-z0-9._~-]{1,64}")


class AnswerHeaders:
    """Adds `X-Request-Id` to every response, and `RateLimit` if a limit applied to the request.

    A client or a proxy may choose the id, so that its log and the server's have the same one.

    On a server below a path (`--root-path`), `Location` and `Link` get that path in front. If one
    server forwards the request to another, only the first one adds it.
    """

    def __init__(self, app: ASGIApp, root_path: str = "") -> None:
        self.app = app
        self._root_path = root_path

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        scope["root_path"] = self._root_path
        asked = Headers(scope=scope)
        given = asked.get(REQUEST_ID, "")
        chosen = given if _ID.fullmatch(given) else secrets.token_hex(16)
        allowances: dict[str, Allowance] = {}
        scope.setdefault("state", {}).update(request_id=chosen, allowances=allowances)

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers[REQUEST_ID] = chosen
                if self._root_path and HOPS not in asked:
                    self._prefix(headers)
                if allowances:
                    limits = allowances.values()
                    headers["ratelimit-policy"] = ", ".join(each.policy for each in limits)
                    headers["ratelimit"] = ", ".join(each.rest for each in limits)
            await send(message)

        await self.app(scope, receive, send_with_headers)

    def _prefix(self, headers: MutableHeaders) -> None:
        if headers.get("location", "").startswith("/"):
            headers["location"] = self._root_path + headers["location"]
        if headers.get("link", "").startswith("</"):
            headers["link"] = f"<{self._root_path}{headers['link'][1:]}"


def note(scope: Scope, allowance: Allowance) -> None:
    """Have the response report a limit; of several reports of one limit the last counts."""
    found = scope.get("state", {}).get("allowances")
    if found is not None:
        found[allowance.name] = allowance
