"""Work on its way to a worker: its board is packed once, and unpacked once in each worker.

A board of five thousand pegs takes 1.6 ms to pack, for which no room would tick.
"""

import functools
import io
import pickle
from collections.abc import Callable
from typing import Any, Final

from engine import Board

_KEPT: Final = 8
"""Boards. Of the largest each takes 0.8 MB: its bytes, and the board, which is kept alive."""


def packed(work: Callable[[], Any], seconds: float) -> bytes:
    """What a worker reads; `work` is a function of a module, with picklable values."""
    buffer = io.BytesIO()
    _Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump((work, seconds))
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
