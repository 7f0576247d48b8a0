"""A least-recently-used cache of values made from boards, limited by their bytes."""

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

from plinko.engine.board.fields import BoardFields

Made = TypeVar("Made")


class BoardCache(Generic[Made]):
    """Calls `make` once for a board and caches the result, `most` bytes in all.

    `size` returns the bytes of a result. The newest is kept even if it is larger. Thread-safe.
    """

    def __init__(
        self, make: Callable[[BoardFields], Made], size: Callable[[Made], int], most: int
    ) -> None:
        self.bytes = 0
        self._make = make
        self._size = size
        self._most = most
        self._made: OrderedDict[BoardFields, Made] = OrderedDict()
        self._lock = Lock()

    def __call__(self, board: BoardFields) -> Made:
        with self._lock:
            found = self._made.get(board)
            if found is not None:
                self._made.move_to_end(board)
                return found
        made = self._make(board)  # two threads may do this at once; the first result is kept
        with self._lock:
            found = self._made.setdefault(board, made)
            if found is made:
                self.bytes += self._size(made)
            while self.bytes > self._most and len(self._made) > 1:
                self.bytes -= self._size(self._made.popitem(last=False)[1])
        return found
