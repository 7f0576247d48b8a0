"""Fixtures of the app's tests: the load generator runs on the same server."""

from tests.app.conftest import server, what_starts_read

__all__ = ["server", "what_starts_read"]
