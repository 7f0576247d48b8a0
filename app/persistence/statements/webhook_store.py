"""Statements of webhook events that are not yet delivered, a row for each event and target.

An event is written in the transaction of its drop or result, so neither exists without the other.
Within a room, a higher number means a later event.
"""

from collections.abc import Sequence
from typing import Final

import msgspec
from sqlalchemy import Connection, delete, insert, select

from plinko.app.persistence.statements import tables
from plinko.app.rooms.records import Heard
from plinko.engine.json_text import JsonObject

ACCEPTED: Final = "accepted"
LANDED: Final = "landed"

Ball = tuple[int, int]
"""The number of a room run, and of a ball in it."""

Labels = Sequence[str | None]
"""The labels of a board's bins, None for a bin without one; empty if no bin has one."""


def tell(
    connection: Connection, targets: Sequence[str], accepted: Sequence[Ball], landed: Sequence[Ball]
) -> None:
    """Queue events of these balls for each target."""
    events = [(ACCEPTED, ball) for ball in accepted] + [(LANDED, ball) for ball in landed]
    rows = [
        {"target": target, "room": room, "ball": ball, "event": event}
        for event, (room, ball) in events
        for target in targets
    ]
    if rows:
        connection.execute(insert(tables.webhooks), rows)


def waiting(connection: Connection, target: str, most: int) -> list[JsonObject]:
    """The oldest `most` events that are not yet delivered to a target, in order.

    Each has the columns of `webhooks` and `drops`, the room's id as `room_id`, and the digest of
    its `board`. A landing also has the columns of `results`, prefixed with `result_`.
    """
    hook, room = tables.webhooks.c, tables.rooms.c
    drop, result = tables.drops.c, tables.results.c
    joined = (
        tables.webhooks.join(tables.rooms, hook.room == room.number)
        .join(tables.drops, (hook.room == drop.room) & (hook.ball == drop.ball))
        .outerjoin(
            tables.results,
            (hook.room == result.room) & (hook.ball == result.ball) & (hook.event == LANDED),
        )
    )
    chosen = (
        select(
            *hook,
            room.id.label("room_id"),
            room.board,
            *(column for column in drop if column.name not in ("room", "ball")),
            *(column.label(f"result_{column.name}") for column in result),
        )
        .select_from(joined)
        .where(hook.target == target)
        .order_by(hook.number)
        .limit(most)
    )
    return [dict(row) for row in connection.execute(chosen).mappings()]


def labels(connection: Connection, board: str) -> Labels:
    form = select(tables.boards.c.json).where(tables.boards.c.digest == board)
    bins = msgspec.json.decode(connection.execute(form).scalar_one())["bins"]
    return tuple(label and label["text"] for label in bins.get("labels", ()))


def heard(connection: Connection, rows: list[Heard]) -> None:
    """Delete delivered events."""
    numbers = [number for row in rows for number in row.numbers]
    connection.execute(delete(tables.webhooks).where(tables.webhooks.c.number.in_(numbers)))
