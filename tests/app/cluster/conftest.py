"""Three servers over a real PostgreSQL, which all tests here share."""

from collections.abc import Iterator

import pytest

from tests.app.cluster import servers as processes
from tests.app.cluster.servers import Servers
from tests.app.persistence import postgres


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
    with processes.running(postgresql.new_database()) as servers:
        yield servers


@pytest.fixture
def servers(shared: Servers) -> Servers:
    """All of them up, whatever the test before has done."""
    shared.start()
    return shared
