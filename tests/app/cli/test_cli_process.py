"""The command line as a process: exit codes, signals, pipes, terminals, and what it imports."""

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Sequence
from pathlib import Path

import pytest

from app.cli import uncompiled
from app.main import COMPILING
from tests.waiting import LIMIT, first_line

MODULE = [sys.executable, "-m", "app.cli"]
HEEDING = """
import signal, sys
# What a shell started in the background ignores interrupts, and so does what that starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
from app.cli import main
sys.exit(main())
"""
ENDLESS = ("simulate", "triangle-8", "--drops", str(10**12))


def run(*arguments: str, stdin: bytes = b"") -> "subprocess.CompletedProcess[bytes]":
    return subprocess.run([*MODULE, *arguments], input=stdin, capture_output=True, check=False)


def start(arguments: Sequence[str], **streams: int) -> "subprocess.Popen[bytes]":
    return subprocess.Popen([*MODULE, *arguments], **streams)  # type: ignore[call-overload,no-any-return]


def read_terminal(terminal: int, until: bytes) -> bytes:
    """What a process printed on a pseudo-terminal, up to and with `until`."""
    seen = b""
    while until not in seen:
        seen += os.read(terminal, 1024)
    return seen


def test_an_error_is_exit_code_2_without_a_traceback() -> None:
    done = run("drop", "nope", "--seed", "1")
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.startswith(b"plinko: BOARD 'nope'")
    assert done.stderr.count(b"\n") == 1


def test_a_process_ends_without_a_look_for_garbage_through_all_it_has() -> None:
    code = (
        "import atexit, gc\n"
        "atexit.register(lambda: print(gc.get_freeze_count(), len(gc.get_objects())))\n"
        "from app.cli import main\n"
        "main(['drop', 'triangle-8', '--seed', '1'])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    frozen, looked_at = done.stdout.splitlines()[-1].split()
    assert int(frozen) > 100 * int(looked_at)


def test_a_record_goes_from_drop_to_verify_through_a_pipe() -> None:
    record = run("drop", "triangle-8", "--seed", "11", "--json").stdout
    assert run("verify", "-", stdin=record).returncode == 0
    other = json.dumps(json.loads(record) | {"duration": 1.0}).encode()
    done = run("verify", "-", stdin=other)
    assert done.returncode == 1
    assert b"duration differs: the record says 1.0" in done.stdout


def test_an_interrupt_is_exit_code_130_and_says_nothing() -> None:
    """The progress bar on a terminal says when the drops have begun."""
    terminal, stderr = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", HEEDING, *ENDLESS], stdout=subprocess.PIPE, stderr=stderr
    )
    os.close(stderr)
    seen = read_terminal(terminal, b"[")
    process.send_signal(signal.SIGINT)
    with contextlib.suppress(OSError):  # how Linux says that the other end is closed
        while more := os.read(terminal, 1024):
            seen += more
    out, _ = process.communicate(timeout=LIMIT)
    os.close(terminal)
    assert (process.returncode, out) == (130, b"")
    assert b"Traceback" not in seen
    assert b"Aborted" not in seen


def test_progress_is_shown_on_a_terminal_and_nowhere_else() -> None:
    few = ("simulate", "triangle-8", "--drops", "50", "--json")
    assert run(*few).stderr == b""
    terminal, stderr = pty.openpty()
    process = start(few, stdout=subprocess.PIPE, stderr=stderr)
    os.close(stderr)
    seen = read_terminal(terminal, b"100%")
    out, _ = process.communicate(timeout=LIMIT)
    os.close(terminal)
    assert b"drops" in seen
    assert json.loads(out)["drops"] == 50


