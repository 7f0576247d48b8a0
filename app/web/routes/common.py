"""Functions that all routes use: services, request bodies, computing, responses, OpenAPI."""

import asyncio
import contextlib
import re
import time
import urllib.parse
from collections.abc import Callable, Coroutine, Mapping
from typing import Annotated, Any, Final, TypeVar, TypeVarTuple

import msgspec
from fastapi import Depends, Request, Response
from starlette.requests import HTTPConnection
from starlette.types import Receive

from plinko.app.computing import prices, tasks
from plinko.app.computing.prices import Price
from plinko.app.errors import (
    GoneError,
    InvalidValueError,
    MalformedError,
    MediaTypeError,
    TooLargeError,
)
from plinko.app.web.edge.addresses import one_client
from plinko.app.web.edge.front import note
from plinko.app.web.problems import Problem
from plinko.app.web.services import Services
from plinko.engine import Board, json_text
from plinko.engine.errors import BoardError, EffortError, shorten
from plinko.engine.json_text import JsonObject
from plinko.engine.parameters import DEFAULT_DT, DEFAULT_SUBSTEPS, Solver, make_solver
from plinko.engine.seeding import parse_seed

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

MAX_SURFACES = 5000  # pegs and walls of a board in a request; bounds the work
SHORTEST_SUBSTEP = 1e-4  # s, of a stepped drop; bounds the work

_INLINE_BODY = 1 << 12  # bytes; a body up to this size is decoded in less than a millisecond
_CACHE_SECONDS = 86_400

_FAILURES = {
    304: "Not modified: the caller's copy is current",
    400: "Not JSON",
    401: "The token is missing",
    403: "Not the token of this room, or the room has no owner",
    404: "Not found",
    409: "The room accepts nothing now, or the request was carried out before",
    413: "The body is too large",
    415: "The Content-Type of the body is not JSON",
    416: "The picture has no such range of bytes",
    422: "A bad value; `detail` and `field` name it",
    429: "A limit was reached; `Retry-After` says when to try again",
    501: "The server was installed without the package that this needs",
    503: "The server is busy; `Retry-After` says when to try again",
}


def services(connection: HTTPConnection) -> Services:
    found: Services = connection.app.state.services
    return found


async def _services(connection: HTTPConnection) -> Services:
    """`services` as a dependency. FastAPI would call a function that is not async on a thread."""
    return services(connection)


Server = Annotated[Services, Depends(_services)]


async def read(request: Request, kind: type[T], empty: T | None = None) -> T:
    """The request's JSON body as `kind`, or `empty` if there is no body.

    Raises MediaTypeError and the errors of `decode`. A worker checks a large body, so it also
    raises those of `compute`.
    """
    body = await json_body(request)
    if not body and empty is not None:
        return empty
    if len(body) <= _INLINE_BODY:
        return decode(body, kind)
    await compute(request, prices.json(len(body)), tasks.check_json, body)
    return await asyncio.to_thread(shaped, body, kind)


async def json_body(request: Request) -> bytes:
    """The request's body as bytes; raises MediaTypeError if its Content-Type is not JSON."""
    body = await request.body()
    if body:
        _check_media_type(request.headers.get("content-type"))
    return body


def _check_media_type(given: str | None) -> None:
    if given is None:
        return
    kind = given.partition(";")[0].strip().lower()
    if kind != "application/json" and not (
        kind.startswith("application/") and kind.endswith("+json")
    ):
        raise MediaTypeError(
            f"the body's Content-Type is {shorten(kind)}; send application/json",
            field="content-type",
        )


async def compute(request: Request, price: Price, task: Callable[[*Ts], T], *values: *Ts) -> T:
    """The result of `task(*values)`, charged to the client's address.

    The work ends if the client leaves. Raises GoneError then, and the errors of
    `Computing.compute`.
    """
    computing, address = services(request).computing, address_of(request)
    try:
        if computing.is_short(price):
            with contextlib.suppress(EffortError):  # a worker computes it
                return computing.at_once(address, price, task, *values)
        return await attended(request, computing.compute(address, price, task, *values))
    finally:
        note(request.scope, computing.budgets.allowance(address, time.monotonic(), "computing-ms"))


async def attended(request: Request, work: Coroutine[None, None, T]) -> T:
    """The result of `work`. If the client leaves, cancel `work` and raise GoneError.

    The request's body must have been read, because this consumes its further messages.
    """
    doing, leaving = asyncio.create_task(work), asyncio.create_task(left(request.receive))
    try:
        await asyncio.wait((doing, leaving), return_when=asyncio.FIRST_COMPLETED)
        if not doing.done():
            raise GoneError("the client has left")
        return doing.result()
    finally:
        doing.cancel()
        leaving.cancel()
        await asyncio.gather(doing, leaving, return_exceptions=True)


