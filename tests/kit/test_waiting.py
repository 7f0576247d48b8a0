"""`lives` is false for a process that ends while its state is read."""

import subprocess
from pathlib import Path

import pytest

from tests.kit.waiting import lives


def test_a_process_that_goes_while_it_is_looked_at_does_not_live(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    process = subprocess.Popen(["sleep", "3600"])
    assert lives(process.pid)
    read = Path.read_text

    def late(path: Path) -> str:
        process.kill()
        process.wait()
        return read(path)

    monkeypatch.setattr(Path, "read_text", late)
    assert not lives(process.pid)
