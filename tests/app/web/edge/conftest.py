"""Ends every waiting request at the end of each test of the edge."""

from collections.abc import Iterator

import pytest

from tests.app.web.edge import lines


@pytest.fixture(autouse=True)
def finished() -> Iterator[None]:
    yield
    lines.finish()
