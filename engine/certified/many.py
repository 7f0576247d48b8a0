"""Measures how many double-precision bins are right, by proving those that are not certain."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from plinko.engine.board.model import Board
from plinko.engine.certified.certify import certify_start, exact_start
from plinko.engine.drops.drop import make_drop
from plinko.engine.parameters import Exact
from plinko.engine.seeding import parse_seed


@dataclass(slots=True)
class Share:
    """How many double-precision bins were right.

    certain: drops that the tangent estimate calls certain; by default they are not proven. right,
    wrong: proven drops whose double-precision bin agrees with the proof, or does not. undecided:
    drops whose proof reached its limits.
    """

    drops: int = 0
    certain: int = 0
    right: int = 0
    wrong: int = 0
    undecided: int = 0
    certain_but_wrong: int = 0
    """Wrong drops that were called certain; always 0 unless all drops are proven."""

    @property
    def proven(self) -> int:
        return self.right + self.wrong

    @property
    def share_right(self) -> float:
        """Share of drops whose double-precision bin is right: proven, or called certain."""
        return 1.0 - (self.wrong + self.undecided) / self.drops

    def to_dict(self) -> dict[str, Any]:
        return {
            "certain": self.certain,
            "proven": self.proven,
            "right": self.right,
            "wrong": self.wrong,
            "undecided": self.undecided,
            "share_right": self.share_right,
        }


def certify_many(board: Board, seeds: Iterable[int], *, everything: bool = False) -> Share:
    """Count the `seeds` whose double-precision bin is the proven one.

    Drops that are `Drop.certain` are proven only if `everything` is true.
    """
    share = Share()
    for seed in seeds:
        drop = make_drop(board, parse_seed(seed), None, Exact())
        share.drops += 1
        certain = drop.certain
        share.certain += certain
        if everything or not certain:
            proof = certify_start(board, seed, exact_start(drop.x_start))
            if not proof.decided:
                share.undecided += 1
            elif proof.agrees:
                share.right += 1
            else:
                share.wrong += 1
                share.certain_but_wrong += certain
    return share
