"""The exports of the page's artifact: kernels of the exact solver that take addresses.

WebAssembly functions take only numbers. So a board, a log and results are blocks of memory, each
with values of one type, and these functions make the kernels' arrays from them. A host fills the
blocks: `static/js/solver/kernels.js`, and `tests/engine/artifact/host.py` in tests.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numba
import numpy as np

from plinko.engine.constants import MAX_TIME
from plinko.engine.exact import event_log, initial_state, sampling, sensitivity, surfaces
from plinko.engine.exact.board_arrays import BoardArrays
from plinko.engine.exact.event_log import Log
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.exact.sensitivity import Space
from plinko.engine.exact.trace import trace_many
from plinko.engine.jit.webassembly import (
    BYTES,
    FLOAT,
    FLOATS,
    INT,
    INTS,
    LONGS,
    WORDS,
    Export,
    further,
    part,
)  # fmt: skip
from plinko.engine.physics import body, contact, surface, tangent

_numba: Any = numba  # its annotations do not cover addresses
carray = _numba.carray
long: Any = np.int64

Address = Any
"""Address of values of one type: FLOATS, WORDS and so on in `plinko.engine.jit.webassembly`."""

NUMBERS: Final = 13
"""Floats in front of a board's surfaces: the fields of BoardArrays that are floats, in order."""

SIZES: Final = 6
"""Words in front of a board's grid: numbers of surfaces, columns, rows, pegs, members and edges."""

_ROWS = contact.ROWS
_TERMS = contact.ORDER + 1
_VARIATION_ROWS = tangent.VARIATION_ROWS


@part
def _board(floats: Address, words: Address) -> BoardArrays:
    """The board whose two blocks begin at these addresses.

    floats: NUMBERS, then surfaces, centres and edges. words: SIZES, then starts, members, heads.
    """
    number = carray(floats, NUMBERS)
    size = carray(words, SIZES)
    item_count = long(size[0])
    columns = long(size[1])
    rows = long(size[2])
    members = long(size[4])
    edges = long(size[5])
    at_items = further(floats, NUMBERS)
    at_centres = further(at_items, item_count * surface.COLUMNS)
    at_starts = further(words, SIZES)
    at_members = further(at_starts, columns * rows + 2)
    return BoardArrays(
        carray(at_items, (item_count, surface.COLUMNS)),
        number[0], number[1], number[2],
        columns, rows,
        carray(at_starts, columns * rows + 2),
        carray(at_members, members),
        carray(further(at_members, members), columns * rows + 1),
        carray(at_centres, (item_count + 1, 3)),
        long(size[3]),
        number[3], number[4], number[5], number[6], number[7], number[8], number[9], number[10],
        number[11], number[12],
        carray(further(at_centres, (item_count + 1) * 3), edges),
    )  # fmt: skip


def lay_out(
    pegs: Address, peg_count: int, walls: Address, wall_count: int, radius: float, items: Address
) -> None:
    """`surfaces.lay_out` of a board's pegs and walls. `items` is filled with zeros before."""
    surfaces.lay_out(
        carray(pegs, (peg_count, 3)),
        carray(walls, (wall_count, 4)),
        radius,
        carray(items, (peg_count + 3 * wall_count, surface.COLUMNS)),
    )


def trace(
    floats: Address,
    words: Address,
    balls: int,
    states: Address,
    initial: Address,
    events: Address,
    marks: Address,
    event_room: int,
    segments: Address,
    segment_room: int,
    counts: Address,
    ends: Address,
    outcomes: Address,
    series: Address,
) -> None:
    """`trace_many` of `balls` balls at the start of their drops.

    `initial` is work space. `ends` receives the bins of all balls, then their impacts.
    """
    begun = carray(initial, (balls, initial_state.COLUMNS))
    for i in range(balls):
        for column in range(initial_state.COLUMNS):
            begun[i, column] = 0
        begun[i, initial_state.HIT] = initial_state.NONE
        begun[i, initial_state.SURFACE] = initial_state.NONE
        begun[i, initial_state.BESIDE] = initial_state.NONE
    log = Log(
        carray(events, (event_room, event_log.EVENT_SIZE)),
        carray(marks, (event_room, 2)),
        carray(segments, (segment_room, event_log.SEGMENT_SIZE)),
        carray(counts, event_log.COUNTS),
        carray(counts, (0, event_log.COUNTS)),
    )
    trace_many(
        _board(floats, words),
        carray(states, (balls, body.SIZE)),
        begun,
        MAX_EVENTS,
        MAX_TIME,
        carray(series, (_ROWS, _TERMS)),
        log,
        carray(outcomes, balls),
        carray(ends, balls),
        carray(further(ends, balls), balls),
    )


def sample(
    floats: Address,
    words: Address,
    segments: Address,
    segment_count: int,
    rows: Address,
    times: Address,
    count: int,
    series: Address,
    out: Address,
) -> None:
    """`sampling.sample` of one ball at `count` times.

    `rows` has a segment's row for each time, then for each time the row after the last.
    """
    sampling.sample(
        _board(floats, words),
        carray(segments, (segment_count, event_log.SEGMENT_SIZE)),
        carray(rows, count),
        carray(further(rows, count), count),
        carray(times, count),
        False,
        carray(series, (_ROWS, _TERMS)),
        carray(out, (count, body.SIZE)),
    )


def certainty(
    floats: Address,
    words: Address,
    segments: Address,
    segment_count: int,
    events: Address,
    marks: Address,
    event_count: int,
    end: Address,
    start_rounding: float,
    space: Address,
    out: Address,
) -> None:
    """`sensitivity.sensitivity` of one drop.

    `space` has the arrays of `Space`, one after another, filled with zeros.
    """
    variation = further(space, _ROWS * _TERMS)
    tangents = further(variation, _VARIATION_ROWS * _TERMS)
    rates = further(tangents, sensitivity.TANGENTS * tangent.TANGENT_SIZE)
    delays = further(rates, tangent.TANGENT_SIZE)
    sensitivity.sensitivity(
        _board(floats, words),
        carray(segments, (segment_count, event_log.SEGMENT_SIZE)),
        carray(events, (event_count, event_log.EVENT_SIZE)),
        carray(marks, (event_count, 2)),
        carray(end, body.SIZE),
        start_rounding,
        Space(
            carray(space, (_ROWS, _TERMS)),
            carray(variation, (_VARIATION_ROWS, _TERMS)),
            carray(tangents, (sensitivity.TANGENTS, tangent.TANGENT_SIZE)),
            carray(rates, tangent.TANGENT_SIZE),
            carray(delays, sensitivity.TANGENTS),
            carray(further(delays, sensitivity.TANGENTS), body.SIZE),
        ),
        carray(out, (event_count, sensitivity.TANGENTS)),
    )


EXPORTS: Final[Mapping[str, Export]] = MappingProxyType(
    {
        "lay_out": Export(lay_out, (FLOATS, INT, FLOATS, INT, FLOAT, FLOATS)),
        "trace": Export(
            trace,
            (
                FLOATS, WORDS, INT, FLOATS, LONGS, FLOATS, INTS, INT, FLOATS, INT, LONGS,
                INTS, BYTES, FLOATS,
            ),
        ),
        "sample": Export(
            sample, (FLOATS, WORDS, FLOATS, INT, LONGS, FLOATS, INT, FLOATS, FLOATS)
        ),
        "certainty": Export(
            certainty,
            (FLOATS, WORDS, FLOATS, INT, FLOATS, INTS, INT, FLOATS, FLOAT, FLOATS, FLOATS),
        ),
    }
)  # fmt: skip
"""The artifact's exports by name, each with its function and its argument types."""
