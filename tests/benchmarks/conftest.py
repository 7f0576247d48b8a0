"""The load is tried on a server as the app's own tests have it."""

from tests.app.conftest import server, what_starts_read

__all__ = ["server", "what_starts_read"]
