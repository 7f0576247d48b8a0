"""The Merkle tree of RFC 6962: its root, and proofs that it contains a leaf or only grew.

A tree is stored as the hashes of its complete subtrees. The subtree (level, number) spans the
2^level leaves from number * 2^level on. Its hash never changes, so a log grows by adding hashes,
and a proof needs a few dozen of them. The checks of proofs are the algorithms of RFC 9162.
"""

import hashlib
from collections.abc import Callable, Sequence

Node = tuple[int, int]
"""Level and number of a complete subtree."""

Lookup = Callable[[int, int], bytes]
"""Returns the stored hash of a complete subtree, given its level and number."""


def leaf_hash(leaf: bytes) -> bytes:
    return hashlib.sha256(b"\x00" + leaf).digest()


def node_hash(left: bytes, right: bytes) -> bytes:
    return hashlib.sha256(b"\x01" + left + right).digest()


def added(size: int, leaf: bytes, lookup: Lookup) -> list[tuple[Node, bytes]]:
    """The complete subtrees that `leaf` adds to a log of `size` leaves."""
    level, digest = 0, leaf_hash(leaf)
    found = [((level, size), digest)]
    while size >> level & 1:
        digest = node_hash(lookup(level, (size >> level) - 1), digest)
        level += 1
        found.append(((level, size >> level), digest))
    return found


def root(size: int, lookup: Lookup) -> bytes:
    """The root of the first `size` leaves."""
    return _over(0, size, lookup) if size else hashlib.sha256().digest()


def root_of(hashes: Sequence[bytes]) -> bytes:
    """The root of a tree, from the hashes of all its leaves."""
    if not hashes:
        return hashlib.sha256().digest()
    row = list(hashes)
    while len(row) > 1:
        odd = row[len(row) & ~1 :]  # a last node without a sibling moves up a level unchanged
        row = [*map(node_hash, row[0:-1:2], row[1::2]), *odd]
    return row[0]


def inclusion(index: int, size: int, lookup: Lookup) -> list[bytes]:
    """A proof that leaf `index` is in the tree of the first `size` leaves."""
    return _inclusion(index, 0, size, lookup)


def consistency(first: int, second: int, lookup: Lookup) -> list[bytes]:
    """A proof that the tree of `second` leaves begins with the tree of `first` > 0 leaves."""
    return _consistency(first, 0, second, lookup, known=True)


def is_included(
    leaf: bytes, index: int, size: int, proof: Sequence[bytes], expected_root: bytes
) -> bool:
    """Whether `proof` proves that `leaf` is at `index` in the tree of this size and root."""
    if not 0 <= index < size:
        return False
    place, last, digest = index, size - 1, leaf_hash(leaf)
    for sibling in proof:
        if last == 0:
            return False
        if place & 1 or place == last:
            digest = node_hash(sibling, digest)
            while not place & 1 and place:
                place, last = place >> 1, last >> 1
        else:
            digest = node_hash(digest, sibling)
        place, last = place >> 1, last >> 1
    return last == 0 and digest == expected_root


def is_consistent(
    first: int, second: int, first_root: bytes, second_root: bytes, proof: Sequence[bytes]
) -> bool:
    """Whether `proof` proves that the tree of `second` leaves begins with that of `first`."""
    if first == second:
        return not proof and first_root == second_root
    if not 0 < first < second:
        return False
    # If the smaller tree is complete, the proof omits its first node, which is that tree's root.
    path = [first_root, *proof] if first & (first - 1) == 0 else list(proof)
    if not path:
        return False
    place, last = first - 1, second - 1
    while place & 1:
        place, last = place >> 1, last >> 1
    old = new = path[0]
    for sibling in path[1:]:
        if last == 0:
            return False
        if place & 1 or place == last:
            old, new = node_hash(sibling, old), node_hash(sibling, new)
            while not place & 1 and place:
                place, last = place >> 1, last >> 1
        else:
            new = node_hash(new, sibling)
        place, last = place >> 1, last >> 1
    return last == 0 and old == first_root and new == second_root


def _over(begin: int, end: int, lookup: Lookup) -> bytes:
    """The hash over the leaves from `begin` to `end` - 1."""
    count = end - begin
    if count & (count - 1) == 0:
        level = count.bit_length() - 1
        return lookup(level, begin >> level)
    middle = begin + _left(count)
    return node_hash(_over(begin, middle, lookup), _over(middle, end, lookup))


def _left(count: int) -> int:
    """The number of leaves in the left subtree of `count` > 1: the largest power of two below."""
    return 1 << (count - 1).bit_length() - 1


def _inclusion(index: int, begin: int, end: int, lookup: Lookup) -> list[bytes]:
    if end - begin == 1:
        return []
    middle = begin + _left(end - begin)
    if index < middle:
        return [*_inclusion(index, begin, middle, lookup), _over(middle, end, lookup)]
    return [*_inclusion(index, middle, end, lookup), _over(begin, middle, lookup)]


def _consistency(first: int, begin: int, end: int, lookup: Lookup, *, known: bool) -> list[bytes]:
    """The part of the proof for the leaves `begin` to `end` - 1.

    known: whether `begin` is 0. Then a subtree that ends at `first` is the whole smaller tree,
    whose root the checker already has.
    """
    if first == end:
        return [] if known else [_over(begin, end, lookup)]
    middle = begin + _left(end - begin)
    if first <= middle:
        left = _consistency(first, begin, middle, lookup, known=known)
        return [*left, _over(middle, end, lookup)]
    right = _consistency(first, middle, end, lookup, known=False)
    return [*right, _over(begin, middle, lookup)]
