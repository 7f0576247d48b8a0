"""Runs the page's artifact by wasmtime: another compiler, on any processor, and the same bits.

The counterpart in the page is `static/js/solver/kernels.js`.
"""

from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt
import wasmtime

from plinko.engine.artifact import make
from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.physics import body, contact

PAGE: Final = 65_536
"""Bytes of a page, by which a module's memory grows."""

STACK: Final = PAGE
"""Bytes reserved below all blocks for the module's stack."""


class Run(NamedTuple):
    """The results of some balls, like those of `trace_many`, copied out of the kernels' memory."""

    states: npt.NDArray[np.float64]
    events: npt.NDArray[np.float64]
    marks: npt.NDArray[np.int32]
    segments: npt.NDArray[np.float64]
    counts: npt.NDArray[np.int64]
    bins: npt.NDArray[np.int32]
    impacts: npt.NDArray[np.int32]
    outcomes: npt.NDArray[np.int8]


def blocks_of(board: BoardArrays) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """A board as entries.py reads it: one block of floats and one of whole numbers."""
    numbers = [value for value in board if isinstance(value, float)]
    sizes = [
        len(board.items), board.columns, board.rows, board.peg_count, len(board.members),
        len(board.edges),
    ]  # fmt: skip
    floats = np.concatenate([numbers, board.items.ravel(), board.centres.ravel(), board.edges])
    words = np.concatenate([sizes, board.starts, board.members, board.heads])
    return floats, words.astype(np.uint32)


class Host:
    """An instance of the artifact with its own memory, for one thread at a time."""

    def __init__(self, module: bytes | None = None) -> None:
        """Load `module`, by default the committed artifact."""
        engine = wasmtime.Engine()
        self._store = wasmtime.Store(engine)
        limits = wasmtime.MemoryType(wasmtime.Limits(4, None))
        self._memory = wasmtime.Memory(self._store, limits)
        kind = wasmtime.GlobalType(wasmtime.ValType.i32(), True)
        stack = wasmtime.Global(self._store, kind, wasmtime.Val.i32(STACK))
        loaded = wasmtime.Module(engine, make.PAGE.read_bytes() if module is None else module)
        given: dict[str, Any] = {"__linear_memory": self._memory, "__stack_pointer": stack}
        imports = [given[str(each.name)] for each in loaded.imports]
        self._exports: Any = wasmtime.Instance(self._store, loaded, imports).exports(self._store)
        self._board = (0, 0)
        self._free = STACK

    def load(self, board: BoardArrays) -> None:
        """Use this board for all later calls."""
        floats, words = blocks_of(board)
        self._free = STACK
        f = self._take(np.float64, floats.shape)
        w = self._take(np.uint32, words.shape)
        self._array(f, np.float64, floats.shape)[:] = floats
        self._array(w, np.uint32, words.shape)[:] = words
        self._board = (f, w)

    def trace(self, states: npt.NDArray[np.float64], events: int = 0, segments: int = 0) -> Run:
        """Follow balls at rest from `states`, shape (n, 7); the log has this much room."""
        balls = len(states)
        free = self._free
        shapes = {
            "states": (np.float64, (balls, body.SIZE)),
            "initial": (np.int64, (balls, initial_state.COLUMNS)),
            "events": (np.float64, (events, event_log.EVENT_SIZE)),
            "marks": (np.int32, (events, 2)),
            "segments": (np.float64, (segments, event_log.SEGMENT_SIZE)),
            "counts": (np.int64, (event_log.COUNTS,)),
            "ends": (np.int32, (2, balls)),
            "outcomes": (np.int8, (balls,)),
            "series": (np.float64, (contact.ROWS, contact.ORDER + 1)),
        }
        at = {name: self._take(kind, shape) for name, (kind, shape) in shapes.items()}
        arrays = {name: self._array(at[name], *shapes[name]) for name in shapes}
        arrays["states"][:] = states
        arrays["counts"][:] = 0
        self._exports["trace"](
            self._store, *self._board, balls, at["states"], at["initial"], at["events"],
            at["marks"], events, at["segments"], segments, at["counts"], at["ends"],
            at["outcomes"], at["series"],
        )  # fmt: skip
        self._free = free
        bins, impacts = arrays["ends"].copy()
        return Run(
            arrays["states"].copy(),
            arrays["events"].copy(),
            arrays["marks"].copy(),
            arrays["segments"].copy(),
            arrays["counts"].copy(),
            bins,
            impacts,
            arrays["outcomes"].copy(),
        )

    def _take(self, kind: Any, shape: tuple[int, ...]) -> int:
        """Reserve memory for an array, which may grow the memory; returns its address."""
        at = self._free
        self._free += -(-int(np.prod(shape)) * np.dtype(kind).itemsize // 8) * 8
        lacking = self._free - self._memory.data_len(self._store)
        if lacking > 0:
            self._memory.grow(self._store, -(-lacking // PAGE))
        return at

    def _array(self, at: int, kind: Any, shape: tuple[int, ...]) -> npt.NDArray[Any]:
        """A view of the memory at an address. Do not keep it: memory moves when it grows."""
        size = self._memory.data_len(self._store)
        everything = np.ctypeslib.as_array(self._memory.data_ptr(self._store), (size,))
        count = int(np.prod(shape)) * np.dtype(kind).itemsize
        view: npt.NDArray[Any] = everything[at : at + count].view(kind).reshape(shape)
        return view
