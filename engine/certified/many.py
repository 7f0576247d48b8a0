"""Many drops, of which those are certified whose double-precision bin is not certain."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from engine.board.model import Board
from engine.certified.certify import FULL, Effort, certify_start, exact_start
from engine.drops.drop import make_drop
from engine.parameters import Exact
from engine.seeding import parse_seed


@dataclass(slots=True)
class Share:
    """How many double-precision bins were right.

    certain: those that the tangent estimate calls certain, and which are not proven unless all
    are. proven: those that are, of which `right` agree and `wrong` do not; `undecided`: those on
    which arithmetic has not decided.
    """

    drops: int = 0
    certain: int = 0
    right: int = 0
    wrong: int = 0
    undecided: int = 0
    certain_but_wrong: int = 0
    """Of the wrong ones, those that were called certain; looked for only where all are proven."""

    @property
    def proven(self) -> int:
        """Drops whose bin is a theorem."""
        return self.right + self.wrong

    @property
    def share_right(self) -> float:
        """Of all drops: those that double precision gets right, where it is known or estimated."""
        return 1.0 - (self.wrong + self.undecided) / self.drops

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "certain": self.certain,
            "proven": self.proven,
            "right": self.right,
            "wrong": self.wrong,
            "undecided": self.undecided,
            "share_right": self.share_right,
        }


def certify_many(
    board: Board,
    seeds: Iterable[int],
    *,
    everything: bool = False,
    effort: Effort = FULL,
    progress: Callable[[int], None] | None = None,
) -> Share:
    """Count how often the double-precision bin of `seeds` is the proven one.

    Those that `Drop.certain` vouches for are proven only if `everything` is asked for. `progress`
    is called with the number of drops done after each.
    """
    share = Share()
    for seed in seeds:
        drop = make_drop(board, parse_seed(seed), None, Exact())
        share.drops += 1
        certain = drop.certain
        share.certain += certain
        if everything or not certain:
            proof = certify_start(board, seed, exact_start(drop.x_start), effort)
            if not proof.decided:
                share.undecided += 1
            elif proof.agrees:
                share.right += 1
            else:
                share.wrong += 1
                share.certain_but_wrong += certain
        if progress is not None:
            progress(share.drops)
    return share
