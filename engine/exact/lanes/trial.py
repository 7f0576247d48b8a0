"""Tests native code on this machine: its drops must have the same bits as WebAssembly's."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from threading import Lock
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.lanes.trace import Code, Drops, trace_drops
from plinko.engine.exact.outcome import MAX_EVENTS, new_results
from plinko.engine.jit import native
from plinko.engine.seeding import start_xs

DROPS: Final = 2000
"""Drops on each board: some 30,000 impacts, a tenth of a second in all."""

NONE: Final[Mapping[str, Code]] = {}

_log = logging.getLogger(__name__)
_alone: Final = Lock()


def trusted() -> Mapping[str, Code]:
    """Native code of the lanes, for `trace_drops`; empty if WebAssembly must run.

    The first call in a process tests the code, and logs why it is not used.
    """
    if native.is_forbidden():
        return NONE
    with _alone:
        return _tried()


@cache
def _tried() -> Mapping[str, Code]:
    try:
        code = native.load()
    except native.NoNativeCodeError as reason:
        _log.info("batches are computed by WebAssembly: %s", reason)
        return NONE
    for board in _boards():
        if not agree(board, code):
            _log.warning(
                "batches are computed by WebAssembly: native code gives other bits on %s",
                board.name,
            )
            return NONE
    return code


def _boards() -> tuple[Board, ...]:
    """A board with drag and friction, one with much contact, and one without drag and friction."""
    board = Board.preset("triangle-12")
    plain = replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))
    return Board.preset("triangle-16"), Board.preset("classic"), plain


def agree(board: Board, code: Mapping[str, Code]) -> bool:
    """Whether native code and WebAssembly give the same bits for DROPS drops on a board."""
    return _outcomes(board, NONE) == _outcomes(board, code)


def _outcomes(board: Board, code: Mapping[str, Code]) -> list[bytes]:
    xs = start_xs(np.arange(DROPS, dtype=np.uint64), board.drop.x, board.drop.jitter)
    results = new_results(DROPS)
    trace_drops(arrays_of(board), Drops(xs, board.drop.y, MAX_EVENTS, MAX_TIME), results, code)
    columns: tuple[npt.NDArray[Any], ...] = results
    return [column.tobytes() for column in columns]
