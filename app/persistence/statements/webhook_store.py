"""What the targets of webhooks have received: a cursor for each target and table run.

Every drop and landing is an event. The ledger has them all, so nothing else is stored of those that
wait, however long a target is away.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from operator import itemgetter
from typing import Any, Final

import msgspec
from sqlalchemy import Connection, Row, func, or_, select

from plinko.app.persistence.statements import tables
from plinko.app.persistence.statements.store import FACTS
from plinko.app.rooms.independent import DRAW, INDEPENDENT
from plinko.app.rooms.records import Received, RoomRow
from plinko.engine.json_text import JsonObject

ACCEPTED: Final = "accepted"
LANDED: Final = "landed"

Labels = Sequence[str | None]
"""The labels of a board's bins, None for a bin without one; empty if no bin has one."""


@dataclass(frozen=True, slots=True)
class Waiting:
    """The oldest events that a target has not received, and its cursors after them.

    Each event has the columns of `DropRow`, the room's id as `room_id`, the digest of its `board`,
    and the Unix time of its tick in s as `time`. A landing also has the columns of `results`,
    prefixed with `result_`.
    """

    events: list[JsonObject]
    cursors: list[Received]


def begin(connection: Connection, targets: Sequence[str], rows: Sequence[RoomRow]) -> None:
    """Make cursors of these new runs."""
    tables_of = [row.number for row in rows if row.mode in (INDEPENDENT, DRAW)]
    received(connection, [Received(t, run, 0, ()) for run in tables_of for t in targets])


def follow(connection: Connection, target: str) -> list[Received]:
    """The cursors of a target that receives what happens from now on in all open runs."""
    room, drop, result = tables.rooms.c, tables.drops.c, tables.results.c
    cursor = tables.webhook_cursors.c
    known = select(cursor.run).where(cursor.target == target)
    going_on = (
        room.closed.is_(None) & room.mode.in_((INDEPENDENT, DRAW)) & room.number.not_in(known)
    )
    found: list[Received] = []
    for run in connection.execute(select(room.number).where(going_on)).scalars().all():
        last = connection.scalar(select(func.max(drop.ball)).where(drop.room == run))
        flying = (
            select(drop.ball)
            .outerjoin(tables.results)
            .where(drop.room == run, result.ball.is_(None))
        )
        balls = tuple(connection.execute(flying).scalars())
        found.append(Received(target, run, 0 if last is None else last + 1, balls))
    return found


def waiting(connection: Connection, target: str, most: int) -> Waiting:
    """The oldest `most` events that a target has not received, run by run."""
    cursor, room = tables.webhook_cursors.c, tables.rooms.c
    behind = or_(cursor.next < room.checkpoint_drops, cursor.flying != "[]")
    chosen = (
        select(cursor.next, cursor.flying, tables.rooms)
        .join(tables.rooms, room.number == cursor.run)
        .where(cursor.target == target, behind)
        .order_by(cursor.run)
    )
    found = Waiting([], [])
    for row in connection.execute(chosen).all():
        flying = {ball for ball in msgspec.json.decode(row.flying) if ball >= row.pruned}
        events = _events(connection, row, flying, most - len(found.events))
        if not events:
            continue
        new = {event["ball"] for event in events if event["event"] == ACCEPTED}
        landed = {event["ball"] for event in events if event["event"] == LANDED}
        after = max(new, default=row.next - 1) + 1
        found.events.extend(events)
        found.cursors.append(
            Received(target, row.number, after, tuple(sorted((flying | new) - landed)))
        )
        if len(found.events) == most:
            break
    return found


def _events(connection: Connection, run: Row[Any], flying: set[int], most: int) -> list[JsonObject]:
    """The first `most` events of a run after its cursor, in the order of their ticks."""
    drop, result = tables.drops.c, tables.results.c
    columns = (column.label(f"result_{column.name}") for column in result)
    chosen = (
        FACTS.add_columns(*columns)
        .outerjoin(tables.results)
        .where(drop.room == run.number, or_(drop.ball >= run.next, drop.ball.in_(flying)))
        .order_by(drop.ball)
        .limit(most + len(flying))
    )
    events: list[JsonObject] = []
    for row in connection.execute(chosen).mappings():
        fact = {**row, "room_id": run.id, "board": run.board}
        ticks = []
        if row["ball"] >= run.next:
            ticks.append((row["tick"], ACCEPTED))
        if row["result_ball"] is not None:
            ticks.append((row["result_tick"], LANDED))
        for tick, event in ticks:
            time = run.opened + tick / run.tick_rate
            events.append(fact | {"event": event, "at": tick, "time": time})
    return sorted(events, key=itemgetter("at", "event", "ball"))[:most]


def labels(connection: Connection, board: str) -> Labels:
    form = select(tables.boards.c.json).where(tables.boards.c.digest == board)
    bins = msgspec.json.decode(connection.execute(form).scalar_one())["bins"]
    return tuple(label and label["text"] for label in bins.get("labels", ()))


def received(connection: Connection, rows: Sequence[Received]) -> None:
    """Move cursors."""
    if not rows:
        return
    values = [asdict(row) | {"flying": msgspec.json.encode(row.flying).decode()} for row in rows]
    connection.execute(tables.replacing(connection, tables.webhook_cursors), values)
