"""Servers of this release and of a later one over one PostgreSQL, during an upgrade."""

import dataclasses
import signal
import subprocess

import psycopg
import pytest

from plinko.app.persistence.ledger.database import HEAD
from tests.app.cluster.servers import Servers, member
from tests.app.cluster.test_servers import drop_at, move, new_room, same_as_alone, until_still
from tests.app.conftest import QUICK
from tests.kit.postgres import PostgreSQL
from tests.kit.process import SERVE, ServerProcess

pytestmark = pytest.mark.postgresql

_LATER = """
import plinko.engine
plinko.engine.__version__ = "99.0.0"
from plinko.app.persistence.ledger import database
"""
_STEP = """
import sqlalchemy as sa
database.HEAD = "0099"
def upgrade(connection, revision):
    connection.execute(sa.text("ALTER TABLE drops ADD COLUMN later integer"))
    connection.execute(sa.text("UPDATE alembic_version SET version_num = '0099'"))
database._upgrade = upgrade
"""
_RUN = """
import runpy
runpy.run_module("plinko", run_name="__main__")
"""


def this(name: str) -> ServerProcess:
    one = member(name)
    one.options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return one


def later(name: str, *, changes_tables: bool) -> ServerProcess:
    """A server of a later release, which perhaps changes the tables."""
    script = _LATER + (_STEP if changes_tables else "") + _RUN
    return dataclasses.replace(this(name), program=("-c", script, *SERVE))


def refused(server: ServerProcess) -> tuple[int, str]:
    """Start a server that cannot start; returns its exit code and last line."""
    server.begin()
    code = server.ended()
    return code, server.said[1].strip().splitlines()[-1]


def holds(one: ServerProcess, room: str, seeds: list[int]) -> None:
    """The room has these drops in this order, each with the engine's result."""
    until_still(one, room)
    log = one.get(f"/api/v1/rooms/{room}/log").json()["drops"]
    assert [int(each["seed"]) for each in log] == seeds
    assert all(same_as_alone(each["result"], int(each["seed"]), QUICK) for each in log)


def test_releases_with_the_same_tables_are_one_cluster_and_others_wait(
    postgresql: PostgreSQL,
) -> None:
    url = postgresql.new_database()
    old, new = this("old"), later("new", changes_tables=False)
    changing = later("changing", changes_tables=True)
    with Servers(url, (old, new)):
        versions = {one.get("/openapi.json").json()["info"]["version"] for one in (old, new)}
        assert len(versions) == 2
        room = new_room(old, QUICK)
        for seed, one in enumerate((old, new)):
            assert drop_at(one, room, seed)["ball"] == seed
        assert move(room, new, old).status_code == 200
        assert drop_at(old, room, 2)["ball"] == 2
        assert move(room, old, new).status_code == 200
        changing.ledger = url
        code, line = refused(changing)
        assert code == 1, "systemd tries again"
        assert f"step {HEAD!r} to '0099': stop all servers of the earlier release" in line
        assert drop_at(new, room, 3)["ball"] == 3
        assert old.end(signal.SIGTERM) == 0
        assert drop_at(new, room, 4)["ball"] == 4
        holds(new, room, [0, 1, 2, 3, 4])
        assert new.end(signal.SIGTERM) == 0
    with Servers(url, (changing,)):
        assert drop_at(changing, room, 5)["ball"] == 5
        code, line = refused(old)
        assert code == 2, "systemd does not try again"
        assert f"step '0099', but this release only knows the steps up to {HEAD!r}" in line
        holds(changing, room, [0, 1, 2, 3, 4, 5])
        # The tables may change in the moment in which a server has lost its connection.
        with psycopg.connect(url) as other:
            other.execute(
                "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
                "WHERE application_name = 'plinko' AND datname = current_database()"
            )
            other.execute("UPDATE alembic_version SET version_num = '0100'")
        assert changing.ended() == 0
        assert (
            "the server stops: in its ledger, its tables are at migration step" in changing.said[1]
        )
