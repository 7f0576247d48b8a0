"""The hashes of those blocks of a job that were computed; beyond so many, one stands for several.

They are leaves of a Merkle tree (`engine.merkle`). Where two siblings are there, their parent takes
their place, up to a level that follows from the number of blocks: the root is the same, and memory
that of `KEPT` hashes.
"""

from collections.abc import Iterable, Iterator
from functools import reduce
from itertools import pairwise
from typing import Final

from engine.merkle import Node, node_hash, root_of

KEPT: Final = 1 << 18
"""Hashes of a whole job at most: 17 MB as JSON. Up to 1.7e10 drops each block has its own."""

Runs = list[tuple[int, int]]
"""Blocks, as each run's first and the one after its last, in order."""


class BlockHashes:
    """Hashes of some of the blocks 0 to `blocks` - 1; each stands for up to 2^`level` of them."""

    def __init__(self, blocks: int, kept: int = KEPT) -> None:
        self.blocks = blocks
        self.level = (-(-blocks // kept) - 1).bit_length()
        self.count = 0  # blocks that they stand for
        self._nodes: dict[Node, bytes] = {}

    def __contains__(self, number: int) -> bool:
        """Whether a block was counted."""
        return any((level, number >> level) in self._nodes for level in range(self.level + 1))

    def add(self, number: int, digest: bytes) -> None:
        """Take the hash of a block that was not counted yet."""
        self._add((0, number), digest)

    def merge(self, other: "BlockHashes") -> None:
        """Take the hashes of other blocks of the same job."""
        for node, digest in other._nodes.items():
            self._add(node, digest)

    def fill(self, runs: Runs, hashes: Iterable[bytes]) -> None:
        """Take what `runs` and `hashes` gave; ValueError where there are more of one than fit."""
        nodes = (node for run in runs for node in self._nodes_of(*run))
        for node, digest in zip(nodes, hashes, strict=True):
            self._add(node, digest)

    def of(self, number: int) -> bytes | None:
        """The hash of one block; None if it was not counted, or is kept with others alone."""
        return self._nodes.get((0, number))

    @property
    def hashes(self) -> list[bytes]:
        """All that are kept, in the order of their blocks."""
        return [self._nodes[node] for node in self._in_order()]

    @property
    def runs(self) -> Runs:
        """The blocks that were counted."""
        found: Runs = []
        for level, number in self._in_order():
            begin, end = number << level, number + 1 << level
            if found and found[-1][1] == begin:
                begin, _ = found.pop()
            found.append((begin, end))
        return found

    @property
    def root(self) -> bytes | None:
        """The root over all blocks; None while some miss."""
        if self.count != self.blocks:
            return None
        tops = [node for node in self._in_order() if node[0] == self.level]
        whole = [self._nodes[node] for node in tops]
        last = self.hashes[len(tops) :]  # subtrees of the last blocks, each larger than the next
        if last:
            whole.append(reduce(lambda right, left: node_hash(left, right), reversed(last)))
        return root_of(whole)

    def _add(self, node: Node, digest: bytes) -> None:
        level, number = node
        self.count += 1 << level
        while level < self.level and (level, number ^ 1) in self._nodes:
            sibling = self._nodes.pop((level, number ^ 1))
            digest = node_hash(sibling, digest) if number & 1 else node_hash(digest, sibling)
            level, number = level + 1, number >> 1
        self._nodes[level, number] = digest

    def _in_order(self) -> list[Node]:
        return sorted(self._nodes, key=lambda node: node[1] << node[0])

    def _nodes_of(self, begin: int, end: int) -> Iterator[Node]:
        """The subtrees that stand for a run when all of it was added."""
        while begin < end:
            level = min(self.level, (end - begin).bit_length() - 1)
            while begin & ((1 << level) - 1):
                level -= 1
            yield level, begin >> level
            begin += 1 << level


def first_in_both(one: Runs, other: Runs) -> int | None:
    """The first block that is in runs of both; None where there is none."""
    ahead = sorted([*one, *other])
    both = (begin for (_, end), (begin, _) in pairwise(ahead) if begin < end)
    return next(both, None)
