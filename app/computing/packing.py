"""The bytes between the server and a worker: one request, `BEGUN`, one reply.

A request is `REQUEST` and the packed work. A reply is `REPLY` and the pickled outcome, a pair
(value or None, error or None). A board is packed only once, and unpacked once in each worker:
packing one with five thousand pegs takes 1.6 ms, during which no room would tick.
"""

import functools
import io
import pickle
import struct
from collections.abc import Callable
from typing import Any, Final

from plinko.engine import Board

REQUEST: Final = struct.Struct("!Qd")
"""Number of bytes of the packed work; its limit in CPU seconds."""

BEGUN: Final = b"\x01"
"""The worker has received the whole request and begins. Before this byte it has done nothing."""

REPLY: Final = struct.Struct("!Qd?")
"""Number of bytes of the pickled outcome; CPU seconds used; whether the worker ends now."""

_KEPT: Final = 8
"""Boards cached in packed form. The largest take 0.8 MB each: the bytes, and the board itself."""


def packed(work: Callable[[], Any]) -> bytes:
    """Pickle `work`, a module's function with picklable arguments."""
    buffer = io.BytesIO()
    _Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(work)
    return buffer.getvalue()


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: Any) -> Any:
        # A board is replaced by its cached bytes; everything else is pickled as usual.
        return (_unpacked, (_board(value),)) if isinstance(value, Board) else NotImplemented


@functools.lru_cache(maxsize=_KEPT)
def _board(board: Board) -> bytes:
    return pickle.dumps(board, pickle.HIGHEST_PROTOCOL)


@functools.lru_cache(maxsize=_KEPT)
def _unpacked(data: bytes) -> Board:
    # One object per board: the engine caches its arrays and kernels with the object.
    found: Board = pickle.loads(data)
    return found
