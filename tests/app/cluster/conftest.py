"""Three servers over a real Redis and a real PostgreSQL, which all tests here share."""

from collections.abc import Iterator

import pytest

from tests.app.cluster import servers as processes
from tests.app.cluster.servers import Servers
from tests.app.persistence import postgres
from tests.app.relay import redis as tests_redis


@pytest.fixture(scope="session")
def postgresql() -> Iterator[postgres.Cluster]:
    binaries = postgres.programs()
    if binaries is None:
        pytest.skip(postgres.MISSING)
    if not postgres.can_run():
        pytest.skip(postgres.NO_USER)
    with postgres.running(binaries) as running:
        yield running


@pytest.fixture(scope="session")
def shared(postgresql: postgres.Cluster) -> Iterator[Servers]:
    if tests_redis.PROGRAM is None:
        pytest.skip(tests_redis.MISSING)
    with (
        tests_redis.running() as redis,
        processes.running(redis, postgresql.new_database()) as servers,
    ):
        yield servers


@pytest.fixture
def servers(shared: Servers) -> Servers:
    """All of them up, whatever the test before has done."""
    shared.start()
    return shared
