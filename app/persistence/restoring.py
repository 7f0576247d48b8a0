"""Continues with a restored backup: ends what the lost time has made unfair, and signs that.

Players have seen the seeds of drops that the backup lacks, and perhaps the secret of a session that
is open in it. So all open sessions end, and their secrets are revealed. The former log of receipts
may have had more leaves than the backup, so a new log begins. Keys of requests are forgotten. All
of this is one transaction, which also begins the epoch that the next start expects.
"""

import secrets
from dataclasses import dataclass

from sqlalchemy import Connection

from plinko.app.fairness.signing import Signer
from plinko.app.fairness.statements import Closing, RestoreStatement
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import fair_store, history, keys
from plinko.app.rooms.canonical import canonical
from plinko.engine import merkle


@dataclass(frozen=True, slots=True)
class Restored:
    """What a restore did: its signed statement. difference: why a start refused the ledger."""

    difference: str | None
    statement: RestoreStatement
    signature: str


def restore(database: Database, signer: Signer, now: float) -> Restored:
    """Make a server start with the ledger as it is; `now` is Unix time in s.

    The database is open, without a check and without an epoch.
    """
    difference, place = database.difference(), database.place()
    done: list[Restored] = []

    def change(connection: Connection) -> None:
        statement = _statement(connection, signer, now, None if place is None else place.log)
        values = statement.to_dict()
        signature = signer.sign(values).hex()
        row = history.RestoreRow(
            number=history.log_number(connection) + 1,
            log=statement.log,
            superseded=statement.superseded,
            statement=canonical(values).decode(),
            signature=signature,
        )
        history.add_restore(connection, row)
        keys.forget(connection)
        done.append(Restored(difference, statement, signature))

    database.enter(change)
    return done[0]


def _statement(
    connection: Connection, signer: Signer, now: float, lost: str | None
) -> RestoreStatement:
    log, number = secrets.token_hex(16), history.log_number(connection)
    former = history.log_id(connection)
    _, size, nodes = fair_store.grown(connection, since=0)
    known = {former, *history.former_logs(connection)}
    ended = end_sessions(connection, signer, now, void=log)
    return RestoreStatement(
        log=log,
        former=former if number else None,
        size=size,
        root=merkle.root(size, lambda level, at: nodes[level, at]).hex(),
        superseded=None if lost is None or lost in known else lost,
        sessions=ended,
        time=int(now * 1000.0),
    )


def end_sessions(
    connection: Connection, signer: Signer, now: float, *, void: str | None = None
) -> int:
    """End all open sessions, and reveal their secrets; returns their number."""
    found = fair_store.unended(connection)
    for session, server_seed, drops in found:
        end = Closing(session, drops, server_seed, int(now * 1000.0), void).to_dict()
        fair_store.end(connection, session, canonical(end).decode(), signer.sign(end).hex())
    return len(found)
