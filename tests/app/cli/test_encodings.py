"""Files may be in any encoding of Unicode, and terminals may show only some of its characters."""

import base64
import codecs
import io
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from plinko.app.cli import main
from plinko.app.webhooks.targets import read_targets
from plinko.engine import Board, drop
from plinko.engine.payouts.record import shipped, to_text
from tests.app.cli.conftest import Terminal

NAME = "Łódź 😀 é"
BOARD = Board.triangle(4).replace(name=NAME)
POWERSHELL = codecs.BOM_UTF16_LE, "utf-16-le"
ENCODINGS = {
    "UTF-8": (b"", "utf-8"),
    "UTF-8 with a mark": (codecs.BOM_UTF8, "utf-8"),
    "UTF-16 as PowerShell writes it": POWERSHELL,
    "UTF-16 without a mark": (b"", "utf-16-be"),
    "UTF-32": (codecs.BOM_UTF32_LE, "utf-32-le"),
}

Write = Callable[[str, str], Path]


@pytest.fixture(params=list(ENCODINGS))
def write(request: pytest.FixtureRequest, tmp_path: Path) -> Write:
    mark, encoding = ENCODINGS[request.param]

    def written(name: str, text: str) -> Path:
        path = tmp_path / name
        path.write_bytes(mark + text.encode(encoding))
        return path

    return written


def test_a_file_that_a_command_reads_may_have_any_encoding(
    write: Write, plinko: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("board.json", BOARD.to_json())
    assert Board.from_json(path) == BOARD
    assert json.loads(plinko.run("boards", path))["name"] == NAME
    path = write("drop.json", drop(BOARD, 1).to_json())
    assert plinko.run("verify", path).startswith("reproduced")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(path.read_bytes())))
    assert plinko.run("verify", "-").startswith("reproduced")
    few = ("simulate", "triangle-8", "--drops", 10, "--json")
    text = plinko.run(*few)
    path = write("result.json", text)
    assert plinko.run("merge", path, "--json") == plinko.run(*few, "--resume", path) == text
    path = write("record.json", to_text({"triangle-8": shipped()["triangle-8"]}))
    assert "| `triangle-8` | 99." in plinko.run("odds", "--record", path)
    path = write("weights.json", "[0, 0, 0, 0, 1, 0, 0, 0, 0]")
    drawn = json.loads(plinko.run("seeds", "triangle-8", "--draw", path, "--per-bin", 1))
    assert drawn["draw"]["weights"][4] == 1
    secret = "whsec_" + base64.b64encode(b"k" * 32).decode()
    target = {"url": "https://example.org/hook", "secret": secret}
    (found,) = read_targets(str(write("targets.json", json.dumps([target]))))
    assert found.url == target["url"]


class Screen:
    """A terminal that shows the characters of one encoding."""

    def __init__(self, encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
        self._encoding = encoding
        self._patch = monkeypatch
        self.name = NAMES[encoding]  # the board's name as it is shown

    def run(self, *arguments: object, code: int = 0) -> str:
        """Run a command; returns its output, or what it said on stderr."""
        return self.written(*arguments, code=code).decode(self._encoding)

    def written(self, *arguments: object, code: int = 0) -> bytes:
        """The bytes of the same."""
        out, err = (io.BytesIO() for _ in range(2))
        with self._patch.context() as patch:
            patch.setattr(sys, "stdout", io.TextIOWrapper(out, encoding=self._encoding))
            patch.setattr(sys, "stderr", io.TextIOWrapper(err, encoding=self._encoding))
            assert main([str(each) for each in arguments]) == code
            sys.stdout.flush()
            said, other = (err, out) if code else (out, err)
            assert other.getvalue() == b""
            return said.getvalue()


NAMES = {
    "ascii": r"\u0141\u00f3d\u017a \ud83d\ude00 \u00e9",
    "cp1252": r"\u0141ód\u017a \ud83d\ude00 é",
    "cp437": r"\u0141ód\u017a \ud83d\ude00 é",
    "utf-8": NAME,
}


@pytest.fixture
def board(tmp_path: Path) -> Path:
    path = tmp_path / "board.json"
    path.write_text(BOARD.to_json(), encoding="utf-8")
    return path


@pytest.mark.parametrize("encoding", NAMES)
def test_a_terminal_shows_what_it_can_and_the_rest_escaped(
    board: Path, tmp_path: Path, encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    screen, few = Screen(encoding, monkeypatch), ("--drops", 10)
    assert screen.name in screen.run("drop", board, "--seed", 1)
    assert screen.name in screen.run("simulate", board, *few)
    assert screen.name in screen.run("certify", board, "--seed", 1)
    kept, picture = tmp_path / f"{NAME}.json", tmp_path / f"{NAME}.png"
    screen.run("simulate", board, *few, "--resume", kept)
    assert screen.name in screen.run("merge", kept)
    assert screen.name in screen.run("render", board, picture, "--seed", 1)
    assert screen.name in screen.run("map", board, picture, "--levels", 1, "--pixels", 2)
    assert f"BOARD '{screen.name}'" in screen.run("drop", NAME, "--seed", 1, code=2)
    # On Linux a file's name is bytes, which Python keeps as lone surrogates.
    no_text = tmp_path / os.fsdecode(b"\xff.png")
    assert r"\udcff.png: " in screen.run("render", board, no_text, "--seed", 1)


@pytest.mark.parametrize("encoding", NAMES)
def test_json_stays_json_on_any_terminal(
    board: Path, tmp_path: Path, encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """JSON is UTF-8, also in a file to which the output of a program for Windows-1252 goes."""
    screen = Screen(encoding, monkeypatch)

    def said(*arguments: object) -> Any:
        return json.loads(screen.written(*arguments).decode())

    assert said("boards", board) == BOARD.to_dict()
    assert said("drop", board, "--seed", 1, "--json") == drop(BOARD, 1).to_dict()
    assert said("simulate", board, "--drops", 10, "--json")["board"]["name"] == NAME
    drawn = said("seeds", board, "--draw", "0,0,1,0,0", "--per-bin", 1)
    assert drawn["board"]["name"] == NAME
    record = tmp_path / "drop.json"
    record.write_bytes(screen.written("drop", board, "--seed", 1, "--json"))
    assert screen.run("verify", record).startswith("reproduced")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_a_process_escapes_what_its_terminal_lacks(board: Path, encoding: str) -> None:
    for arguments, code in (
        (("drop", board, "--seed", "1"), 0),
        (("drop", NAME, "--seed", "1"), 2),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "plinko", *arguments],
            env={**os.environ, "PYTHONIOENCODING": encoding},
            capture_output=True,
            check=False,
        )
        assert done.returncode == code
        assert NAMES[encoding].encode(encoding) in done.stdout + done.stderr
        assert b"Traceback" not in done.stderr
