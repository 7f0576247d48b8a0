"""The page and its files, as they lie in static/; and what to say of paths that nobody serves."""

from pathlib import Path

from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.routing import Match, Mount
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

_READING = frozenset({"GET", "HEAD"})
_METHODS = ("GET", "POST", "PUT", "PATCH", "DELETE")


class Page(StaticFiles):
    """Static files that a browser keeps but asks about each time: a new release shows at once."""

    def __init__(self, directory: Path) -> None:
        super().__init__(directory=directory, html=True)

    async def get_response(self, path: str, scope: Scope) -> Response:
        """The file, with a cache header; raises HTTPException 404, or 405 naming what is allowed.

        As the last of the application's routes this one sees all that no other took, requests with
        another route's wrong method among them.
        """
        if scope["method"] not in _READING:
            allowed = _methods_of_others(scope)
            if not allowed and self.lookup_path(path)[1] is not None:
                allowed = set(_READING)
            if not allowed:
                raise HTTPException(404)
            raise HTTPException(405, headers={"allow": ", ".join(sorted(allowed))})
        try:
            response = await super().get_response(path, scope)
        except HTTPException as error:
            allowed = _methods_of_others(scope) if error.status_code == 404 else set()
            if not allowed:
                raise
            raise HTTPException(405, headers={"allow": ", ".join(sorted(allowed))}) from error
        response.headers.setdefault("cache-control", "no-cache")
        return response


def _methods_of_others(scope: Scope) -> set[str]:
    """By which methods another route would take this path."""
    others = [route for route in scope["app"].routes if not isinstance(route, Mount)]
    allowed = {
        method
        for method in _METHODS
        if any(route.matches({**scope, "method": method})[0] is Match.FULL for route in others)
    }
    return allowed | {"HEAD"} if "GET" in allowed else allowed
