"""The hashes of a job's computed blocks, in bounded memory.

They are leaves of a Merkle tree (`plinko.engine.merkle`). In a large job, two siblings are replaced
by their parent, up to a level that depends on the number of blocks. The root stays the same, and at
most about `KEPT` hashes remain.
"""

from collections.abc import Iterable, Iterator
from functools import reduce
from itertools import pairwise
from typing import Final

from plinko.engine.merkle import Node, node_hash, root_of

KEPT: Final = 1 << 18
"""Most hashes of a complete job, 17 MB as JSON. Up to 1.7e10 drops every block keeps its own."""

Runs = list[tuple[int, int]]
"""Runs of blocks in order, each as the first block and the one after the last."""


class BlockHashes:
    """Hashes of some of the blocks 0 to `blocks` - 1; one hash covers up to 2^`level` blocks."""

    def __init__(self, blocks: int, kept: int = KEPT) -> None:
        self.blocks = blocks
        self.level = (-(-blocks // kept) - 1).bit_length()
        self.count = 0  # blocks that were added
        self._nodes: dict[Node, bytes] = {}

    def __contains__(self, number: int) -> bool:
        return any((level, number >> level) in self._nodes for level in range(self.level + 1))

    def add(self, number: int, digest: bytes) -> None:
        """Add the hash of a block that was not added before."""
        self._add((0, number), digest)

    def merge(self, other: "BlockHashes") -> None:
        """Add all hashes of `other`, which must have other blocks of the same job."""
        for node, digest in other._nodes.items():
            self._add(node, digest)

    def fill(self, runs: Runs, hashes: Iterable[bytes]) -> None:
        """Restore from saved `runs` and `hashes`; ValueError if their numbers do not match."""
        nodes = (node for run in runs for node in self._nodes_of(*run))
        for node, digest in zip(nodes, hashes, strict=True):
            self._add(node, digest)

    def of(self, number: int) -> bytes | None:
        """The hash of one block; None if it was not added, or was merged into a parent's."""
        return self._nodes.get((0, number))

    @property
    def hashes(self) -> list[bytes]:
        return [self._nodes[node] for node in self._in_order()]

    @property
    def runs(self) -> Runs:
        found: Runs = []
        for level, number in self._in_order():
            begin, end = number << level, number + 1 << level
            if found and found[-1][1] == begin:
                begin, _ = found.pop()
            found.append((begin, end))
        return found

    @property
    def root(self) -> bytes | None:
        """The Merkle root over all blocks; None while blocks are missing."""
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
        """The tree nodes that remain after all blocks of a run were added."""
        while begin < end:
            level = min(self.level, (end - begin).bit_length() - 1)
            while begin & ((1 << level) - 1):
                level -= 1
            yield level, begin >> level
            begin += 1 << level


def first_in_both(one: Runs, other: Runs) -> int | None:
    """The first block that is in both; None if they have no block in common."""
    ahead = sorted([*one, *other])
    both = (begin for (_, end), (begin, _) in pairwise(ahead) if begin < end)
    return next(both, None)