async def left(receive: Receive) -> None:
    """Return when the client has disconnected."""
    while (await receive())["type"] != "http.disconnect":
        pass


def reply(value: object, status: int = 200, headers: Mapping[str, str] | None = None) -> Response:
    """A JSON response; `value` is a Struct, a dict, or JSON that is encoded already."""
    body = value if isinstance(value, bytes) else msgspec.json.encode(value)
    return Response(body, status, headers, "application/json")


def optional_seed(value: object) -> int | None:
    """The parsed seed, or None if the request has no seed; raises SeedError."""
    return None if value is None else parse_seed(value)


def limit_drops(request: Request, server: Services) -> None:
    """Count a drop into a room; raises RateLimitError if this address drops too often."""
    address, now = address_of(request), time.monotonic()
    try:
        server.room_drops.take(address, now, "drops")
    finally:
        note(request.scope, server.room_drops.allowance(address, now, "drops"))


def charge_drops(request: Request, server: Services, drops: int) -> None:
    """Charge this address for `drops` drops, even if it has fewer left: it then has to wait."""
    address, now = address_of(request), time.monotonic()
    server.room_drops.bucket(address, now).charge(drops)
    note(request.scope, server.room_drops.allowance(address, now, "drops"))


def next_page(request: Request, **place: object) -> dict[str, str]:
    """The header `Link` to the next page: this request's address with `place` in its query."""
    query = urllib.parse.urlencode({**request.query_params, **place})
    path = urllib.parse.quote(request.scope["path"])
    return {"link": f'<{path}?{query}>; rel="next"'}


def address_of(connection: HTTPConnection) -> str:
    """The client's address or network, as limits count it."""
    return one_client(connection.client.host) if connection.client else ""


async def resolve_board(request: Request, board: msgspec.Raw) -> Board:
    """The board for this JSON: a preset's name, a digest, or a whole board as an object.

    Raises UnknownBoardError for a name or digest, and the errors of `parse_board` for an object.
    """
    text = bytes(board)
    if text.startswith(b"{"):
        return await parse_board(request, text, tasks.board_of)
    named = msgspec.json.decode(text)
    if isinstance(named, str):
        return services(request).boards.find(named)
    raise BoardError(
        f"board {shorten(named)} is not a name, a digest or a board object", field="board"
    )


def chosen_solver(name: str, dt: float | None, substeps: int | None) -> Solver:
    """The solver of a request; None means that the parameter was not given.

    Raises InvalidValueError if a parameter of the stepped solver is given for another solver, which
    would ignore it; ParameterError; and the errors of `check_step`.
    """
    for field, value in (("dt", dt), ("substeps", substeps)):
        if value is not None and name != "stepped":
            raise InvalidValueError(
                f"{field} {shorten(value)} belongs to the solver 'stepped', not to {shorten(name)}",
                field=field,
            )
    check_step(
        name,
        DEFAULT_DT if dt is None else dt,
        DEFAULT_SUBSTEPS if substeps is None else substeps,
    )
    return make_solver(name, dt, substeps)


def check_step(solver: object, dt: object, substeps: object) -> None:
    """Raise InvalidValueError for steps so short that a drop would take minutes.

    The engine checks everything else about the values.
    """
    if solver != "stepped" or not isinstance(dt, int | float) or not isinstance(substeps, int):
        return
    if 0.0 < dt < SHORTEST_SUBSTEP * substeps:
        raise InvalidValueError(
            f"dt {dt!r} in {substeps} substeps makes steps shorter than {SHORTEST_SUBSTEP:g} s; "
            "use longer steps, or compute the drop with `plinko drop`",
            field="dt",
        )


def check_count(count: int, command: str, field: str = "drops") -> None:
    """Raise InvalidValueError for a count over a request's limit; `command` has no such limit."""
    if not 1 <= count <= prices.MAX_DROPS:
        raise InvalidValueError(
            f"{field} {count} is not from 1 to {prices.MAX_DROPS}; `{command}` takes more",
            field=field,
        )


async def parse_board(request: Request, text: bytes, task: Callable[[bytes], T]) -> T:
    """The result of `task` on a board's JSON, which a worker parses and checks.

    Raises TooLargeError for more pegs and walls than the server accepts; BoardError if the board
    cannot be played; JsonSyntaxError, JsonValueError and InvalidValueError if the text is not a
    JSON object; and the errors of `compute`.
    """
    surfaces = _surfaces(text)
    if surfaces > MAX_SURFACES:
        raise TooLargeError(
            f"the board has {surfaces} pegs and walls; the limit is {MAX_SURFACES}",
            field="board",
        )
    return await compute(request, prices.check(surfaces), task, text)


