"""`plinko simulate` by blocks, and `plinko merge`: parts of a batch and their output."""

import contextlib
import json
from pathlib import Path
from typing import Any

import pytest

from plinko.engine import drop_many
from tests.app.batches.test_running import Stopping
from tests.app.cli.conftest import Terminal
from tests.engine.batches.open_board import DROPS, FORM, OPEN


class Shell(Terminal):
    """Runs commands on a board in a file."""

    def __init__(self, folder: Path, capture: pytest.CaptureFixture[str]) -> None:
        super().__init__(capture)
        self.folder = folder
        self.board = folder / "open.json"
        self.board.write_text(json.dumps(FORM))

    def simulate(self, *arguments: object) -> Any:
        return self.json("simulate", self.board, "--drops", DROPS, *arguments)


@pytest.fixture
def shell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Shell:
    return Shell(tmp_path, capsys)


@pytest.fixture(scope="module")
def digest() -> str:
    return drop_many(OPEN, range(DROPS)).digest


def test_one_block_is_checked_alone_and_parts_merge(shell: Shell, digest: str) -> None:
    whole = shell.simulate()
    assert whole["digest"] == digest
    middle = shell.simulate("--blocks", 1)
    assert (middle["digest"], middle["drops"]) == (None, 65_536)
    assert middle["hashes"] == [whole["hashes"][1]]
    last = drop_many(OPEN, range(2 * 65_536, DROPS)).digest
    shown = shell.run("simulate", shell.board, "--drops", DROPS, "--blocks", 2)
    assert f"hash       {last}" in shown

    parts = {"first": ("--blocks", "0:1"), "last": ("--blocks", "2"), "middle": ("--blocks", "1:2")}
    files = [shell.folder / f"{name}.json" for name in parts]
    for path, blocks in zip(files, parts.values(), strict=True):
        path.write_text(json.dumps(shell.simulate(*blocks)))
    out = shell.run("merge", files[0], files[1])
    assert "covers     65,636 of 131,172 drops: blocks 0, 2 of 3" in out
    merged = shell.folder / "merged.json"
    found = shell.json("merge", *files, "--out", merged)
    assert json.loads(merged.read_text()) == found
    timed = {"seconds", "drops_per_second"}
    assert {key: found[key] for key in found.keys() - timed} == {
        key: whole[key] for key in whole.keys() - timed
    }


def test_an_interrupt_leaves_a_result_that_says_what_it_covers(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, digest: str
) -> None:
    kept = shell.folder / "kept.json"
    with monkeypatch.context() as interrupted:
        given = contextlib.nullcontext(Stopping(2, KeyboardInterrupt))
        interrupted.setattr("plinko.app.cli.common.workers", lambda *_: given)
        code, out, _ = shell.try_run("simulate", shell.board, "--drops", DROPS, "--resume", kept)
    assert code == 130
    assert "covers     131,072 of 131,172 drops: blocks 0 to 1 of 3" in out
    assert "digest" not in out
    found = shell.simulate("--resume", kept)
    assert found["digest"] == digest
    assert shell.simulate("--resume", kept)["seconds"] == found["seconds"], "nothing is computed"


BAD: tuple[tuple[tuple[object, ...], str], ...] = (
    (("--drops", "1.25e1"), "1.25e1"),
    (("--drops", "0"), "'0' is not a whole number"),
    (("--drops", "1e99"), "is not an integer from 0"),
    (("--drops", "9", "--blocks", "1"), "--blocks 1:2: this batch has 1 block,"),
    (("--drops", "9", "--blocks", "3:3"), "'3:3'"),
    (("--drops", "9", "--blocks", "all"), "'all'"),
    (("--drops", "9", "--resume", "{other}"), "asked is 9 in one and 10 in the other"),
    (("--drops", "9", "--resume", "{board}"), "open.json: this is not a result"),
    (("--drops", "9", "--certify", "--blocks", "0"), "--certify"),
)


@pytest.mark.parametrize(("arguments", "said"), BAD)
def test_invalid_options_give_one_line(
    shell: Shell, arguments: tuple[object, ...], said: str
) -> None:
    other = shell.folder / "other.json"
    shell.run("simulate", shell.board, "--drops", 10, "--resume", other)
    places = {"other": other, "board": shell.board}
    given = [str(each).format(**places) for each in arguments]
    assert said in shell.refuses("simulate", shell.board, *given)


def test_results_that_do_not_merge_give_one_line(shell: Shell) -> None:
    one, other = shell.folder / "one.json", shell.folder / "other.json"
    shell.run("simulate", shell.board, "--drops", 10, "--resume", one)
    shell.run("simulate", shell.board, "--drops", 10, "--seed", 1, "--resume", other)
    for files, said in (((one, other), "seed is '0' in one"), ((one, one), "block 0 is in both")):
        assert said in shell.refuses("merge", *files)
