"""The history of a player's drops, or of a room's, latest first."""

from collections.abc import Sequence
from typing import Any

from sqlalchemy import Connection, Row, Select, and_, or_, select, text

from plinko.app.persistence.statements import tables


def plays(
    connection: Connection, *, of: str | int, before: tuple[int, int] | None, limit: int
) -> Sequence[Row[Any]]:
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
    return connection.execute(chosen).all()


def best_plays(connection: Connection, *, run: int, since: int, limit: int) -> Sequence[Row[Any]]:
    """At most `limit` staked drops of a room run that paid most, the best first.

    Only those that landed after the tick `since`, with a multiplier of at least 10.
    """
    result = tables.results.c
    great = and_(text(f"results.{tables.GREAT}"), result.room == run, result.tick > since)
    paid = result.payout > 0
    chosen = _plays().where(great, paid).order_by(result.payout.desc(), result.ball).limit(limit)
    return connection.execute(chosen).all()


def _plays() -> Select[Any]:
    """The columns of a play: a drop with its result and its receipt, of all drops.

    `run` and `ball` are its place. The columns from `digest` on are NULL while the ball falls.
    """
    drop, room, board = tables.drops.c, tables.rooms.c, tables.boards.c
    result, receipt = tables.results.c, tables.receipts.c
    return (
        select(
            drop.room.label("run"), drop.ball, room.id.label("room"), board.name.label("board"),
            room.board.label("board_digest"), room.physics_version,
            drop.seed, drop.x, drop.aim, drop.stake, drop.practice, drop.name, drop.colour,
            receipt.session, receipt.number.label("session_drop"), receipt.time,
            result.digest, result.bin, result.score, result.payout, result.t.label("duration"),
            result.x_end, result.unsettled,
        )
        .select_from(
            tables.drops.join(tables.rooms)
            .join(tables.boards)
            .outerjoin(tables.players)
            .outerjoin(tables.results)
            .outerjoin(
                tables.receipts, and_(receipt.room == drop.room, receipt.ball == drop.ball)
            )
        )
    )  # fmt: skip
