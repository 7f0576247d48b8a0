"""The oracle keeps its promises: its digits, its paths and its amplification.

The laws are those of the engine, which shares no code with it: test_exact_oracle.py compares them.
"""

import mpmath
import pytest

from benchmarks.scenes.contact_scenes import trial
from plinko.engine.board.parts import Peg
from plinko.engine.constants import (
    KIND_CONTACT_END,
)
from tests.long import tries
from tools.oracle import Event, OracleDrop, OracleError, oracle_drop
from tools.oracle.scenes import scene

mp = mpmath.MPContext()
mp.dps = 70
DIGITS = mp.mpf(10) ** -45  # tolerance at fifty digits


def of_kind(drop: OracleDrop, kind: int) -> list[Event]:
    return [e for e in drop.events if e.kind == kind]


MORE = tries([(8, -0.5807)], [(8, -0.5807), (12, -0.379), (16, 0.0625)])


@pytest.mark.long
@pytest.mark.parametrize(("rows", "x"), MORE)
def test_more_digits_change_nothing_that_fewer_promised(rows: int, x: float) -> None:
    board = trial(rows, 0.5, 0.2, 2.0)
    fewer, more = oracle_drop(board, x), oracle_drop(board, x, dps=90)
    assert len(fewer.events) == len(more.events)
    for a, b, growth in zip(fewer.events, more.events, fewer.amplifications, strict=True):
        promised = mp.mpf(10) ** -55 * max(1.0, *fewer.amplifications)
        assert growth < 1e20
        assert abs(a.x - b.x) + abs(a.y - b.y) + abs(a.t - b.t) < promised
        assert (a.kind, a.index) == (b.kind, b.index)


def test_cutting_dying_bounces_moves_a_slider_by_little() -> None:
    peg = (Peg(0.0, 0.0, 0.4),)
    for friction, apart in ((0.9, 1e-17), (0.02, 1e-8)):
        board = scene(pegs=peg, friction=friction, restitution=0.5)
        ends = [
            of_kind(oracle_drop(board, 0.02, cut=cut), KIND_CONTACT_END)[0] for cut in (1e-8, 1e-20)
        ]
        assert 0 < abs(ends[0].x - ends[1].x) < apart


def test_the_path_is_whole_from_event_to_event() -> None:
    drop = oracle_drop(trial(12, 0.5, 0.2, 2.0), -0.379)
    before = mp.mpf(10) ** -20
    for event in drop.events:
        x, y = drop.position_at(event.t - before)
        assert mp.hypot(x - event.x, y - event.y) < 1e-18
        assert mp.hypot(drop.position_at(event.t)[0] - event.x, 0) < DIGITS
    with pytest.raises(ValueError, match="outside"):
        drop.position_at(-1.0)


def test_the_amplification_is_what_a_moved_start_does() -> None:
    board = trial(12, 0.5, 0.2, 2.0)
    here, there = oracle_drop(board, 0.3595), oracle_drop(board, 0.3595 + 2.0**-50)
    measured = abs(here.x_end - there.x_end) * 2**50
    assert abs(measured / here.amplification - 1) < 1e-5


def test_a_cut_below_the_rounding_is_refused() -> None:
    with pytest.raises(OracleError, match="cut"):
        oracle_drop(scene(), 0.0, cut=1e-60)