class _Form(msgspec.Struct):
    """The parts of a board that its price depends on, not yet parsed."""

    pegs: msgspec.Raw = msgspec.Raw(b"[]")
    walls: msgspec.Raw = msgspec.Raw(b"[]")


def _surfaces(text: bytes) -> int:
    """The number of pegs and walls; 0 if this is not a board, which the worker then refuses."""
    try:
        form = msgspec.json.decode(text, type=_Form)
        lists = (part for part in (form.pegs, form.walls) if bytes(part).startswith(b"["))
        return sum(len(msgspec.json.decode(part, type=list[msgspec.Raw])) for part in lists)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return 0


def cache_headers(etag: str) -> dict[str, str]:
    """Headers of a response that never changes with this physics version.

    It is not `immutable`: a release with another physics gives other bits at the same address. So
    a cache asks again after a day; the ETag makes that cheap.
    """
    return {"etag": f'"{etag}"', "cache-control": f"public, max-age={_CACHE_SECONDS}"}


def is_current(request: Request, etag: str) -> bool:
    """Whether the request's If-None-Match has this ETag (weak comparison, RFC 9110)."""
    asked = request.headers.get("if-none-match")
    if asked is None:
        return False
    tags = {tag.strip().removeprefix("W/") for tag in asked.split(",")}
    return "*" in tags or f'"{etag}"' in tags


def not_modified(etag: str) -> Response:
    """304 with the headers that the full response would have."""
    return Response(status_code=304, headers=cache_headers(etag))


_REFERENCE = "#/components/schemas/{name}"
_BODIES: dict[str, type[msgspec.Struct]] = {}  # all bodies that routes have documented, by name

Responses = dict[int | str, dict[str, Any]]
"""FastAPI's form of `responses`, by status."""


def documented(
    success: type[msgspec.Struct] | None,
    *failures: int,
    status: int = 200,
    description: str = "Success",
    media_type: str = "application/json",
) -> Responses:
    """OpenAPI's `responses` of a route: its success and its failures."""
    schema = _reference(success) if success else {"type": "string", "format": "binary"}
    responses: Responses = {
        status: {"description": description, "content": {media_type: {"schema": schema}}}
    }
    return responses | documented_failures(*failures)


def documented_failures(*failures: int) -> Responses:
    """OpenAPI's `responses` for a route's failures."""
    problem = {"application/problem+json": {"schema": _reference(Problem)}}
    responses: Responses = {}
    for failure in failures:
        responses[failure] = {"description": _FAILURES[failure]}
        if failure != 304:
            responses[failure]["content"] = problem
    return responses


def body_of(
    kind: type[msgspec.Struct], example: object, *, required: bool = True
) -> dict[str, object]:
    content = {"application/json": {"schema": _reference(kind), "example": example}}
    return {"requestBody": {"required": required, "content": content}}


OPTIONAL_TOKEN: Final[dict[str, object]] = {"security": [{}]}
"""For `openapi_extra` of an operation whose token is optional: the alternative without one."""


def either(*kinds: type[msgspec.Struct]) -> dict[str, object]:
    """The schema of a body that is one of several kinds."""
    return {"anyOf": [_reference(kind) for kind in kinds]}


def components() -> JsonObject:
    """The JSON Schemas of all bodies that routes have documented, by name."""
    kinds = [kind for _, kind in sorted(_BODIES.items())]
    return msgspec.json.schema_components(kinds, ref_template=_REFERENCE)[1]


def _reference(kind: type[msgspec.Struct]) -> dict[str, str]:
    _BODIES[kind.__name__] = kind
    return {"$ref": _REFERENCE.format(name=kind.__name__)}


def decode(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`.

    Raises JsonSyntaxError, JsonValueError and the errors of `shaped`.
    """
    json_text.parse(body)  # stricter than msgspec: it refuses duplicate keys
    return shaped(body, kind)


def shaped(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`, for a caller that has it checked by `json_text.parse` elsewhere.

    Raises InvalidValueError for a wrong shape, MalformedError for text that is not JSON.
    """
    try:
        return msgspec.json.decode(body, type=kind)
    except msgspec.ValidationError as error:
        raise InvalidValueError(f"body: {error}", field=_field(str(error))) from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedError(f"the body is not JSON: {error}", field="body") from None


_PLACE = re.compile(r" - at `(?:key in )?\$\.?(?P<path>[^`]*)`")
_NAME = re.compile(r"(?:unknown|required) field `(?P<name>[^`]*)`")


def _field(message: str) -> str:
    """The field that a message of msgspec is about; `body` if it is the whole body."""
    place, name = _PLACE.search(message), _NAME.search(message)
    parts = [place["path"] if place else "", name["name"] if name else ""]
    return ".".join(filter(None, parts)) or "body"
