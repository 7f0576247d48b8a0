"""Memory that is let go goes back to the system."""

import ctypes
import os
from pathlib import Path

import pytest

from app.ops.memory import give_back

STATISTICS = Path("/proc/self/statm")


def resident() -> int:
    """Bytes of this process that are in memory."""
    return int(STATISTICS.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(
    not (STATISTICS.exists() and hasattr(ctypes.CDLL(None), "malloc_trim")),
    reason="the C library cannot be told",
)
def test_what_lies_between_pieces_in_use_goes_back() -> None:
    pieces = [b"x" * 65_536 for _ in range(1000)]
    del pieces[:-1]  # the last one stays, at the end of all
    before = resident()
    give_back()
    assert resident() < before - 40e6
