"""An operator's commands sent to an address without a Plinko server."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from plinko.app.cli import main
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
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


Said = pytest.CaptureFixture[str]


@pytest.mark.parametrize(
    ("status", "body"),
    [(502, b"<h1>Bad Gateway</h1>"), (200, b"<!doctype html>"), (200, b"[]"), (404, b"")],
)
def test_an_answer_of_another_program_is_reported(status: int, body: bytes, capsys: Said) -> None:
    with a_server_that_answers(status, body) as url:
        assert main(["halt", url]) == 2
    told = capsys.readouterr().err
    why = f"it answered {status} without a JSON object"
    assert told == f"plinko: {url} is not a Plinko server: {why}\n"


def test_a_refusal_is_reported_with_the_server_s_reason(capsys: Said) -> None:
    with a_server_that_answers(403, b'{"detail": "only an operator halts tables"}') as url:
        assert main(["halt", url]) == 2
    assert capsys.readouterr().err == f"plinko: {url}: only an operator halts tables\n"


def test_an_address_without_a_server_is_reported(capsys: Said) -> None:
    url = f"http://127.0.0.1:{free_port()}"
    assert main(["rooms", "move", "main", "elsewhere", url]) == 2
    assert "Connection refused" in capsys.readouterr().err


def test_an_invalid_address_is_not_asked(capsys: Said) -> None:
    assert main(["halt", "ftp://table"]) == 2
    assert "is not an address such as http://127.0.0.1:8000" in capsys.readouterr().err
