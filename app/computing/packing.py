"""What the server and a worker say to each other: one request, `BEGUN`, one reply.

A request is `REQUEST` and the packed work; a reply is `REPLY` and the pickled outcome, which is a
pair: the value, or None; and None, or the error. A board is packed once, and unpacked once in each
worker: one of five thousand pegs takes 1.6 ms to pack, for which no room would tick.
"""

import functools
import io
import pickle
import struct
from collections.abc import Callable
from typing import Any, Final

from engine import Board

REQUEST: Final = struct.Struct("!Qdd")
"""Bytes of the packed work, the s of a core and the s of real time that it may take."""

BEGUN: Final = b"\x01"
"""The worker has the whole request and begins. Before this byte nothing was done for it."""

REPLY: Final = struct.Struct("!Qd?")
"""Bytes of the pickled outcome, s of a core that it took, whether the worker ends now."""

_KEPT: Final = 8
"""Boards. Of the largest each takes 0.8 MB: its bytes, and the board, which is kept alive."""


def packed(work: Callable[[], Any]) -> bytes:
    """`work`, a function of a module with picklable values, as `pickle.loads` reads it."""
    buffer = io.BytesIO()
    _Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(work)
    return buffer.getvalue()


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: Any) -> Any:
        """Boards as bytes, everything else as it is."""
        return (_unpacked, (_board(value),)) if isinstance(value, Board) else NotImplemented


@functools.lru_cache(maxsize=_KEPT)
def _board(board: Board) -> bytes:
    return pickle.dumps(board, pickle.HIGHEST_PROTOCOL)


@functools.lru_cache(maxsize=_KEPT)
def _unpacked(data: bytes) -> Board:
    """The same board each time: what is derived from it is kept with it."""
    found: Board = pickle.loads(data)
    return found
