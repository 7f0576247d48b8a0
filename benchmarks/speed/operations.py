"""Counts the floating-point operations of the exact solver.

The solver runs uncompiled, on numbers that count their operations. This takes a separate process,
because the kernels have to be imported with the JIT off.
"""

import json
import math
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

KINDS = ("add", "multiply", "divide", "root")
LABELS = ("+ and -", "×", "÷", "√")

COUNTS: Counter[str] = Counter()

_PROGRAM = """
import json, sys
from benchmarks.speed import operations
print(json.dumps(operations.count(sys.stdin.read(), int(sys.argv[1]))))
"""


class Counting(float):
    """A float that counts arithmetic on it; its results are such floats too."""

    __slots__ = ()


def _counted(name: str, kind: str) -> Any:
    plain = getattr(float, name)

    def method(self: float, other: float) -> Any:
        COUNTS[kind] += 1
        return Counting(plain(self, float(other)))

    return method


for _name, _kind in (("add", "add"), ("sub", "add"), ("mul", "multiply"), ("truediv", "divide")):
    for _method in (f"__{_name}__", f"__r{_name}__"):
        setattr(Counting, _method, _counted(_method, _kind))
Counting.__neg__ = lambda self: Counting(float.__neg__(self))  # type: ignore[method-assign]
Counting.__abs__ = lambda self: Counting(float.__abs__(self))  # type: ignore[method-assign]


def counting_root(value: float) -> Counting:
    """The square root, counted."""
    COUNTS["root"] += 1
    return Counting(math.sqrt(value))


class _CountingNumpy:
    """numpy, but its new arrays of floats consist of counting numbers."""

    def __init__(self, numpy: Any) -> None:
        self._numpy = numpy

    def __getattr__(self, name: str) -> Any:
        return getattr(self._numpy, name)

    def zeros(self, shape: Any, dtype: Any = float) -> Any:
        return self._full(shape, dtype, 0.0)

    def empty(self, shape: Any, dtype: Any = float) -> Any:
        """Like numpy's, but filled with zeros."""
        return self._full(shape, dtype, 0.0)

    def _full(self, shape: Any, dtype: Any, value: float) -> Any:
        if self._numpy.dtype(dtype).kind != "f":
            return self._numpy.zeros(shape, dtype)
        return self._numpy.full(shape, Counting(value), object)


def counting(value: Any) -> Any:
    """`value` with counting floats in place of floats, also in arrays and named tuples."""
    import numpy as np

    if isinstance(value, float):
        return Counting(value)
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        flat = [Counting(x) for x in value.ravel().tolist()]
        made = np.empty(len(flat), object)
        made[:] = flat
        return made.reshape(value.shape)
    if isinstance(value, tuple) and hasattr(value, "_make"):
        return value._make(counting(part) for part in value)
    return value


def count(board_json: str, drops: int) -> dict[str, float]:
    """Operations of each kind per impact, over some drops one by one; needs the JIT off."""
    import numpy as np

    from plinko.engine import Board
    from plinko.engine.constants import MAX_TIME
    from plinko.engine.exact import event_log, initial_state, outcome, trace
    from plinko.engine.exact.board_arrays import arrays_of
    from plinko.engine.physics import contact
    from plinko.engine.seeding import start_xs

    board = Board.from_json(board_json)
    arrays = counting(arrays_of(board))
    seeds = np.arange(drops, dtype=np.uint64)
    states = initial_state.at_rest(start_xs(seeds, board.drop.x, board.drop.jitter), board.drop.y)
    for name, module in list(sys.modules.items()):
        if name.startswith(("plinko.engine.physics", "plinko.engine.exact")):
            for attribute, replacement in (("sqrt", counting_root), ("np", _CountingNumpy(np))):
                if hasattr(module, attribute):
                    setattr(module, attribute, replacement)
    COUNTS.clear()
    impacts = np.zeros(drops, np.int32)
    trace.trace_many(
        arrays, counting(states), initial_state.in_flight(drops), outcome.MAX_EVENTS,
        MAX_TIME, contact.new_series(), event_log.new_log(0, 0),
        np.zeros(drops, np.int8), np.zeros(drops, np.int32), impacts,
    )  # fmt: skip
    return {kind: COUNTS[kind] / int(impacts.sum()) for kind in KINDS}


def count_apart(board_json: str, drops: int) -> dict[str, float]:
    """Run `count` in a new process with the JIT off."""
    found = subprocess.run(
        [sys.executable, "-c", _PROGRAM, str(drops)],
        input=board_json,
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[2],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )
    counts: dict[str, float] = json.loads(found.stdout)
    return counts
