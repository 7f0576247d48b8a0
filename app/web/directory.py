"""The list of open rooms: on this server, on other servers, and those only in the ledger."""

import contextlib
from urllib.parse import quote

import msgspec

from plinko.app.errors import LedgerError
from plinko.app.live.live_room import LiveRoom
from plinko.app.rooms.records import Parked
from plinko.app.rooms.room import Room
from plinko.app.web.schemas.rooms import RoomSummary
from plinko.app.web.services import Services
from plinko.app.web.shared import Others


async def listed(
    server: Services, *, here: bool, only: str | None = None
) -> dict[str, RoomSummary]:
    """The open rooms by id; with `only` just the room of that id.

    `here` leaves out other servers' rooms: the other servers ask for this list.
    """

    def wanted(room: Parked | LiveRoom) -> bool:
        return only is None or room.id == only

    rooms = server.rooms
    found = {room.id: _parked(room) for room in filter(wanted, rooms.parked())}
    if server.others is not None and not here:
        found |= await _elsewhere(server, server.others, only)
    return found | {each.id: _in_memory(server, each.room) for each in filter(wanted, rooms.all())}


async def _elsewhere(server: Services, others: Others, only: str | None) -> dict[str, RoomSummary]:
    """Rooms that this server does not have; those of a server that does not answer are missing."""
    found: dict[str, RoomSummary] = {}
    with contextlib.suppress(LedgerError):
        for each in await server.rooms.shared.directory():
            if only in (None, each.id):
                found[each.id] = _parked(each)
    query = "" if only is None else f"?id={quote(only, safe='')}"
    for listing in await others.ask_all(f"/api/v1/rooms{query}", "rooms"):
        listed_there = msgspec.convert(listing, list[RoomSummary])
        found |= {room.id: room for room in listed_there}
    return found


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
        drops=room.taken,
    )


def _parked(room: Parked) -> RoomSummary:
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