def test_a_reader_that_goes_away_is_no_error() -> None:
    process = start(("boards", "triangle-16"), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
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


def test_serve_prints_its_address_and_stops_in_order() -> None:
    process = start(("serve", "--port", "0"), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        line = first_line(process).decode()
        found = re.search(r"http://127\.0\.0\.1:\d+", line)
        assert found, line
        with urllib.request.urlopen(f"{found[0]}/healthz") as reply:
            assert reply.status == 200
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=LIMIT)
    finally:
        process.kill()
        process.communicate(timeout=LIMIT)
    # On a slow machine it says meanwhile what it waits for.
    said = [line for line in err.decode().splitlines() if line != COMPILING]
    assert (process.returncode, said) == (0, [])


def test_a_taken_port_is_one_line() -> None:
    process = start(("serve", "--port", "0"), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        port = first_line(process).decode().strip().rstrip("/").rsplit(":", 1)[1]
        done = run("serve", "--port", port)
    finally:
        process.kill()
        process.communicate(timeout=LIMIT)
    assert done.returncode == 2
    assert done.stderr.startswith(b"plinko: ")
    assert port.encode() in done.stderr
    assert done.stderr.count(b"\n") == 1


def test_a_ledger_in_use_is_one_line(tmp_path: Path) -> None:
    ledger = ("--database-url", f"sqlite:///{tmp_path / 'plinko.db'}")
    process = start(("serve", "--port", "0", *ledger), stdout=subprocess.PIPE)
    try:
        assert b"http://" in first_line(process)
        done = run("serve", "--port", "0", *ledger)
    finally:
        process.kill()
        process.communicate(timeout=LIMIT)
    assert done.returncode == 2
    assert b"another server uses it; give this one a --data directory" in done.stderr
    assert done.stderr.count(b"\n") == 1


def test_a_drop_imports_neither_server_nor_pictures() -> None:
    program = (
        "import sys; from app.cli import main; main(['drop', 'triangle-8', '--seed', '1']);"
        "heavy = ('fastapi', 'uvicorn', 'pydantic', 'PIL', 'asyncio');"
        "print([name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.splitlines()[-1] == b"[]"


def small(
    *arguments: str, ahead: str = "", **environment: str
) -> "subprocess.CompletedProcess[str]":
    """`plinko` with these arguments, which then says if numba was loaded; `ahead`: code before."""
    program = (
        "import atexit, sys\n"
        "atexit.register(lambda: print('compiled' if 'numba' in sys.modules else 'as Python'))\n"
        f"from app.cli import main, uncompiled\n{ahead}\nsys.exit(main())\n"
    )
    kept = {name: value for name, value in os.environ.items() if name != uncompiled.SWITCH}
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, env=kept | environment
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ("triangle-16", "--seed", "42", "--json", "--certainty"),
        ("classic", "--seed", "1", "--certainty"),
        ("galton", "--seed", "7", "--json", "--solver", "stepped", "--dt", "1/30"),
        ("triangle-8", "--seed", "1", "--x", "nan"),
    ],
)
def test_a_drop_with_kernels_as_python_prints_what_compiled_ones_do(
    arguments: tuple[str, ...],
) -> None:
    python, compiled = small("drop", *arguments), small("drop", *arguments, NUMBA_DISABLE_JIT="0")
    assert python.stdout.endswith("as Python\n")
    assert compiled.stdout.endswith("compiled\n")
    assert python.stdout.splitlines()[:-1] == compiled.stdout.splitlines()[:-1]
    assert (python.stderr, python.returncode) == (compiled.stderr, compiled.returncode)


def test_a_record_in_a_file_is_verified_with_kernels_as_python(tmp_path: Path) -> None:
    record = tmp_path / "record.json"
    record.write_bytes(run("drop", "triangle-8", "--seed", "11", "--json").stdout)
    done = small("verify", str(record))
    assert done.stdout == f"reproduced: {json.loads(record.read_bytes())['digest']}\nas Python\n"


def test_a_drop_that_takes_long_as_python_starts_again_compiled() -> None:
    arguments = ("drop", "triangle-16", "--seed", "42", "--solver", "stepped", "--dt", "1/2000")
    done = small(*arguments, ahead="uncompiled.PATIENCE = 0.05")
    assert done.stdout.splitlines() == [*run(*arguments).stdout.decode().splitlines(), "compiled"]
    assert (done.stderr, done.returncode) == ("", 0)


def test_called_from_python_a_command_leaves_kernels_as_they_are() -> None:
    program = (
        "import os; from app.cli import main, uncompiled;"
        "main(['drop', 'triangle-8', '--seed', '1']);"
        "from engine.jit import decorator as jit;"
        "print(os.environ.get(uncompiled.SWITCH), jit.IS_OFF,"
        "uncompiled.SWITCH == jit.SWITCH)"
    )
    kept = {name: value for name, value in os.environ.items() if name != uncompiled.SWITCH}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=kept)
    assert done.stdout.splitlines()[-1] == "None False True"


def test_a_server_that_draws_nothing_has_no_pictures_loaded() -> None:
    program = (
        "import sys; from app.main import create_app; from app.settings import Settings;"
        "create_app(Settings(database_url='sqlite://'));"
        "print([name for name in ('PIL', 'app.render') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.splitlines()[-1] == b"[]"
