"""A room's show over REST: what its stage shows beside the board, and how the show looks."""

from typing import Annotated, Final

import msgspec
from fastapi import Request, Response
from msgspec import Meta

from plinko.app.errors import TooLargeError
from plinko.app.persistence.statements import store
from plinko.app.protocol.messages import ShowChanged
from plinko.app.rooms.records import ShowRow
from plinko.app.web.routes.common import Server, body_of, documented, json_body, read, reply
from plinko.app.web.routes.rooms.rooms import own_room
from plinko.app.web.routes.rooms.sessions import RoomToken as Token
from plinko.app.web.routes.table import operations

MAX_SHOW: Final = 1 << 18  # bytes of a show

_PICTURE = r"data:image/(png|jpeg|webp|gif|svg\+xml);base64,[A-Za-z0-9+/]+={0,2}"

Label = Annotated[str, Meta(max_length=40, description="The words next to it.")]
Colour = Annotated[str, Meta(pattern="^#[0-9a-f]{6}$")]
Amount = Annotated[float, Meta(ge=-1e12, le=1e12)]
Face = Annotated[
    str,
    Meta(
        pattern=f"^({_PICTURE}|[^<>&:]{{1,16}})$",
        description="An emoji, or a picture as a `data:` URL.",
        examples=["\U0001f9c0"],
    ),
]
Picture = Annotated[str, Meta(pattern=f"^{_PICTURE}$", description="A picture as a `data:` URL.")]
Font = Annotated[
    str,
    Meta(pattern="^[A-Za-z0-9 -]{1,60}$", description="Of the computer that shows the stage."),
]


class Timer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A countdown; the stage counts on from the time of the request."""

    left: Annotated[float, Meta(ge=0.0, le=1e7, description="Seconds, at the request.")]
    label: Label = ""
    running: bool = True


class Goal(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A bar that fills up."""

    value: Amount
    target: Annotated[float, Meta(gt=0.0, le=1e12)]
    label: Label = ""


class Jackpot(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A number that grows."""

    value: Amount
    label: Label = ""
    unit: Annotated[str, Meta(max_length=8)] = ""


class Looks(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The colours, font and logo of the stage's panels; what is null stays as it is."""

    panel: Colour | None = None
    ink: Colour | None = None
    accent: Colour | None = None
    font: Font | None = None
    logo: Picture | None = None


class Show(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What a stage shows beside the board. `faces` are the pictures of balls, by their name."""

    timer: Timer | None = None
    goals: Annotated[list[Goal], Meta(max_length=4)] = []
    jackpot: Jackpot | None = None
    looks: Looks = Looks()
    faces: Annotated[dict[str, Face], Meta(max_length=100)] = {}


class ShowView(msgspec.Struct, frozen=True):
    """The show of a room."""

    room: str
    age: Annotated[float, Meta(description="Seconds since the show was sent.")]
    show: Show


router = operations("rooms", "/api/v1/rooms")


@router.get("/{room}/show", summary="Get a room's show", responses=documented(ShowView))
async def get_show(room: str, server: Server) -> Response:
    """Timer, goals, jackpot and looks, as the room's owner has sent them last."""
    live = await server.rooms.seek(room)
    persistence = server.rooms.persistence
    row = await persistence.ledger.read(store.show, room=live.id)
    if row is None:
        return reply(ShowView(live.id, 0.0, Show()))
    age = max(0.0, persistence.now() - row.updated)
    return reply(ShowView(live.id, age, msgspec.json.decode(row.data, type=Show)))


@router.put(
    "/{room}/show",
    summary="Set a room's show",
    responses=documented(ShowView),
    openapi_extra=body_of(Show, {"timer": {"left": 3600, "label": "The stream ends in"}}),
    dependencies=[Token],
)
async def set_show(room: str, request: Request, server: Server) -> Response:
    """Replace the whole show; stages fetch it at once. Only for the room's owner.

    It stays with the room, also after a reset or a restart of the server.
    """
    live = await own_room(room, request, server)
    if (size := len(await json_body(request))) > MAX_SHOW:
        raise TooLargeError(f"the show has {size} bytes; the limit is {MAX_SHOW}", field="body")
    show = await read(request, Show)
    persistence = server.rooms.persistence
    data = msgspec.json.encode(show).decode()
    row = ShowRow(live.id, data, persistence.now())
    await persistence.ledger.decided(persistence.ledger.commit(row))
    live.audience.notify(ShowChanged())
    return reply(ShowView(live.id, 0.0, show))
