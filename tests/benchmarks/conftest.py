"""The load is tried on a server as the app's own tests have it."""

from tests.app.conftest import files_read_once, server

__all__ = ["files_read_once", "server"]
