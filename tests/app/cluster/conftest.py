"""Three servers over a real PostgreSQL, which all tests here share."""

from collections.abc import Iterator

import pytest

from tests.app.cluster.servers import Servers, three
from tests.kit.postgres import PostgreSQL


@pytest.fixture(scope="session")
def shared(postgresql: PostgreSQL) -> Iterator[Servers]:
    with Servers(postgresql.new_database(), three()) as servers:
        yield servers


@pytest.fixture
def servers(shared: Servers) -> Servers:
    """All of them up, whatever the test before has done."""
    shared.start()
    return shared
