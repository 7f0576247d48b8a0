"""What tests of the edge have in common."""

from collections.abc import Iterator

import pytest

from tests.app.web.edge import lines


@pytest.fixture(autouse=True)
def finished() -> Iterator[None]:
    """No request is left waiting, to be ended at some other time."""
    yield
    lines.finish()
