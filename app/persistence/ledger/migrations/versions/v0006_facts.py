"""Add what drops need that are facts, and the history of the ledger: its restores and keys."""

import json

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns and tables, and count the results that exist.

    Keys of release 1.0 go: two callers may have used the same one, so none may find a fact.
    """
    for name in ("rooms", "drops", "inputs"):
        op.drop_index(f"{name}_key", name)
        op.drop_column(name, "key")
    op.create_table(
        "idempotency_keys",
        sa.Column("number", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("id", sa.LargeBinary(length=16), nullable=False),
        sa.Column("request", sa.LargeBinary(length=16), nullable=False),
        sa.Column("run", sa.BigInteger(), nullable=False),
        sa.Column("fact", sa.String(length=64), nullable=False),
        sa.Column("own", sa.Boolean(), nullable=False),
        sa.Column("used", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("number"),
        sa.UniqueConstraint("id"),
    )
    _pack()
    _pack_receipts()
    op.add_column("rooms", sa.Column("rules", sa.Integer(), nullable=False, server_default="1"))
    op.create_table(
        "tallies",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("bin", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("results", sa.BigInteger(), nullable=False),
        sa.ForeignKeyConstraint(["room"], ["rooms.number"]),
        sa.PrimaryKeyConstraint("room", "bin"),
    )
    op.execute(
        "INSERT INTO tallies (room, bin, results) "
        "SELECT room, COALESCE(bin, -1), COUNT(*) FROM results GROUP BY room, COALESCE(bin, -1)"
    )
    great = sa.text("score >= 10")
    op.create_index(
        "results_great", "results", ["room", "tick"], sqlite_where=great, postgresql_where=great
    )
    pruned = sa.Column("pruned", sa.BigInteger(), nullable=False, server_default="0")
    op.add_column("rooms", pruned)
    op.create_table(
        "operator_actions",
        sa.Column("number", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("action", sa.String(length=16), nullable=False),
        sa.Column("subject", sa.String(length=64), nullable=False),
        sa.Column("time", sa.Double(), nullable=False),
        sa.Column("text", sa.Text(), nullable=True),
        sa.Column("until", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("number"),
    )
    op.execute(
        "INSERT INTO operator_actions (action, subject, time) "
        "SELECT 'halt', room, since FROM halts ORDER BY since"
    )
    op.drop_table("halts")
    op.create_table(
        "shows",
        sa.Column("room", sa.String(length=64), nullable=False),
        sa.Column("data", sa.Text(), nullable=False),
        sa.Column("updated", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("room"),
    )
    op.add_column("writers", sa.Column("former", sa.String(length=32), nullable=True))
    op.create_table(
        "restores",
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("log", sa.String(length=32), nullable=False),
        sa.Column("superseded", sa.String(length=32), nullable=True),
        sa.Column("statement", sa.Text(), nullable=False),
        sa.Column("signature", sa.String(length=128), nullable=False),
        sa.PrimaryKeyConstraint("number"),
    )
    op.create_table(
        "keys",
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("name", sa.String(length=32), nullable=False),
        sa.Column("value", sa.String(length=64), nullable=False),
        sa.Column("since", sa.Double(), nullable=False),
        sa.Column("statement", sa.Text(), nullable=True),
        sa.Column("signature", sa.String(length=128), nullable=True),
        sa.Column("former_signature", sa.String(length=128), nullable=True),
        sa.PrimaryKeyConstraint("number"),
    )


def _pack() -> None:
    """Write the rows of drops and results in a shorter form, and webhooks as cursors."""
    bind = op.get_bind()
    if bind.dialect.name == "postgresql":
        seed = (
            f"(d.seed::numeric - CASE WHEN d.seed::numeric < {1 << 63} THEN 0 ELSE {1 << 64} END)"
            "::bigint"
        )
        digest = "decode(r.digest, 'hex')"
    else:
        seed, digest = "signed(d.seed)", "bytes(r.digest)"
        driver = bind.connection.driver_connection
        assert driver is not None
        driver.create_function("signed", 1, lambda text: int(text) - (int(text) >> 63 << 64))
        driver.create_function("bytes", 1, bytes.fromhex)
    _make_cursors(bind)
    op.drop_table("webhooks")
    op.drop_index("drops_who", "drops")
    for name in ("drops", "results"):
        op.rename_table(name, f"former_{name}")
        if bind.dialect.name == "postgresql":
            op.execute(f"ALTER INDEX {name}_pkey RENAME TO former_{name}_pkey")
    op.create_table(
        "players",
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("who", sa.String(length=64), nullable=True),
        sa.PrimaryKeyConstraint("number"),
        sa.UniqueConstraint("who"),
    )
    op.create_table(
        "drops",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("ball", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("tick", sa.BigInteger(), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=False),
        sa.Column("x", sa.Double(), nullable=True),
        sa.Column("stake", sa.BigInteger(), nullable=False),
        sa.Column("player", sa.Integer(), nullable=True),
        sa.Column("aim", sa.Double(), nullable=True),
        sa.Column("practice", sa.Boolean(), nullable=False),
        sa.Column("name", sa.Text(), nullable=True),
        sa.Column("colour", sa.String(length=7), nullable=True),
        sa.CheckConstraint("stake >= 0", name="drops_stake"),
        sa.ForeignKeyConstraint(["room"], ["rooms.number"]),
        sa.ForeignKeyConstraint(["player"], ["players.number"]),
        sa.PrimaryKeyConstraint("room", "ball"),
        sqlite_with_rowid=False,
    )
    op.create_table(
        "results",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("ball", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("tick", sa.BigInteger(), nullable=False),
        sa.Column("bin", sa.Integer(), nullable=True),
        sa.Column("score", sa.Double(), nullable=False),
        sa.Column("t", sa.Double(), nullable=False),
        sa.Column("x_end", sa.Double(), nullable=False),
        sa.Column("digest", sa.LargeBinary(), nullable=False),
        sa.Column("unsettled", sa.Text(), nullable=True),
        sa.Column("payout", sa.BigInteger(), nullable=False),
        sa.CheckConstraint("payout >= 0", name="results_payout"),
        sa.ForeignKeyConstraint(["room", "ball"], ["drops.room", "drops.ball"]),
        sa.PrimaryKeyConstraint("room", "ball"),
        sqlite_with_rowid=False,
    )
    op.execute(
        "INSERT INTO players (who) SELECT DISTINCT who FROM former_drops WHERE who IS NOT NULL"
    )
    op.execute(
        f"INSERT INTO drops SELECT d.room, d.ball, d.tick, {seed}, d.x, d.stake, p.number, d.aim, "
        "d.practice, d.name, d.colour FROM former_drops d LEFT JOIN players p ON p.who = d.who "
        "ORDER BY d.room, d.ball"
    )
    op.execute(
        f"INSERT INTO results SELECT r.room, r.ball, r.tick, r.bin, r.score, r.t, r.x_end, "
        f"{digest}, r.unsettled, r.payout FROM former_results r ORDER BY r.room, r.ball"
    )
    op.create_index(
        "drops_player",
        "drops",
        ["player"],
        sqlite_where=sa.text("player IS NOT NULL"),
        postgresql_where=sa.text("player IS NOT NULL"),
    )
    op.execute(
        "UPDATE rooms SET checkpoint_drops = "
        "(SELECT COUNT(*) FROM drops WHERE drops.room = rooms.number) "
        "WHERE EXISTS (SELECT 1 FROM drops WHERE drops.room = rooms.number)"
    )
    for name in ("former_results", "former_drops"):
        op.drop_table(name)


def _pack_receipts() -> None:
    """Leave out of receipts what their drops and sessions have; hashes and signatures as bytes."""
    if op.get_bind().dialect.name == "postgresql":
        op.add_column("receipts", sa.Column("time", sa.BigInteger(), nullable=True))
        op.execute("UPDATE receipts SET time = (receipt::json->>'time')::bigint")
        op.alter_column("receipts", "time", nullable=False)
        op.drop_column("receipts", "receipt")
        for table, name in (("receipts", "root"), ("receipts", "signature"), ("log_nodes", "hash")):
            op.execute(f"ALTER TABLE {table} ALTER {name} TYPE bytea USING decode({name}, 'hex')")
        return
    for name in ("receipts", "log_nodes"):
        op.rename_table(name, f"former_{name}")
    op.create_table(
        "receipts",
        sa.Column("leaf", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("session", sa.String(length=64), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("room", sa.BigInteger(), nullable=False),
        sa.Column("ball", sa.BigInteger(), nullable=False),
        sa.Column("time", sa.BigInteger(), nullable=False),
        sa.Column("root", sa.LargeBinary(), nullable=False),
        sa.Column("signature", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(["session"], ["fair_sessions.id"]),
        sa.PrimaryKeyConstraint("leaf"),
        sa.UniqueConstraint("room", "ball", name="receipts_ball"),
        sa.UniqueConstraint("session", "number", name="receipts_number"),
        sqlite_with_rowid=False,
    )
    op.create_table(
        "log_nodes",
        sa.Column("level", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("number", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("hash", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("level", "number"),
        sqlite_with_rowid=False,
    )
    op.execute(
        "INSERT INTO receipts SELECT leaf, session, number, room, ball, "
        "json_extract(receipt, '$.time'), bytes(root), bytes(signature) FROM former_receipts "
        "ORDER BY leaf"
    )
    op.execute(
        "INSERT INTO log_nodes SELECT level, number, bytes(hash) FROM former_log_nodes "
        "ORDER BY level, number"
    )
    for name in ("receipts", "log_nodes"):
        op.drop_table(f"former_{name}")


def _make_cursors(bind: sa.Connection) -> None:
    """Make a cursor of the events that wait in each run for each target."""
    cursors = op.create_table(
        "webhook_cursors",
        sa.Column("target", sa.Text(), nullable=False),
        sa.Column("run", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("next", sa.BigInteger(), nullable=False),
        sa.Column("flying", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("target", "run"),
    )
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
        bind.execute(sa.insert(cursors).values(values))
