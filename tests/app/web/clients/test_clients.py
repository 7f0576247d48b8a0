"""Python and TypeScript clients generated from the OpenAPI document work unchanged."""

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import httpx
import pytest

from plinko.app.main import create_app
from plinko.engine import Board, drop
from tests.app.conftest import TINY
from tests.kit.serving import Running

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[3]
DIGEST = drop(Board.preset("triangle-8"), 42).digest

PICTURES = (
    *("image/png", "image/jpeg", "image/gif", "image/webp", "image/apng", "image/svg+xml"),
    "video/mp4",
)
CONFIG = {
    "content_type_overrides": dict.fromkeys(PICTURES, "application/octet-stream"),
    "post_hooks": [],
}


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("document") / "openapi.json"
    file.write_text(json.dumps(create_app().openapi()))
    return file


@pytest.fixture(scope="module")
def python(document: Path) -> Iterator[ModuleType]:
    """The package that openapi-python-client generates from the document."""
    config = document.with_name("config.json")
    config.write_text(json.dumps(CONFIG))
    package = document.with_name("plinko_client")
    said = run(
        *(sys.executable, "-m", "openapi_python_client", "generate", "--path", document),
        *("--config", config, "--meta", "none", "--output-path", package),
    )
    left_out = re.findall("^WARNING .*", said, re.MULTILINE)
    # The endless stream is for image tags; the generator does not support its content type.
    assert left_out == ["WARNING parsing GET /api/v1/rooms/{room}/stream.mjpg within rooms."]
    sys.path.insert(0, str(package.parent))
    try:
        yield importlib.import_module("plinko_client")
    finally:
        sys.path.remove(str(package.parent))


def call(name: str) -> Any:
    """The generated function of an operation, by its tag and id."""
    return importlib.import_module(f"plinko_client.api.{name}").sync


def test_a_generated_python_client_plays(python: ModuleType, server: Running) -> None:
    models = importlib.import_module("plinko_client.models")
    with python.Client(base_url=server.url, timeout=httpx.Timeout(60.0)) as client:
        room = look_and_play(client, models)
    with python.AuthenticatedClient(base_url=server.url, token=room.token) as owner:
        log = call("rooms.get_room_log")(room.id, client=owner)
        assert [(each.seed, each.who) for each in log.drops] == [("7", "py")]
        assert call("drops.verify_record")(client=owner, body=log).ok


def look_and_play(client: Any, models: Any) -> Any:
    """Request boards, drops and pictures, and drop a ball in a new room; returns that drop."""
    names = {each.name for each in call("boards.list_boards")(client=client).boards}
    assert "triangle-8" in names
    view = call("boards.get_board")("triangle-8", client=client)
    assert Board.from_json(view.board.to_dict()) == Board.preset("triangle-8")

    record = call("drops.get_drop")("triangle-8", "42", client=client)
    assert (record.digest, record.seed) == (DIGEST, "42")
    posted = call("drops.compute_drop")(
        client=client, body=models.DropRequest(board="triangle-8", seed="42")
    )
    assert posted.to_dict() == record.to_dict()
    assert call("drops.verify_record")(client=client, body=record).ok
    picture = call("pictures.get_drop_picture")(
        "triangle-8", "42", models.GetDropPictureFormat.PNG, client=client, width=240
    )
    assert picture.payload.read(4) == b"\x89PNG"

    board = models.BoardForm.from_dict(TINY)
    room = call("rooms.open_room")(client=client, body=models.RoomRequest(board=board))
    ball = call("rooms.drop_into_room")(
        room.id, client=client, wait=True, body=models.RoomDropRequest(seed="7", who="py")
    )
    assert ball.seed == "7"
    problem = call("boards.get_board")("none", client=client)
    assert (problem.code, problem.status) == ("unknown-board", 404)
    return room


def test_a_generated_typescript_client_plays(
    document: Path, server: Running, tmp_path: Path
) -> None:
    """Types by openapi-typescript, compiled with strict checks, run by Node.js."""
    node = shutil.which("node")
    assert node, "Node.js is not installed: run tools/node"
    modules = REPOSITORY / "node_modules"
    os.symlink(modules, tmp_path / "node_modules")
    shutil.copy(HERE / "play.ts", tmp_path)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    run(
        *(modules / ".bin" / "openapi-typescript", document, "--output", tmp_path / "schema.d.ts"),
        *("--default-non-nullable", "false"),
    )
    options = {"strict": True, "target": "es2022", "module": "nodenext", "skipLibCheck": True}
    options |= {"lib": ["es2022", "dom"], "types": []}
    config = {"compilerOptions": options, "files": ["play.ts", "node.d.ts"]}
    (tmp_path / "tsconfig.json").write_text(json.dumps(config))
    (tmp_path / "node.d.ts").write_text(
        "declare const process: { argv: string[]; stdout: { write(text: string): void } };\n"
    )
    run(modules / ".bin" / "tsc", "--project", tmp_path)
    told = json.loads(run(node, tmp_path / "play.js", server.url, json.dumps(TINY)))
    assert told.pop("frames") > 10
    found = {"name": "tiny", "digest": DIGEST, "ok": True, "seed": "7", "who": ["ts"]}
    assert told == {**found, "code": "unknown-board"}


def run(*command: Any) -> str:
    """Run a command that must succeed; returns what it says."""
    done = subprocess.run(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        check=False, cwd=REPOSITORY,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout
