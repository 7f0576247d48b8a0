"""A draw: exact odds of bins, with seeds that are checked to land there."""

import random
from typing import Any

import pytest

from plinko.app.errors import InvalidValueError
from plinko.app.fairness.seeds import draw_mac, drop_mac
from plinko.app.rooms.draw import MAX_SEEDS, Draw
from plinko.engine import Board, find_draw

BOARD = Board.preset("triangle-8")
BINS = BOARD.bins.count
EACH = find_draw(BOARD, [1] * BINS, per_bin=2)["seeds"]
LAST = (1 << 128) - 1


def draw_of(weights: list[int]) -> Draw:
    seeds = [listed if weight else [] for weight, listed in zip(weights, EACH, strict=True)]
    return Draw.of(BOARD, weights, seeds)


def mac_of(x: int, y: int = 0) -> bytes:
    return x.to_bytes(16, "big") + y.to_bytes(8, "big") + bytes(8)


def test_a_bin_begins_just_where_the_weights_before_it_end() -> None:
    weights = [0, 3, 0, 0, 4, (1 << 53) - 1, 0, 1, 0]
    draw, total, before = draw_of(weights), sum(weights), 0
    for bin_, weight in enumerate(weights):
        if not weight:
            continue
        # The least x with x * total // 2^128 >= before; `last` is one less than the next bin's.
        first = -(-(before << 128) // total)
        before += weight
        last = -(-(before << 128) // total) - 1
        assert [draw.pick(mac_of(x))[0] for x in (first, last)] == [bin_, bin_]
    assert (before, last) == (total, LAST)
    # A seed is picked evenly from its bin's list.
    draw = draw_of([0, 0, 1, 0, 0, 0, 0, 0, 0])
    first, second = (int(seed) for seed in EACH[2])
    half = 1 << 63
    assert [draw.pick(mac_of(LAST, y))[1] for y in (0, half - 1, half, 2 * half - 1)] == [
        first, first, second, second,
    ]  # fmt: skip


def test_bins_come_as_often_as_their_weights_say() -> None:
    """Chi-square of 20,000 HMACs, 7 degrees of freedom: it exceeds 24.3 once in 1,000 times."""
    weights = [1, 2, 5, 10, 0, 100, 30, 2, 50]
    draw, total, n = draw_of(weights), sum(weights), 20_000
    chance = random.Random(47)
    server, client = chance.randbytes(32), chance.randbytes(32)
    board = bytes.fromhex(BOARD.digest)
    known = (server, client, 5, board)
    assert draw_mac(*known) != drop_mac(*known), "no HMAC means a drop and a draw"
    found = [0] * BINS
    for number in range(n):
        bin_, seed = draw.pick(draw_mac(server, client, number, board))
        assert str(seed) in EACH[bin_]
        found[bin_] += 1
    expected = [n * weight / total for weight in weights]
    assert found[4] == 0
    assert sum((f - e) ** 2 / e for f, e in zip(found, expected, strict=True) if e) < 24.3


def test_its_digest_is_of_weights_seeds_and_board() -> None:
    weights = [1] * BINS
    draw = draw_of(weights)
    assert draw.digest == draw_of(weights).digest
    assert draw.digest != draw_of([2, *weights[1:]]).digest
    fewer = Draw.of(BOARD, weights, [[EACH[0][0]], *EACH[1:]])
    assert draw.digest != fewer.digest
    assert Draw.of_values(BOARD, draw.to_dict()).digest == draw.digest
    ten = {"weights": [1] * 10, "seeds": [["1"]] * 10}
    with pytest.raises(InvalidValueError, match="over board"):
        Draw.of_values(Board.preset("triangle-9"), draw.to_dict() | ten)


SOME: list[Any] = [[seed] for seed, _ in EACH]
EQUAL: list[Any] = [1] * BINS


@pytest.mark.parametrize(
    ("weights", "seeds", "field", "message"),
    [
        ([1] * 8, SOME, "draw.weights", "needs a list of 9"),
        ("1" * 9, SOME, "draw.weights", "needs a list of 9"),
        ([0] * 9, [[]] * 9, "draw.weights", "all 0"),
        ([*EQUAL[:8], -1], SOME, "draw.weights[8]", "is -1"),
        ([1.0, *EQUAL[1:]], SOME, "draw.weights[0]", "is 1.0"),
        ([True, *EQUAL[1:]], SOME, "draw.weights[0]", "is True"),
        ([1 << 53, *EQUAL[1:]], SOME, "draw.weights[0]", "2^53 - 1"),
        (EQUAL, SOME[:8], "draw.seeds", "9 lists"),
        (EQUAL, [*SOME[:8], "12"], "draw.seeds[8]", "not a list"),
        (EQUAL, [*SOME[:8], ["x"]], "draw.seeds[8][0]", "seed 'x'"),
        (EQUAL, [*SOME[:8], [str(1 << 64)]], "draw.seeds[8][0]", "2^64 - 1"),
        (EQUAL, [*SOME[:8], []], "draw.seeds[8]", "at least one seed"),
        ([*EQUAL[:8], 0], SOME, "draw.seeds[8]", "can have no seeds"),
        (EQUAL, [*SOME[:8], ["1"] * MAX_SEEDS], "draw.seeds", "at most 10000"),
    ],
)
def test_an_invalid_draw_is_named(weights: Any, seeds: Any, field: str, message: str) -> None:
    with pytest.raises(InvalidValueError, match=message.replace("^", r"\^")) as refused:
        Draw.of(BOARD, weights, seeds)
    assert refused.value.field == field


def test_each_seed_that_lands_elsewhere_is_named_with_its_place() -> None:
    draw_of(EQUAL).check_seeds()
    moved = [list(listed) for listed in EACH]
    moved[3][1], moved[6][0] = EACH[4][0], EACH[2][1]
    with pytest.raises(InvalidValueError) as refused:
        Draw.of(BOARD, EQUAL, moved).check_seeds()
    assert str(refused.value) == (
        f"draw.seeds[3][1]: the ball of seed {EACH[4][0]} lands in bin 4; "
        f"draw.seeds[6][0]: the ball of seed {EACH[2][1]} lands in bin 2"
    )
    assert refused.value.field == "draw.seeds[3][1]"
    # Of many misplaced seeds it says how many more there are.
    with pytest.raises(InvalidValueError, match=r"and 7 more$"):
        Draw.of(BOARD, EQUAL, [*SOME[:8], [EACH[0][0]] * 17]).check_seeds()
