"""The table of routes finds what asking one route after another would find."""

from collections.abc import Iterator

import httpx
import pytest
from fastapi import Request, Response
from fastapi.routing import APIRoute
from starlette.routing import Match, Route
from starlette.types import Scope

from plinko.app.main import create_app
from plinko.app.settings import Settings
from plinko.app.web.routes.table import RouteTable, operations

METHODS = ("GET", "POST", "PATCH", "DELETE", "PUT")
TABLE = next(
    each
    for each in create_app(Settings(database_url="sqlite://")).routes
    if isinstance(each, RouteTable)
)


def request(method: str, path: str, **more: object) -> Scope:
    return {"type": "http", "method": method, "path": path, "headers": [], **more}


def first_of_all(scope: Scope) -> object:
    """The first route that matches, asked one after another."""
    found = (each for each in TABLE.routes if each.matches(scope)[0] is Match.FULL)
    return next(found, None)


def paths() -> Iterator[str]:
    for route in TABLE.routes:
        path = getattr(route, "path_format", "")
        for text in ("check", "a.png", "42", "frames", "%2F", "é"):
            filled = path
            while "{" in filled:
                filled = filled.partition("{")[0] + text + filled.partition("}")[2]
            yield from (filled, f"{filled}/", f"{filled}.png", filled[:-1], f"/x{filled}")


@pytest.mark.parametrize("method", METHODS)
def test_it_finds_the_first_route_that_matches(method: str) -> None:
    found = 0
    for path in sorted(set(paths())):
        scope = request(method, path)
        match, child = TABLE.matches(scope)
        assert child.get("route") is first_of_all(scope), path
        assert (match is Match.FULL) == ("route" in child)
        found += match is Match.FULL
    assert found > 0 or method == "PUT"


def test_a_websocket_has_a_route_of_its_own() -> None:
    scope: Scope = {"type": "websocket", "path": "/ws/rooms/main", "headers": []}
    assert TABLE.matches(scope)[0] is Match.FULL
    assert TABLE.matches(request("GET", "/ws/rooms/main"))[0] is Match.NONE


@pytest.mark.parametrize("path", ["/below/it/a", "/a"])
def test_below_a_path_a_route_is_found_with_and_without_it(path: str) -> None:
    async def answer() -> None: ...

    table = RouteTable([Route("/a", answer)], "/below/it")
    assert table.matches(request("GET", path, root_path="/below/it"))[0] is Match.FULL
    assert table.matches(request("GET", f"/below{path}", root_path="/below/it"))[0] is Match.NONE


async def test_a_parameter_without_a_default_is_still_required() -> None:
    router = operations("boards")

    @router.get("/needed")
    async def needed(request: Request, amount: int) -> Response:
        raise AssertionError(amount)

    (route,) = router.routes
    assert isinstance(route, APIRoute)
    app = create_app(Settings(database_url="sqlite://"))
    app.routes.insert(0, route)
    transport = httpx.ASGITransport(app)
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
        refused = await client.get("/api/v1/needed")
    assert (refused.status_code, refused.json()["field"]) == (422, "amount")
