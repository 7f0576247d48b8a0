"""Statistical tests of the generator that draws the starts of staked drops.

`python -m tools.fairness.generator BOARD DROPS PAIRS` prints a run as JSON, such as
docs/conformance.json: the tests of DROPS starts, and PAIRS drops compared with their mirror images.

The drops are drawn like those of fair sessions: HMAC-SHA256 of both secrets gives a drop's seed,
and SplitMix64 of the seed gives the start. Here the secrets are made from the session's number, so
that a run can be repeated.
"""

import hashlib
import json
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from math import sqrt
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.fairness.seeds import drop_seed
from plinko.engine import Board
from plinko.engine.seeding import start_xs
from tools.fairness import chances
from tools.fairness.chances import Outcome
from tools.fairness.mirror import check_mirror

LEVEL: Final = 0.01
"""Probability that a good generator fails any of the tests: 99 % confidence for all together."""

DROPS_PER_SESSION: Final = 1000
SESSIONS_AT_ONCE: Final = 64  # an even number: sessions are compared in pairs
LEAST_DROPS: Final = DROPS_PER_SESSION * SESSIONS_AT_ONCE

_CELLS: Final = 4096  # of the range of starts; a power of two: a cell is given by leading bits
_SIDE: Final = 64  # cells in each direction, for pairs of starts
_ODD_CELLS: Final = 1000  # not a power of two: shows a bias of the scaling to [-jitter, jitter)
_BYTES: Final = 256

Words = npt.NDArray[np.uint64]
Counts = npt.NDArray[np.int64]


def session_seeds(session: int, board: Board) -> Words:
    """The seeds of the drops of session number `session`, shape (DROPS_PER_SESSION,)."""
    server = hashlib.sha256(b"plinko conformance server %d" % session).digest()
    client = hashlib.sha256(b"plinko conformance client %d" % session).digest()
    digest = bytes.fromhex(board.digest)
    seeds = [drop_seed(server, client, number, digest) for number in range(DROPS_PER_SESSION)]
    return np.array(seeds, np.uint64)


@dataclass(slots=True)
class Tally:
    """The counts of the tests, summed block by block of sessions."""

    board: Board
    drops: int = 0
    bytes: Counts = field(default_factory=lambda: np.zeros((8, _BYTES), np.int64))
    starts: Counts = field(default_factory=lambda: np.zeros(_CELLS, np.int64))
    scaled: Counts = field(default_factory=lambda: np.zeros(_ODD_CELLS, np.int64))
    drop_pairs: Counts = field(default_factory=lambda: np.zeros(_SIDE * _SIDE, np.int64))
    session_pairs: Counts = field(default_factory=lambda: np.zeros(_SIDE * _SIDE, np.int64))
    product: float = 0.0  # sum of the products of consecutive starts, each in [-1, 1)
    neighbours: int = 0  # pairs of consecutive starts
    changes: int = 0  # of side, between consecutive drops
    outside: int = 0  # starts outside [-jitter, jitter)

    def add(self, seeds: Words) -> None:
        """Count the seeds of some sessions, shape (sessions, drops), both even."""
        self.drops += seeds.size
        for place, column in enumerate(seeds.reshape(-1, 1).view(np.uint8).T):
            self.bytes[place] += np.bincount(column, minlength=_BYTES)
        unit = start_xs(seeds, 0.0, 1.0)
        self.starts += _cells(unit, _CELLS)
        self._scale(seeds)
        cell = ((unit + 1.0) * (_SIDE / 2)).astype(np.int64)
        self.drop_pairs += _pairs(cell[:, 0::2], cell[:, 1::2])
        self.session_pairs += _pairs(cell[0::2], cell[1::2])
        self.product += float((unit[:, :-1] * unit[:, 1:]).sum())
        self.neighbours += unit[:, 1:].size
        self.changes += int(np.count_nonzero((unit[:, :-1] < 0.0) != (unit[:, 1:] < 0.0)))

    @property
    def bits(self) -> Counts:
        """How often each bit of the seeds is set, shape (64,), from the counts of bytes."""
        values = np.arange(_BYTES)
        return np.concatenate([self.bytes @ (values >> bit & 1) for bit in range(8)])

    def _scale(self, seeds: Words) -> None:
        """Count the starts on this board, computed by the same function as in drops."""
        jitter = self.board.drop.jitter
        starts = start_xs(seeds, self.board.drop.x, jitter) - self.board.drop.x
        self.outside += int(np.count_nonzero((starts < -jitter) | (starts >= jitter)))
        self.scaled += _cells(starts / jitter, _ODD_CELLS)

    def outcomes(self) -> list[Outcome]:
        """Evaluate each test; needs at least one block."""
        steps = self.neighbours
        return [
            chances.even_odds("each bit of the seeds is set half the time", self.bits, self.drops),
            *(
                chances.chi_square(f"byte {place} of the seeds is uniform", counts)
                for place, counts in enumerate(self.bytes)
            ),
            chances.chi_square("starts are uniform", self.starts),
            chances.chi_square("starts scaled to the board are uniform", self.scaled),
            chances.chi_square("consecutive drops are independent", self.drop_pairs),
            chances.chi_square("consecutive sessions are independent", self.session_pairs),
            # Each product of two independent uniform values in [-1, 1) has variance 1/9.
            chances.normal("neighbours are uncorrelated", 3.0 * self.product / sqrt(steps)),
            chances.normal("runs of sides are as long as a coin's", _coin(self.changes, steps)),
        ]


@dataclass(frozen=True, slots=True)
class Report:
    """The outcomes of all tests over `drops` drops on one board."""

    board: str
    board_digest: str
    drops: int
    level: float
    outside: int
    outcomes: tuple[Outcome, ...]

    @property
    def failed(self) -> list[Outcome]:
        """The tests that fail, at LEVEL for all of them together."""
        return chances.rejected(self.outcomes, self.level)

    @property
    def good(self) -> bool:
        """Whether no test fails and no start lies outside the board's range."""
        return not self.failed and not self.outside

    def to_dict(self) -> dict[str, object]:
        tests = [asdict(each) for each in self.outcomes]
        return {
            "board": self.board,
            "board_digest": self.board_digest,
            "drops": self.drops,
            "level": self.level,
            "outside": self.outside,
            "tests": tests,
            "failed": [each.name for each in self.failed],
            "good": self.good,
        }


def check_generator(
    board: Board,
    drops: int,
    seeds_of: Callable[[int, Board], Words] = session_seeds,
) -> Report:
    """Test `drops` drops on `board`, rounded up to whole blocks of sessions.

    seeds_of: gives the seeds of the session with this number. The board needs jitter.
    """
    tally = Tally(board)
    first = 0
    while tally.drops < drops:
        block = range(first, first + SESSIONS_AT_ONCE)
        tally.add(np.stack([seeds_of(session, board) for session in block]))
        first += SESSIONS_AT_ONCE
    return Report(
        board.name, board.digest, tally.drops, LEVEL, tally.outside, tuple(tally.outcomes())
    )


def _cells(values: npt.NDArray[np.float64], count: int) -> Counts:
    """Count `values` in `count` equal cells of [-1, 1); values outside count in the end cells."""
    place = np.clip((values + 1.0) * (count / 2), 0, count - 1).astype(np.int64)
    return np.bincount(place.ravel(), minlength=count)


def _pairs(one: Counts, other: Counts) -> Counts:
    return np.bincount((one * _SIDE + other).ravel(), minlength=_SIDE * _SIDE)


def _coin(hits: int, tries: int) -> float:
    return (hits - tries / 2.0) / sqrt(tries / 4.0)


def _run(name: str, drops: int, pairs: int) -> dict[str, object]:
    """A whole run on a preset, as docs/conformance.json has it."""
    board = Board.preset(name)
    report, unlike = check_generator(board, drops), check_mirror(board, pairs)
    mirror = {"pairs": pairs, "unlike": unlike}
    return {**report.to_dict(), "mirror": mirror, "good": report.good and not unlike}


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])), indent=1))
