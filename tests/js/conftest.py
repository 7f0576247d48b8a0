"""A function of one of the page's modules, called in Node.js with JSON in and JSON out."""

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

MODULES = Path(__file__).parents[2] / "static" / "js"

Run = Callable[..., Any]

# The function gets the module, the argument, and `load` for further modules.
_CALL = """
const load = (name) => import(new URL(name, MODULES));
let text = "";
for await (const chunk of process.stdin) text += chunk;
const { name, argument } = JSON.parse(text);
const result = await (FUNCTION)(await load(name), argument, load);
process.stdout.write(JSON.stringify(result ?? null));
"""


class ScriptError(Exception):
    """What a script threw."""


@pytest.fixture(scope="session")
def run() -> Run:
    """Calls a JavaScript function with a module of static/js and an argument."""
    node = shutil.which("node")
    assert node, "Node.js is not installed; tools/node sees to that"

    def call(name: str, function: str, argument: Any = None) -> Any:
        script = _CALL.replace("MODULES", json.dumps(f"{MODULES.as_uri()}/"))
        done = subprocess.run(
            [node, "--input-type=module", "--eval", script.replace("FUNCTION", function)],
            input=json.dumps({"name": name, "argument": argument}),
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise ScriptError(done.stderr)
        return json.loads(done.stdout)

    return call
