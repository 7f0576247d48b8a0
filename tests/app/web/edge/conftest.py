"""Shared by the tests of the edge: every request of a test ends with it."""

from collections.abc import Iterator

import pytest

from tests.app.web.edge import lines


@pytest.fixture(autouse=True)
def finished() -> Iterator[None]:
    """End the waiting requests of a test, so that none ends during another test."""
    yield
    lines.finish()
