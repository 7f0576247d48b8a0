"""The npm package in the production bundles of vite and esbuild, run in Chromium and in Node.js."""

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest

from plinko.engine import drop, drop_many
from tests.examples.test_npm import build_package, run
from tests.kit.waiting import LIMIT

pytestmark = pytest.mark.long("npm installs two bundlers")

COMPUTE = """
import { openSolver } from "plinko-sim";
import { Batch } from "plinko-sim/batch";
import board from "plinko-sim/presets/triangle-16";

const compute = async () => {
  const { digest } = JSON.parse(JSON.stringify((await openSolver()).drop(board, { seed: "21" })));
  const batch = new Batch({ board, first: "0", drops: 1000 }, () => {});
  return [digest, (await batch.done).histogram];
};
"""
OWN = f"{COMPUTE}compute().then(postMessage);"
MAIN = f"""{COMPUTE}
compute().then((said) => {{
  if (!globalThis.document) return console.log(JSON.stringify(said));
  const own = new Worker(new URL("./own.js", import.meta.url), {{ type: "module" }});
  own.onmessage = ({{ data }}) =>
    document.body.append(JSON.stringify([...said, ...data]));
}});
"""
SAID = [drop("triangle-16", 21).digest, drop_many("triangle-16", 1000).histogram.tolist()]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh project with both bundlers, and the package as `npm pack` packs it."""
    folder = tmp_path_factory.mktemp("bundles")
    build_package(folder / "package")
    run("npm", "pack", "--offline", "--silent", "./package", cwd=folder)
    (packed,) = folder.glob("*.tgz")
    (folder / "package.json").write_text('{"private": true, "type": "module"}')
    install = ("npm", "install", "--no-audit", "--no-fund", "--no-package-lock", "--silent")
    run(*install, "vite@8", "esbuild@0.28", packed, cwd=folder)
    (folder / "main.js").write_text(MAIN)
    (folder / "own.js").write_text(OWN)
    page = '<!doctype html><body><script type="module" src="main.js"></script>'
    (folder / "index.html").write_text(page)
    return folder


@pytest.fixture(scope="module", params=["vite", "esbuild"])
def bundle(request: pytest.FixtureRequest, project: Path) -> Path:
    """The folder of the bundle, made by the commands of the package's README."""
    readme = (project / "node_modules/plinko-sim/README.md").read_text("utf-8")
    (command,) = re.findall(rf"^npx {request.param} (.*)$", readme, re.MULTILINE)
    words = command.replace("main.js", "main.js own.js").split()
    run("npx", "--no-install", request.param, *words, cwd=project)
    folder = project / "dist"
    if request.param == "esbuild":
        (folder / "index.html").write_bytes((project / "index.html").read_bytes())
    return folder.rename(project / request.param)


@contextmanager
def served(folder: Path) -> Iterator[str]:
    handler = partial(SimpleHTTPRequestHandler, directory=str(folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_a_bundle_computes_drops_and_batches_in_a_page_and_in_its_own_workers(bundle: Path) -> None:
    from playwright.sync_api import sync_playwright

    with served(bundle) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=os.environ["CHROMIUM"])
        page = browser.new_page()
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(address)
        page.wait_for_function("document.body.textContent", timeout=LIMIT * 1000)
        assert json.loads(page.text_content("body") or "") == [*SAID, *SAID]
        assert faults == []
        browser.close()


@pytest.mark.parametrize("bundle", ["esbuild"], indirect=True)  # vite bundles pages only
def test_a_bundle_for_node_computes_drops_and_batches(project: Path, bundle: Path) -> None:
    assert json.loads(run("node", bundle / "main.js", cwd=project)) == SAID
