"""Strict query parameters: unknown or repeated ones are refused, and numbers must be plain."""

import re
from collections.abc import Callable, Collection
from typing import Annotated

from fastapi import Request
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute
from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError
from starlette.datastructures import QueryParams

from plinko.app.errors import InvalidValueError
from plinko.engine.errors import shorten


def _spelt(pattern: str, wanted: str) -> Callable[[object], object]:
    """A check of a number's text: Python alone would also accept `1_0` and ` 10`."""
    form = re.compile(pattern, re.ASCII)

    def check(text: object) -> object:
        if isinstance(text, str) and form.fullmatch(text) is None:
            raise PydanticCustomError("number", "it must be {wanted}", {"wanted": wanted})
        return text

    return check


Number = Annotated[
    float,
    Field(allow_inf_nan=False),
    BeforeValidator(
        _spelt(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", "a decimal number, such as 0.5 or 1e-3")
    ),
]
"""A query parameter that is a number."""

Whole = Annotated[
    int,
    Field(lt=1 << 63),  # the largest integer of the ledger's database
    BeforeValidator(_spelt(r"[+-]?\d+", "a whole number in digits")),
]
"""A query parameter that is a whole number."""


async def listed_queries(request: Request) -> None:
    """Raise InvalidValueError for a parameter that is repeated or unknown to the request's route.

    Otherwise a misspelt `solver` would give a drop of the default solver.
    """
    if not request.query_params:
        return
    route = request.scope["route"]
    known = _names(route.dependant) if isinstance(route, APIRoute) else []
    check_queries(request.query_params, known)


def _names(asked: Dependant) -> list[str]:
    """The query parameters of a route and of its dependencies."""
    names = [each.alias for each in asked.query_params]
    return names + [name for each in asked.dependencies for name in _names(each)]


def check_queries(given: QueryParams, known: Collection[str]) -> None:
    """Raise InvalidValueError naming the first parameter that is unknown or repeated."""
    for name in given:
        if name not in known:
            what = ", ".join(known) or "none"
            raise InvalidValueError(
                f"{shorten(name)} is not a query parameter here; the parameters are: {what}",
                field=name,
            )
        values = given.getlist(name)
        if len(values) > 1:
            raise InvalidValueError(
                f"{name} is given {len(values)} times: {', '.join(map(shorten, values[:3]))}; "
                "give it once",
                field=name,
            )
