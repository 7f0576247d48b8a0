"""Hashes of blocks: the root does not depend on how they are joined; their number is bounded."""

import random

import pytest

from plinko.engine import merkle
from plinko.engine.batches.hashes import KEPT, BlockHashes, first_in_both


def leaves(count: int) -> list[bytes]:
    return [merkle.leaf_hash(bytes([number % 251, number // 251])) for number in range(count)]


@pytest.mark.parametrize("kept", [1, 2, 3, 8, 1000])
@pytest.mark.parametrize("blocks", [1, 2, 3, 7, 8, 13, 64, 97])
def test_the_root_is_that_of_all_hashes_in_any_order(kept: int, blocks: int) -> None:
    hashes = leaves(blocks)
    order = list(range(blocks))
    random.Random(blocks).shuffle(order)
    one = BlockHashes(blocks, kept)
    for number in order[:-1]:
        one.add(number, hashes[number])
        assert number in one
    assert order[-1] not in one
    assert one.root is None
    one.add(order[-1], hashes[order[-1]])
    assert one.root == merkle.root_of(hashes)
    assert one.runs == [(0, blocks)]
    # The last blocks are too few for a full hash, so their hashes cover half as many blocks each.
    assert len(one.hashes) <= kept + one.level


@pytest.mark.parametrize("kept", [1, 4, 1000])
def test_parts_come_back_from_their_runs_and_merge(kept: int) -> None:
    hashes = leaves(53)
    chosen = set(random.Random(kept).sample(range(53), 30)) | set(range(8, 20))
    one, other = BlockHashes(53, kept), BlockHashes(53, kept)
    for number, digest in enumerate(hashes):
        (one if number in chosen else other).add(number, digest)
    read = BlockHashes(53, kept)
    read.fill(one.runs, one.hashes)
    assert (read.runs, read.hashes, read.count) == (one.runs, one.hashes, len(chosen))
    assert {number for begin, end in read.runs for number in range(begin, end)} == chosen
    assert {number for number in range(53) if number in read} == chosen
    read.merge(other)
    assert read.root == merkle.root_of(hashes)


def test_runs_and_hashes_that_do_not_belong_together_are_refused() -> None:
    for count in (2, 4):
        with pytest.raises(ValueError, match="zip"):
            BlockHashes(10).fill([(0, 3)], leaves(count))


def test_a_block_has_its_own_hash_up_to_so_many() -> None:
    assert BlockHashes(KEPT).level == 0
    assert BlockHashes(KEPT + 1).level == 1
    # 10^12 drops: sixty-four blocks share a hash, and checking them takes about a core minute.
    most = BlockHashes(-(-(10**12) // 65_536))
    assert most.level == 6
    assert most.blocks >> most.level < KEPT
    one = BlockHashes(3)
    one.add(1, leaves(2)[1])
    assert (one.of(0), one.of(1)) == (None, leaves(2)[1])


def test_what_is_in_both_is_found() -> None:
    assert first_in_both([(0, 3), (7, 9)], [(3, 7), (9, 12)]) is None
    assert first_in_both([(0, 3), (7, 9)], [(3, 8)]) == 7
    assert first_in_both([(5, 6)], [(0, 20)]) == 5
    assert first_in_both([], [(0, 20)]) is None
