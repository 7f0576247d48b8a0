"""Query parameters that no route lists, or that come twice, are refused like unlisted fields."""

from collections.abc import Collection

from fastapi import Request
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute
from starlette.datastructures import QueryParams

from app.errors import InvalidValueError, shorten


async def listed_queries(request: Request) -> None:
    """Raise InvalidValueError for a parameter that the request's route does not have, or twice.

    A misspelt `solver` would else be a drop of another solver than was asked for.
    """
    if not request.query_params:
        return
    route = request.scope["route"]
    known = _names(route.dependant) if isinstance(route, APIRoute) else []
    check_queries(request.query_params, known)


def _names(asked: Dependant) -> list[str]:
    """The query parameters of a route and of what it depends on."""
    names = [each.alias for each in asked.query_params]
    return names + [name for each in asked.dependencies for name in _names(each)]


def check_queries(given: QueryParams, known: Collection[str]) -> None:
    """Raise InvalidValueError naming the first parameter that is not known or comes twice."""
    for name in given:
        if name not in known:
            what = ", ".join(known) or "none"
            raise InvalidValueError(
                f"{shorten(name)} is no query parameter here; there is: {what}", field=name
            )
        values = given.getlist(name)
        if len(values) > 1:
            raise InvalidValueError(
                f"{name} is given {len(values)} times: {', '.join(map(shorten, values[:3]))}",
                field=name,
            )
