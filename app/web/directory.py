"""The list of open rooms: on this server, on other servers, and those only in the ledger."""

import contextlib
from urllib.parse import quote

import msgspec

from plinko.app.errors import LedgerError
from plinko.app.rooms.records import ListedRoom
from plinko.app.rooms.room import Room
from plinko.app.web.schemas.rooms import RoomSummary
from plinko.app.web.services import Services


async def listed(
    server: Services, *, here: bool, only: str | None = None
) -> dict[str, RoomSummary]:
    """The open rooms by id; with `only` just the room of that id.

    `here` leaves out rooms that this server does not have: other servers ask for this list. Rooms
    of a server that does not answer are missing.
    """
    found: dict[str, RoomSummary] = {}
    if not here:
        with contextlib.suppress(LedgerError):
            stored = await server.rooms.stored.directory()
            found = {each.id: _stored(each) for each in stored if only in (None, each.id)}
        query = "" if only is None else f"?id={quote(only, safe='')}"
        others = (
            []
            if server.others is None
            else await server.others.ask_all(f"/api/v1/rooms{query}", "rooms")
        )
        for listing in others:
            found |= {room.id: room for room in msgspec.convert(listing, list[RoomSummary])}
    mine = [live.room for live in server.rooms.all() if only in (None, live.id)]
    return found | {room.id: _in_memory(server, room) for room in mine}


def _in_memory(server: Services, room: Room) -> RoomSummary:
    return RoomSummary(
        id=room.id,
        board_name=room.origin.name,
        board_digest=room.origin.digest,
        mode=room.mode,
        tick=room.world.tick,
        awake=room.awake,
        balls=room.world.count,
        clients=server.hub.count(room.id),
        drops=room.input_count,
    )


def _stored(room: ListedRoom) -> RoomSummary:
    return RoomSummary(
        id=room.id,
        board_name=room.board_name,
        board_digest=room.board,
        mode=room.mode,
        tick=room.tick,
        awake=room.awake,
        balls=0,
        clients=0,
        drops=room.drops,
    )
