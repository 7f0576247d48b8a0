"""The fixture `run`: calls a function with one of the page's modules in Node.js, by JSON."""

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

MODULES = Path(__file__).parents[2] / "static" / "js"

Run = Callable[..., Any]

# Each request is one line, and so is each response. A function is loaded as a separate module, so
# that it may await imports. It is called with the named module, the argument, and `load`, which
# loads further modules.
_ANSWER = """
import { createInterface } from "node:readline";
const load = (name) => import(new URL(name, MODULES));
for await (const line of createInterface({ input: process.stdin })) {
  const { name, source, argument } = JSON.parse(line);
  const told = await import(`data:text/javascript,${encodeURIComponent(source)}`)
    .then(async (script) => ({ result: await script.default(await load(name), argument, load) }))
    .catch((error) => ({ thrown: error.stack ?? String(error) }));
  process.stdout.write(`${JSON.stringify(told)}\\n`);
}
"""


class ScriptError(Exception):
    """The script threw an error."""


@pytest.fixture(scope="session")
def run() -> Iterator[Run]:
    """Call a JavaScript function with a module of static/js and an argument.

    One process runs all calls, and loads each module once.
    """
    node = shutil.which("node")
    assert node, "Node.js is not installed: run tools/node"
    script = _ANSWER.replace("MODULES", json.dumps(f"{MODULES.as_uri()}/"))
    process = subprocess.Popen(
        [node, "--input-type=module", "--eval", script],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    asking, answering = process.stdin, process.stdout

    def call(name: str, function: str, argument: Any = None) -> Any:
        source = f"export default {function.strip()}"
        asking.write(json.dumps({"name": name, "source": source, "argument": argument}) + "\n")
        asking.flush()
        line = answering.readline()
        assert line, "Node.js has exited"
        told = json.loads(line)
        if "thrown" in told:
            raise ScriptError(told["thrown"])
        return told.get("result")

    yield call
    asking.close()
    process.wait()
    answering.close()
