"""Add what drops need that are facts, and the history of the ledger: its restores and keys.

The tables are made as `tables` declares them. If that changes after release 2.0, this step must get
declarations of its own.
"""

import json
from typing import Final

import sqlalchemy as sa
from alembic import op

from plinko.app.persistence.statements import tables

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

_PACKED: Final = ("results", "receipts", "log_nodes", "drops")
"""Tables whose rows get a shorter form; those that refer to another one come before it."""


def upgrade() -> None:
    """Add columns and tables, rewrite the packed tables, and count the results that exist.

    Keys of release 1.0 go: two callers may have used the same one, so none may find a fact.
    """
    bind = op.get_bind()
    for name in ("rooms", "drops", "inputs"):
        op.drop_index(f"{name}_key", name)
        op.drop_column(name, "key")
    op.drop_index("drops_who", "drops")
    op.add_column("rooms", sa.Column("rules", sa.Integer(), nullable=False, server_default="1"))
    pruned = sa.Column("pruned", sa.BigInteger(), nullable=False, server_default="0")
    op.add_column("rooms", pruned)
    op.add_column("writers", sa.Column("former", sa.String(length=32), nullable=True))
    for name in _PACKED:
        _set_aside(bind, name)
    tables.metadata.create_all(bind)
    _copy(bind)
    op.execute(
        "UPDATE rooms SET checkpoint_drops = "
        "(SELECT COUNT(*) FROM drops WHERE drops.room = rooms.number) "
        "WHERE EXISTS (SELECT 1 FROM drops WHERE drops.room = rooms.number)"
    )
    op.execute(
        "INSERT INTO tallies (room, bin, results) "
        "SELECT room, COALESCE(bin, -1), COUNT(*) FROM results GROUP BY room, COALESCE(bin, -1)"
    )
    op.execute(
        "INSERT INTO operator_actions (action, subject, time) "
        "SELECT 'halt', room, since FROM halts ORDER BY since"
    )
    _make_cursors(bind)
    for name in ("halts", "webhooks", *(f"former_{each}" for each in _PACKED)):
        op.drop_table(name)


def _set_aside(bind: sa.Connection, name: str) -> None:
    """Rename a table, and its indexes where their names are not those of the table."""
    found = sa.inspect(bind)
    indexes = [found.get_pk_constraint(name)["name"]]
    indexes += [each["name"] for each in found.get_indexes(name)]
    op.rename_table(name, f"former_{name}")
    if bind.dialect.name == "postgresql":
        for index in indexes:
            op.execute(f"ALTER INDEX {index} RENAME TO former_{index}")


def _copy(bind: sa.Connection) -> None:
    """Fill the packed tables: seeds as signed integers, hashes and signatures as bytes."""
    if bind.dialect.name == "postgresql":
        seed = (
            f"(d.seed::numeric - CASE WHEN d.seed::numeric < {1 << 63} THEN 0 ELSE {1 << 64} END)"
            "::bigint"
        )
        packed, time = "decode({}, 'hex')", "(receipt::json->>'time')::bigint"
    else:
        seed, packed, time = "signed(d.seed)", "bytes({})", "json_extract(receipt, '$.time')"
        driver = bind.connection.driver_connection
        assert driver is not None
        driver.create_function("signed", 1, lambda text: int(text) - (int(text) >> 63 << 64))
        driver.create_function("bytes", 1, bytes.fromhex)
    digest, root, signature, hashed = map(packed.format, ("digest", "root", "signature", "hash"))
    op.execute(
        "INSERT INTO players (who) SELECT DISTINCT who FROM former_drops WHERE who IS NOT NULL"
    )
    op.execute(
        f"INSERT INTO drops SELECT d.room, d.ball, d.tick, {seed}, d.x, d.stake, p.number, d.aim, "
        "d.practice, d.name, d.colour FROM former_drops d LEFT JOIN players p ON p.who = d.who "
        "ORDER BY d.room, d.ball"
    )
    op.execute(
        f"INSERT INTO results SELECT room, ball, tick, bin, score, t, x_end, {digest}, unsettled, "
        "payout FROM former_results ORDER BY room, ball"
    )
    # A receipt's other fields are those of its drop and its session.
    op.execute(
        f"INSERT INTO receipts SELECT leaf, session, number, room, ball, {time}, {root}, "
        f"{signature} FROM former_receipts ORDER BY leaf"
    )
    op.execute(
        f"INSERT INTO log_nodes SELECT level, number, {hashed} FROM former_log_nodes "
        "ORDER BY level, number"
    )


def _make_cursors(bind: sa.Connection) -> None:
    """Make a cursor of the events that wait in each run for each target."""
    waiting: dict[tuple[str, int], dict[str, list[int]]] = {}
    found = bind.execute(sa.text("SELECT target, room, ball, event FROM webhooks ORDER BY ball"))
    for target, run, ball, event in found:
        events = waiting.setdefault((target, run), {"accepted": [], "landed": []})
        events[event].append(ball)
    for (target, run), events in waiting.items():
        drops = sa.text("SELECT COUNT(*) FROM drops WHERE room = :run")
        first = min(events["accepted"], default=bind.scalar(drops, {"run": run}))
        flying = sa.text(
            "SELECT d.ball FROM drops d LEFT JOIN results r ON r.room = d.room AND r.ball = d.ball "
            "WHERE d.room = :run AND d.ball < :first AND r.ball IS NULL"
        )
        balls = bind.execute(flying, {"run": run, "first": first}).scalars()
        both = sorted({*balls, *(ball for ball in events["landed"] if ball < first)})
        values = {"target": target, "run": run, "next": first, "flying": json.dumps(both)}
        bind.execute(sa.insert(tables.webhook_cursors).values(values))
