"""Three servers over a real PostgreSQL, which all tests here share. They end with the last."""

from collections.abc import Iterator

import pytest

from tests.app.cluster.servers import Servers, three
from tests.kit.postgres import PostgreSQL


@pytest.fixture(scope="package")
def shared(postgresql: PostgreSQL) -> Iterator[Servers]:
    with Servers(postgresql.new_database(), three()) as servers:
        yield servers


@pytest.fixture
def servers(shared: Servers) -> Servers:
    """The three servers, restarted if the previous test ended some."""
    shared.start()
    return shared
