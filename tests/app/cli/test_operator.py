"""An operator's commands sent to an address without a Plinko server."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from tests.app.cli.conftest import Terminal
from tests.kit.port import free_port


@contextmanager
def a_server_that_answers(status: int, body: bytes) -> Iterator[str]:
    """Run a server that answers every POST like this; gives its address."""

    class Answers(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["content-length"]))
            self.send_response(status)
            self.send_header("content-length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Answers) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


@pytest.mark.parametrize(
    ("status", "body"),
    [(502, b"<h1>Bad Gateway</h1>"), (200, b"<!doctype html>"), (200, b"[]"), (404, b"")],
)
def test_an_answer_of_another_program_is_reported(
    status: int, body: bytes, plinko: Terminal
) -> None:
    with a_server_that_answers(status, body) as url:
        told = plinko.refuses("halt", url)
    why = f"it answered {status} without a JSON object"
    assert told == f"plinko: {url} is not a Plinko server: {why}\n"


def test_what_failed_is_reported(plinko: Terminal) -> None:
    """A refusal with the server's reason, an address without a server, and an invalid address."""
    with a_server_that_answers(403, b'{"detail": "only an operator halts tables"}') as url:
        assert plinko.refuses("halt", url) == f"plinko: {url}: only an operator halts tables\n"
    url = f"http://127.0.0.1:{free_port()}"
    for command in (("rooms", "move", "main", "elsewhere"), ("halt",)):
        assert "Connection refused" in plinko.refuses(*command, url)
    for address in ("ftp://table", "nowhere"):
        said = f"{address!r} is not an address such as http://127.0.0.1:8000"
        assert said in plinko.refuses("halt", address)
