"""The table of routes: finds a request's route, and calls its function.

FastAPI would ask each included router and each of its routes whether it matches, which takes longer
than most requests. And it takes as long to find that a request has no query as a drop takes.
"""

import inspect
import re
from collections import defaultdict
from collections.abc import Iterable
from operator import attrgetter
from typing import Any, Final

from fastapi import APIRouter, Depends, Request, Response
from fastapi.dependencies.models import Dependant
from fastapi.middleware.asyncexitstack import AsyncExitStackMiddleware
from fastapi.routing import APIRoute
from starlette.routing import BaseRoute, Match, Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send

from plinko.app.web.routes.queries import listed_queries

_WEBSOCKET: Final = "websocket"  # in place of a method


class RouteTable(BaseRoute):
    """Many routes as one: a regular expression for each method says which route has a path.

    As an application it passes on to `otherwise` what no route matches.
    """

    def __init__(
        self, routes: Iterable[BaseRoute], root_path: str = "", otherwise: ASGIApp | None = None
    ) -> None:
        self._otherwise = otherwise
        by_method: dict[str, list[Route | WebSocketRoute]] = defaultdict(list)
        self.routes = list(routes)
        for route in self.routes:
            assert isinstance(route, Route | WebSocketRoute)
            methods = route.methods if isinstance(route, Route) else None
            for method in methods or [_WEBSOCKET]:
                by_method[method].append(route)
        self._by_method = {
            method: (_any_of(each.path_regex.pattern for each in found), found)
            for method, found in by_method.items()
        }
        self._root = re.compile(f"{re.escape(root_path)}(?=/)")

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """A full match with the first route of this method and path, or none."""
        paths, routes = self._by_method.get(scope.get("method", _WEBSOCKET), (None, []))
        root = self._root.match(scope["path"])
        found = paths.match(scope["path"], root.end() if root else 0) if paths else None
        if found is None or found.lastindex is None:
            return Match.NONE, {}
        route = routes[found.lastindex - 1]
        match, child_scope = route.matches(scope)
        return match, {**child_scope, "route": route}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        lives = scope["type"] == "lifespan"
        match, child_scope = (Match.NONE, {}) if lives else self.matches(scope)
        if match is Match.FULL:
            scope.update(child_scope)
            await self.handle(scope, receive, send)
        elif self._otherwise is not None:
            await self._otherwise(scope, receive, send)

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Have the route answer that `matches` found."""
        await scope["route"].handle(scope, receive, send)


def _any_of(patterns: Iterable[str]) -> re.Pattern[str]:
    """A pattern with one numbered group for each of the given ones."""
    unnamed = (re.sub(r"\(\?P<\w+>", "(?:", each.removeprefix("^")) for each in patterns)
    return re.compile("|".join(f"({each})" for each in unnamed))


class Operation(APIRoute):
    """A route that calls its function directly if the request has no query."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._is_direct = _can_call(self.dependant)
        self._solved = AsyncExitStackMiddleware(super().handle)  # FastAPI's way needs it around

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["query_string"] or not self._is_direct:
            await self._solved(scope, receive, send)
            return
        response: Response = await _call(self.dependant, Request(scope, receive, send))
        await response(scope, receive, send)


def _can_call(asked: Dependant) -> bool:
    """Whether `_call` can do without the framework: only plain texts and optional parameters."""
    unread = [*asked.header_params, *asked.cookie_params, *asked.body_params]
    return (
        inspect.iscoroutinefunction(asked.call)
        and not unread
        and all(each.field_info.annotation is str for each in asked.path_params)
        and not any(each.field_info.is_required() for each in asked.query_params)
        and all(
            each.call is listed_queries or (each.name and _can_call(each))
            for each in asked.dependencies
        )
    )


async def _call(asked: Dependant, request: Request) -> Any:
    """Call a route's function, or a function that it depends on, with the defaults of its query."""
    values: dict[str, Any] = {
        each.name: request.path_params[each.name] for each in asked.path_params
    }
    for each in asked.dependencies:
        if each.name:
            values[each.name] = await _call(each, request)
    if asked.request_param_name:
        values[asked.request_param_name] = request
    if asked.http_connection_param_name:
        values[asked.http_connection_param_name] = request
    assert asked.call is not None
    return await asked.call(**values)


def operations(tag: str, path: str = "/api/v1") -> APIRouter:
    """A router of operations below `path`; they refuse queries that they do not list."""
    return unlisted(prefix=path, tags=[tag], dependencies=[Depends(listed_queries)])


def unlisted(**options: Any) -> APIRouter:
    """A router of operations that ignore queries; OpenAPI calls them as their functions."""
    return APIRouter(
        route_class=Operation, generate_unique_id_function=attrgetter("name"), **options
    )
