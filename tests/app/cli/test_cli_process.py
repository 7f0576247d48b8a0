"""The command line as a process: exit codes, signals, pipes, terminals, imports."""

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.kit.python import run_python
from tests.kit.serving import serving
from tests.kit.waiting import LIMIT

MODULE = [sys.executable, "-m", "plinko"]
HEEDING = """
import signal, sys
# What a shell started in the background ignores interrupts, and so does what that starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
from plinko.app.cli import main
sys.exit(main())
"""
ENDLESS = ("simulate", "triangle-8", "--drops", str(10**12))


def run(*arguments: str, stdin: bytes = b"") -> "subprocess.CompletedProcess[bytes]":
    return subprocess.run([*MODULE, *arguments], input=stdin, capture_output=True, check=False)


def read_terminal(terminal: int, until: bytes) -> bytes:
    """Read a process's output on a pseudo-terminal, up to and including `until`."""
    seen = b""
    while until not in seen:
        seen += os.read(terminal, 1024)
    return seen


def test_a_drop_imports_nothing_heavy_and_ends_without_a_garbage_collection() -> None:
    said = run_python(
        "import atexit, gc, sys\n"
        "atexit.register(lambda: print(gc.get_freeze_count(), len(gc.get_objects())))\n"
        "from plinko.app.cli import main\n"
        "main(['drop', 'triangle-8', '--seed', '1', '--certainty'])\n"
        "heavy = ('fastapi', 'uvicorn', 'pydantic', 'PIL', 'asyncio', 'numba')\n"
        "print([name for name in heavy if name in sys.modules])\n"
    )
    *_, loaded, counts = said.splitlines()
    frozen, looked_at = map(int, counts.split())
    assert loaded == "[]"
    assert frozen > 100 * looked_at


def test_a_record_goes_from_drop_to_verify_through_a_pipe() -> None:
    record = run("drop", "triangle-8", "--seed", "11", "--json").stdout
    other = json.dumps(json.loads(record) | {"duration": 1.0}).encode()
    done = run("verify", "-", stdin=other)
    assert done.returncode == 1
    assert b"duration differs: the record says 1.0" in done.stdout


def stopped(number: signal.Signals, *options: str) -> tuple[int, bytes, bytes]:
    """Stop an endless run once its progress bar is shown; its exit code, output and terminal."""
    terminal, stderr = pty.openpty()
    command = [sys.executable, "-c", HEEDING, *ENDLESS, *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr)
    os.close(stderr)
    seen = read_terminal(terminal, b"[")
    process.send_signal(number)
    with contextlib.suppress(OSError):  # Linux raises EIO once the other end is closed
        while more := os.read(terminal, 1024):
            seen += more
    out, _ = process.communicate(timeout=LIMIT)
    os.close(terminal)
    return process.returncode, out, seen


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_run_leaves_rows_of_whole_blocks_or_no_file(
    tmp_path: Path, number: signal.Signals
) -> None:
    path = tmp_path / "drops.csv"
    code, out, seen = stopped(number, "--out", str(path))
    assert code == 128 + number
    assert out == b"" or b"of 1,000,000,000,000 drops: blocks 0" in out  # perhaps none is counted
    assert b"Traceback" not in seen
    assert b"Aborted" not in seen
    rows = len(path.read_text().splitlines()) - 1 if path.exists() else 0
    assert rows % 65_536 == 0
    assert path.exists() == (rows > 0)
    assert not [each for each in tmp_path.iterdir() if each != path]


def test_progress_is_shown_on_a_terminal() -> None:
    """Nowhere else: the tests in test_cli.py have nothing on stderr."""
    command = [*MODULE, "simulate", "triangle-8", "--drops", "50", "--json"]
    terminal, stderr = pty.openpty()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr)
    os.close(stderr)
    seen = read_terminal(terminal, b"100%")
    out, _ = process.communicate(timeout=LIMIT)
    os.close(terminal)
    assert b"drops" in seen
    assert json.loads(out)["drops"] == 50


def test_a_reader_that_goes_away_is_no_error() -> None:
    command, pipe = [*MODULE, "boards", "triangle-16"], subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    said = process.stderr.read()
    process.stderr.close()
    assert process.wait(LIMIT) == 141
    assert said == b""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full on this system")
def test_a_full_disk_is_one_line() -> None:
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*MODULE, "boards"], stdout=full, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 2
    assert re.fullmatch(rb"plinko: No space left on device\n", done.stderr)


def test_a_taken_port_and_a_ledger_in_use_are_one_line(tmp_path: Path) -> None:
    ledger = f"sqlite:///{tmp_path / 'plinko.db'}"
    with serving(database_url=ledger) as server:
        taken = server.url.rpartition(":")[2]
        for options, said in (
            (("--port", taken), taken),
            (
                ("--port", "0", "--database-url", ledger),
                "another server uses it; give this one a --data directory",
            ),
        ):
            done = run("serve", *options)
            assert done.returncode == 1, "the same settings may work later"
            assert done.stderr.startswith(b"plinko: ")
            assert said.encode() in done.stderr
            assert done.stderr.count(b"\n") == 1


def test_a_server_that_draws_nothing_has_no_pictures_loaded() -> None:
    said = run_python(
        "import sys; from plinko.app.main import create_app;"
        "from plinko.app.settings import Settings;"
        "create_app(Settings(database_url='sqlite://'));"
        "print([name for name in ('PIL', 'plinko.app.render.still') if name in sys.modules])"
    )
    assert said.splitlines()[-1] == "[]"
