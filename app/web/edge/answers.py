"""What every answer says of its request: an id, and what is left of its client's limits."""

import re
import secrets

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.web.limits import Allowance
from app.web.problems import HOPS

REQUEST_ID = "x-request-id"

_ID = re.compile(r"[A-Za-z0-9._~-]{1,64}")


class AnswerHeaders:
    """Adds `X-Request-Id` to every answer, and `RateLimit` where a limit was counted against.

    `Location` and `Link` of a server below a path (`--root-path`) begin with that path; the server
    that hands a request on puts it there, and not the one that answers. A client or a proxy may
    choose the id, so that its log and the server's name one request alike.
    """

    def __init__(self, app: ASGIApp, root_path: str = "") -> None:
        self.app = app
        self._root_path = root_path

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and add the headers to its answer."""
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
                if HOPS not in asked and headers.get("location", "").startswith("/"):
                    headers["location"] = self._root_path + headers["location"]
                if HOPS not in asked and headers.get("link", "").startswith("</"):
                    headers["link"] = f"<{self._root_path}{headers['link'][1:]}"
                if allowances:
                    told = allowances.values()
                    headers["ratelimit-policy"] = ", ".join(each.policy for each in told)
                    headers["ratelimit"] = ", ".join(each.rest for each in told)
            await send(message)

        await self.app(scope, receive, send_with_headers)


def note(scope: Scope, allowance: Allowance) -> None:
    """Have the answer say what is left of a limit; the last word of each limit counts."""
    found = scope.get("state", {}).get("allowances")
    if found is not None:
        found[allowance.name] = allowance
