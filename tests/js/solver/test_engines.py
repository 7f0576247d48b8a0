"""The page's solver gives the same digests in every JavaScript engine.

`make test-browsers` sets FIREFOX, JSC and CHROMIUM to their paths. Other tests cover Node.js and
wasmtime.
"""

import json
import os
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

from tests.engine.artifact.drops import cases
from tests.js.conftest import MODULES
from tests.kit.waiting import LIMIT

FIREFOX, JSC, CHROMIUM = (os.environ.get(name, "") for name in ("FIREFOX", "JSC", "CHROMIUM"))

_DIGESTS = """
const digests = (solver, given) => given.map(({ board, seeds }) =>
  Array.from({ length: seeds }, (_, seed) => solver.drop(board, { seed }).digest));
"""

_SHELL = """
import { openSolver } from "MODULES/solver/solver.js";
DIGESTS
const given = JSON.parse(readFile("GIVEN"));
const bytes = readFile("MODULES/solver/kernels.wasm", "binary");
openSolver(bytes).then((solver) => print(JSON.stringify(digests(solver, given))));
"""

_PAGE = """<!doctype html><script type="module">
const told = (body) => fetch("/found", { method: "POST", body });
try {
  const { openSolver } = await import("/solver/solver.js");
  DIGESTS
  const given = await (await fetch("/given")).json();
  await told(JSON.stringify(digests(await openSolver(), given)));
} catch (error) {
  await told(JSON.stringify(String(error)));
}
</script>
"""


class Handler(SimpleHTTPRequestHandler):
    """Serves the modules, the page and its task, and receives the page's result."""

    def __init__(self, given: bytes, found: "Queue[Any]", *args: Any) -> None:
        self.texts = {"/": _PAGE.replace("DIGESTS", _DIGESTS).encode(), "/given": given}
        self.found = found
        super().__init__(*args, directory=str(MODULES))

    def do_GET(self) -> None:
        text = self.texts.get(self.path)
        if text is None:
            super().do_GET()
            return
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)

    def do_POST(self) -> None:
        self.found.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_: Any) -> None:
        """Log nothing."""


@contextmanager
def served(given: bytes) -> Iterator[tuple[str, "Queue[Any]"]]:
    """Yield the page's address, and the queue of its results."""
    found: Queue[Any] = Queue()
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, given, found)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/", found
        server.shutdown()


def in_browser(command: list[str], given: bytes) -> Any:
    """Start a browser on the page, and return the page's result."""
    with served(given) as (address, found):
        browser = subprocess.Popen(
            [*command, address], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            return found.get(timeout=10 * LIMIT)
        finally:
            browser.kill()
            browser.wait()


def in_firefox(given: bytes, folder: Path) -> Any:
    profile = ["--profile", str(folder)]
    return in_browser([FIREFOX, "--headless", "--no-remote", *profile], given)


def in_chromium(given: bytes, folder: Path) -> Any:
    options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}"]
    return in_browser([CHROMIUM, *options, "--remote-debugging-port=0"], given)


def in_jsc(given: bytes, folder: Path) -> Any:
    (folder / "given.json").write_bytes(given)
    script = _SHELL.replace("DIGESTS", _DIGESTS).replace("MODULES", str(MODULES))
    (folder / "script.mjs").write_text(script.replace("GIVEN", str(folder / "given.json")))
    command = [JSC, "-m", str(folder / "script.mjs")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)


@pytest.mark.long
@pytest.mark.parametrize(
    ("engine", "path"),
    [(in_firefox, FIREFOX), (in_jsc, JSC), (in_chromium, CHROMIUM if FIREFOX else "")],
    ids=["SpiderMonkey", "JavaScriptCore", "Chromium"],
)
def test_an_engine_gives_the_same_digests(engine: Any, path: str, tmp_path: Path) -> None:
    if not path:
        pytest.skip("`make test-browsers` runs it")
    expected = cases()
    given = [{"board": each["board"], "seeds": len(each["digests"])} for each in expected]
    found = engine(json.dumps(given).encode(), tmp_path)
    assert not isinstance(found, str), found
    for mine, true in zip(found, expected, strict=True):
        assert mine == true["digests"], true["board"]["name"]
