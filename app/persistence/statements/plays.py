"""The history of a player's drops, or of a room's, latest first."""

from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Select, and_, or_, select, text

from plinko.app.persistence.statements import tables


@dataclass(frozen=True, slots=True)
class Play:
    """A drop with its result and receipt; `place` is its room run and its number there.

    seed is decimal; x and aim in m, if the player chose one; stake and payout in minor units. time:
    when its session's receipt was signed, Unix time in ms. `digest` and all fields after it are
    None while the ball is falling.
    """

    place: tuple[int, int]
    room: str
    board: str
    board_digest: str
    physics_version: int
    seed: str
    x: float | None
    aim: float | None
    stake: int
    practice: bool
    name: str | None
    colour: str | None
    session: str | None
    session_drop: int | None
    time: int | None
    digest: str | None
    bin: int | None
    score: float | None
    payout: int | None
    duration: float | None
    x_end: float | None
    unsettled: str | None


def plays(
    connection: Connection, *, of: str | int, before: tuple[int, int] | None, limit: int
) -> list[Play]:
    """At most `limit` drops of a player's mark or of a room run, latest first.

    `of` is the mark or the run's number. `before` is a place: only drops before it are listed. The
    order is that of the runs' numbers, and within a run that of its drops.
    """
    drop = tables.drops.c
    chosen = (
        _plays()
        .where(tables.players.c.who == of if isinstance(of, str) else drop.room == of)
        .order_by(drop.room.desc(), drop.ball.desc())
        .limit(limit)
    )
    if before is not None:
        number, ball = before
        chosen = chosen.where(or_(drop.room < number, and_(drop.room == number, drop.ball < ball)))
    return [_play(row) for row in connection.execute(chosen)]


def best_plays(connection: Connection, *, run: int, since: int, limit: int) -> list[Play]:
    """At most `limit` staked drops of a room run that paid most, the best first.

    Only those that landed after the tick `since`, with a multiplier of at least 10.
    """
    result = tables.results.c
    great = and_(text(f"results.{tables.GREAT}"), result.room == run, result.tick > since)
    paid = result.payout > 0
    chosen = _plays().where(great, paid).order_by(result.payout.desc(), result.ball).limit(limit)
    return [_play(row) for row in connection.execute(chosen)]


def _plays() -> Select[Any]:
    """What a Play has, of all drops."""
    drop, room, board = tables.drops.c, tables.rooms.c, tables.boards.c
    result, receipt = tables.results.c, tables.receipts.c
    return (
        select(
            drop.room.label("place_room"), drop.ball, room.id, board.name, room.board,
            room.physics_version, drop.seed, drop.x, drop.aim, drop.stake, drop.practice,
            drop.name, drop.colour,
            receipt.session, receipt.number, receipt.time, result.digest, result.bin,
            result.score, result.payout, result.t, result.x_end, result.unsettled,
        )
        .select_from(
            tables.drops.join(tables.rooms, room.number == drop.room)
            .join(tables.boards, board.digest == room.board)
            .outerjoin(tables.players)
            .outerjoin(
                tables.results, and_(result.room == drop.room, result.ball == drop.ball)
            )
            .outerjoin(
                tables.receipts, and_(receipt.room == drop.room, receipt.ball == drop.ball)
            )
        )
    )  # fmt: skip


def _play(row: Any) -> Play:
    number, ball, *fields = row
    fields[4] = str(fields[4])
    return Play((number, ball), *fields)
