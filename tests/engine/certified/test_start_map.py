"""The map of starts: each pixel is the proven bin of its start, at any zoom."""

from fractions import Fraction

import pytest

from plinko.engine import ParameterError, certify
from plinko.engine.board.parts import Bins, Peg
from plinko.engine.certified.start_map import DEEPEST, OUTSIDE, strip_at, widest
from tools.oracle.scenes import scene

BOARD = scene(
    pegs=(Peg(0.0, 0.0, 0.05), Peg(-0.4, 0.6, 0.05), Peg(0.4, 0.6, 0.05)),
    restitution=0.5,
    drag=0.3,
    bins=Bins(2.0, (-50.0, -0.5, 0.0, 0.5, 50.0), (1.0,) * 4),
)


def test_a_pixel_is_the_proven_bin_of_its_middle() -> None:
    strip = strip_at(BOARD, "0.01", 2, 8)
    width = widest(BOARD) / 100
    left = Fraction(1, 100) - width / 2
    assert (strip.width, strip.x) == (width, Fraction(1, 100))
    for number in (0, 5):
        middle = left + width * (2 * number + 1) / 16
        assert strip.bins[number] == certify(BOARD, x=middle).bin
    assert strip.proofs >= 8


def test_deep_zooms_are_proven_whole() -> None:
    """One proof covers all starts in a strip that is far narrower than float64 can resolve."""
    strip = strip_at(BOARD, "0.01", DEEPEST, 64)
    assert set(strip.bins) == {certify(BOARD, x="0.01").bin}
    assert (strip.proofs, strip.whole) == (1, 64)


def test_what_is_no_start_is_left_out() -> None:
    edge = Fraction(BOARD.drop.x) + Fraction(BOARD.drop.span)
    strip = strip_at(BOARD, edge, 8, 2)
    assert strip.bins[1] == OUTSIDE
    assert strip.bins[0] >= 0


@pytest.mark.parametrize("level", [41, -1])
def test_a_level_out_of_range_is_named(level: int) -> None:
    with pytest.raises(ParameterError, match=f"level {level}"):
        strip_at(BOARD, 0, level, 8)
