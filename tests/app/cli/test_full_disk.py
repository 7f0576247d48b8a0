"""A disk that is full: one line that names the file, exit code 2, and no part of a file."""

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from plinko.app.cli.boards import odds
from plinko.engine.payouts.record import shipped, to_text
from tests.app.cli.conftest import Terminal

ROOM: int = 300  # bytes that a file may have here


@contextmanager
def little_room() -> Iterator[None]:
    """Have the system refuse to write more than ROOM bytes to a file."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


ONE = ("render", "triangle-8", "{out}", "--seed", "1", "--width", "240")
WRITING = {
    "drop.png": ONE,
    "drop.gif": (*ONE, "--fps", "1"),
    "sheet.png": ("render", "triangle-8", "{out}", "--sheet", "1"),
    "map.png": ("map", "triangle-8", "{out}", "--levels", "1", "--pixels", "2"),
    "rows.csv": ("simulate", "triangle-8", "--drops", "9", "--out", "{out}"),
    "rows.parquet": ("simulate", "triangle-8", "--drops", "9", "--out", "{out}"),
    "kept.json": ("simulate", "triangle-8", "--drops", "9", "--resume", "{out}"),
    "merged.json": ("merge", "{result}", "--out", "{out}"),
    "board.json": ("payouts", "triangle-8", "--drops", "100", "--out", "{out}"),
    "draw.json": ("seeds", "triangle-8", "--draw", "0,0,0,0,1,0,0,0,0", "-o", "{out}"),
    "record.json": ("odds", "--record", "{out}", "--count", "--hours", "0"),
}


@pytest.mark.parametrize("name", WRITING)
def test_a_full_disk_leaves_the_file_as_it_was(
    name: str, tmp_path: Path, plinko: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(odds, "STEP", 60)
    out, result = tmp_path / name, tmp_path / "result.json"
    plinko.run("simulate", "triangle-8", "--drops", "9", "--resume", result)
    if name == "record.json":
        out.write_text(to_text({"triangle-8": shipped()["triangle-8"].solved_again("triangle-8")}))
    before = {each.name: each.read_bytes() for each in tmp_path.iterdir()}
    with little_room():
        code, _, err = plinko.try_run(*(s.format(out=out, result=result) for s in WRITING[name]))
    assert code == 2
    assert err.splitlines()[-1] == f"plinko: {out}: File too large"
    assert {each.name: each.read_bytes() for each in tmp_path.iterdir()} == before


def test_a_full_disk_leaves_no_film(tmp_path: Path, plinko: Terminal) -> None:
    """A film as MP4 is made in the folder for temporary files, which may be the full one."""
    with little_room():
        err = plinko.refuses(*(s.format(out=tmp_path / "drop.mp4") for s in (*ONE, "--fps", "1")))
    assert err.endswith("film.mp4: File too large\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["drop.png", "rows.csv", "board.json"])
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
def test_a_device_is_written_and_stays(name: str, tmp_path: Path, plinko: Terminal) -> None:
    out = tmp_path / name
    out.symlink_to("/dev/full")
    said = plinko.refuses(*(each.format(out=out) for each in WRITING[name]))
    assert said == f"plinko: {out}: No space left on device\n"
    assert out.is_symlink()


def test_a_file_is_replaced_behind_its_link(tmp_path: Path, plinko: Terminal) -> None:
    target, link = tmp_path / "drop.png", tmp_path / "latest.png"
    target.write_bytes(b"an older picture")
    link.symlink_to(target)
    plinko.run("render", "triangle-8", link, "--seed", "1")
    assert link.is_symlink()
    assert target.read_bytes().startswith(b"\x89PNG")
