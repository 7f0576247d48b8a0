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


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Run a command that must succeed; returns its output."""
    code = main([str(each) for each in arguments])
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    return out


def test_a_board_s_file_may_have_any_encoding(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write("board.json", BOARD.to_json())
    assert Board.from_json(path) == BOARD
    assert json.loads(run(capsys, "boards", path))["name"] == NAME


def test_a_record_may_have_any_encoding_in_a_file_or_on_standard_input(
    write: Write, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("drop.json", drop(BOARD, 1).to_json())
    assert run(capsys, "verify", path).startswith("reproduced")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(path.read_bytes())))
    assert run(capsys, "verify", "-").startswith("reproduced")


def test_a_batch_s_result_may_have_any_encoding(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    few = ("simulate", "triangle-8", "--drops", 10, "--json")
    text = run(capsys, *few)
    path = write("result.json", text)
    assert run(capsys, "merge", path, "--json") == text
    assert run(capsys, *few, "--resume", path) == text


def test_a_record_of_returns_may_have_any_encoding(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write("record.json", to_text(shipped()))
    assert run(capsys, "odds", "--record", path) == run(capsys, "odds")


def test_weights_may_have_any_encoding(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = write("weights.json", "[0, 0, 0, 0, 1, 0, 0, 0, 0]")
    drawn = json.loads(run(capsys, "seeds", "triangle-8", "--draw", path, "--per-bin", 1))
    assert drawn["draw"]["weights"][4] == 1


def test_targets_of_webhooks_may_have_any_encoding(write: Write) -> None:
    target = {
        "url": "https://example.org/hook",
        "secret": "whsec_" + base64.b64encode(b"k" * 32).decode(),
    }
    (found,) = read_targets(str(write("targets.json", json.dumps([target]))))
    assert found.url == target["url"]


class Terminal:
    """A terminal that shows the characters of one encoding."""

    def __init__(self, encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
        self._encoding = encoding
        self._patch = monkeypatch

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


@pytest.fixture(params=NAMES)
def terminal(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Terminal:
    return Terminal(request.param, monkeypatch)


@pytest.fixture
def shown(terminal: Terminal) -> str:
    """The board's name as the terminal shows it."""
    return NAMES[terminal._encoding]


@pytest.fixture
def board(tmp_path: Path) -> Path:
    path = tmp_path / "board.json"
    path.write_text(BOARD.to_json(), encoding="utf-8")
    return path


def test_a_terminal_shows_what_it_can_and_the_rest_escaped(
    terminal: Terminal, shown: str, board: Path, tmp_path: Path
) -> None:
    few = ("--drops", 10)
    assert shown in terminal.run("drop", board, "--seed", 1)
    assert shown in terminal.run("simulate", board, *few)
    assert shown in terminal.run("certify", board, "--seed", 1)
    kept = tmp_path / f"{NAME}.json"
    terminal.run("simulate", board, *few, "--resume", kept)
    assert shown in terminal.run("merge", kept)
    picture = tmp_path / f"{NAME}.png"
    assert shown in terminal.run("render", board, picture, "--seed", 1)
    assert shown in terminal.run("map", board, picture, "--levels", 1, "--pixels", 2)


def test_json_stays_json_on_any_terminal(terminal: Terminal, board: Path, tmp_path: Path) -> None:
    """JSON is UTF-8, also in a file to which the output of a program for Windows-1252 goes."""

    def said(*arguments: object) -> Any:
        return json.loads(terminal.written(*arguments).decode())

    assert said("boards", board) == BOARD.to_dict()
    assert said("drop", board, "--seed", 1, "--json") == drop(BOARD, 1).to_dict()
    assert said("simulate", board, "--drops", 10, "--json")["board"]["name"] == NAME
    drawn = said("seeds", board, "--draw", "0,0,1,0,0", "--per-bin", 1)
    assert drawn["board"]["name"] == NAME
    record = tmp_path / "drop.json"
    record.write_bytes(terminal.written("drop", board, "--seed", 1, "--json"))
    assert terminal.run("verify", record).startswith("reproduced")


def test_an_error_shows_what_it_can_of_a_name(terminal: Terminal, shown: str) -> None:
    assert f"BOARD '{shown}'" in terminal.run("drop", NAME, "--seed", 1, code=2)


def test_a_file_s_name_that_is_not_text_is_shown(terminal: Terminal, tmp_path: Path) -> None:
    """On Linux a file's name is bytes, which Python keeps as lone surrogates."""
    path = tmp_path / os.fsdecode(b"\xff.png")
    assert r"\udcff.png: " in terminal.run("render", "triangle-8", path, "--seed", 1)


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
