"""Databases to keep a ledger in: SQLite's file, and a real PostgreSQL where it is installed."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.persistence import postgres
from tests.app.persistence.server import POSTGRESQL, SQLITE


@pytest.fixture(scope="session")
def cluster() -> Iterator[postgres.Cluster]:
    binaries = postgres.programs()
    if binaries is None:
        pytest.skip(postgres.MISSING)
    if not postgres.can_run():
        pytest.skip(postgres.NO_USER)
    with postgres.running(binaries) as running:
        yield running


@pytest.fixture(params=[SQLITE, POSTGRESQL])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An empty database's address, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'plinko.db'}"
    cluster: postgres.Cluster = request.getfixturevalue("cluster")
    return cluster.new_database()
