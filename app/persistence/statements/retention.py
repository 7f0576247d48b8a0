"""Deletes what is older than the ledger keeps, in steps so short that nobody waits for them.

A landed drop goes with its result and its receipt, unless its fair session is open. What proves
others stays: the log of receipts has a hash of each, and the sums have counted the drop. An open
run keeps its last drop, because the next one continues its number and tick.
"""

import math
from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import Connection, Row, delete, func, select, tuple_, update

from plinko.app.persistence.statements import tables
from plinko.app.rooms.records import RULES, Erase, Prune

KEY_SECONDS: Final = 7 * 86_400.0
"""s for which an idempotency key stays."""

_ROWS: Final = 100  # of one step


def runs(connection: Connection, before: float) -> list[int]:
    """The numbers of the runs that began before this Unix time, in s."""
    room = tables.rooms.c
    chosen = select(room.number).where(room.opened < before).order_by(room.number)
    return list(connection.execute(chosen).scalars())


def prune(connection: Connection, steps: Sequence[Prune]) -> None:
    """Do these steps; sets in each what was deleted, and where the next step begins."""
    for step in steps:
        step.rooms = step.drops = step.inputs = 0
        step.next = None
        if step.run is None:
            _prune_keys(connection, step)
            continue
        chosen = select(tables.rooms).where(tables.rooms.c.number == step.run)
        run = connection.execute(chosen).first()
        if run is not None:
            _prune_run(connection, step, run)


def _prune_keys(connection: Connection, step: Prune) -> None:
    row = tables.idempotency_keys.c
    oldest = select(row.number, row.used).order_by(row.number).limit(_ROWS)
    old = [each.number for each in connection.execute(oldest) if each.used < step.before]
    if old:
        connection.execute(delete(tables.idempotency_keys).where(row.number <= old[-1]))
    step.next = 0 if len(old) == _ROWS else None


def _prune_run(connection: Connection, step: Prune, run: Row[Any]) -> None:
    over = run.closed is not None and run.closed < step.before
    _prune_drops(connection, step, run, math.inf if over else _tick(run, step.before))
    if not over or step.next is not None:
        return
    row, last = tables.inputs.c, step.first + _ROWS
    old = delete(tables.inputs).where(row.room == run.number, row.number < last)
    step.inputs = connection.execute(old).rowcount
    if step.inputs == _ROWS:
        step.next = last
        return
    drop = tables.drops.c
    if connection.execute(select(drop.ball).where(drop.room == run.number).limit(1)).first():
        return  # of open sessions
    for column in (
        tables.queues.c.room,
        tables.tallies.c.room,
        tables.webhook_cursors.c.run,
        tables.rooms.c.number,
    ):
        connection.execute(delete(column.table).where(column == run.number))
    step.rooms = 1
    # The show, and a lease that nobody has, of a room that is gone.
    lease, ids = tables.leases.c, select(tables.rooms.c.id)
    unused = (lease.room == run.id) & (lease.holder == "") & lease.room.not_in(ids)
    connection.execute(delete(tables.leases).where(unused))
    show = tables.shows.c.room
    connection.execute(delete(tables.shows).where((show == run.id) & show.not_in(ids)))


def _tick(run: Row[Any], time: float) -> float:
    """The tick of an open table at a Unix time, in s; before all ticks if it has no such clock."""
    return (time - run.opened) * run.tick_rate if run.rules == RULES else -math.inf


def _prune_drops(connection: Connection, step: Prune, run: Row[Any], end: float) -> None:
    """Delete landed drops that started before tick `end`, from number `first` of the step on."""
    drop, result = tables.drops.c, tables.results.c
    receipt, session = tables.receipts, tables.fair_sessions
    last = select(func.max(drop.ball)).where(drop.room == run.number)
    keep = -1 if run.closed is not None else connection.scalar(last)
    chosen = (
        select(drop.ball, drop.tick, result.ball.label("landed"), receipt.c.leaf, session.c.end)
        .outerjoin(tables.results)
        .outerjoin(receipt, (receipt.c.room == drop.room) & (receipt.c.ball == drop.ball))
        .outerjoin(session, session.c.id == receipt.c.session)
        .where(drop.room == run.number, drop.ball >= step.first)
        .order_by(drop.ball)
        .limit(_ROWS)
    )
    old: list[int] = []
    kept: list[int] = []  # of open sessions
    reached = step.first
    rows = connection.execute(chosen).all()
    for row in rows:
        falls = row.landed is None and end < math.inf  # a run that is over has no balls
        if row.tick >= end or falls or row.ball == keep:
            break
        (old if row.leaf is None or row.end is not None else kept).append(row.ball)
        reached = row.ball + 1
    else:
        step.next = reached if len(rows) == _ROWS else None
    if not old:
        return
    for table in (tables.results, tables.receipts, tables.drops):
        ball = table.c.ball
        gone = (table.c.room == run.number) & ball.between(old[0], old[-1]) & ball.not_in(kept)
        connection.execute(delete(table).where(gone))
    step.drops = len(old)
    if reached > run.pruned:
        values = {"pruned": reached}
        connection.execute(
            update(tables.rooms).where(tables.rooms.c.number == run.number).values(values)
        )


def erase(connection: Connection, steps: Sequence[Erase]) -> None:
    """Take players' marks and tags from some rows; sets in each step how many it has changed.

    No digest or receipt covers them, except the digest of a log that is sent with marks.
    """
    drop, player, row = tables.drops.c, tables.players, tables.inputs
    for step in steps:
        marked = update(row).where(row.c.who == step.who).values(who=None)
        step.rows = connection.execute(marked).rowcount
        number = connection.scalar(select(player.c.number).where(player.c.who == step.who))
        if number is None:
            continue
        chosen = select(drop.room, drop.ball).where(drop.player == number).limit(_ROWS)
        rows = [(found.room, found.ball) for found in connection.execute(chosen)]
        if rows:
            named = update(tables.drops).where(tuple_(drop.room, drop.ball).in_(rows))
            connection.execute(named.values(player=None, name=None, colour=None))
        else:
            connection.execute(delete(player).where(player.c.number == number))
        step.rows += len(rows)
