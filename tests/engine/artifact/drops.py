"""Drops that every host of the artifact must reproduce bit for bit."""

from collections.abc import Iterator
from typing import Any

from benchmarks.scenes.random_boards import random_board
from plinko.engine import Board, drop
from tests.kit.presets import SAMPLE
from tests.long import tries

PRESET_SEEDS = tries(10, 500)
RANDOM_BOARDS = tries(20, 200)
RANDOM_SEEDS = tries(5, 20)


def played() -> Iterator[tuple[Board, int]]:
    """Each board, and the number of its seeds to compare."""
    for name in SAMPLE:
        yield Board.preset(name), PRESET_SEEDS
    for number in range(RANDOM_BOARDS):
        yield random_board(number), RANDOM_SEEDS


def cases() -> list[dict[str, Any]]:
    """For JSON: boards, their digests, and the digests of their drops with the seeds 0, 1, 2 …"""
    return [
        {
            "board": board.to_dict(),
            "board_digest": board.digest,
            "digests": [drop(board, seed).digest for seed in range(count)],
        }
        for board, count in played()
    ]
