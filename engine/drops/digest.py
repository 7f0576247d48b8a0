"""The digest of a drop: SHA-256 over a canonical encoding of its inputs and its result.

All numbers little-endian, floats as their raw IEEE 754 bits (a NaN as one fixed value):

    bytes    "plinko drop"
    32 bytes the board's digest
    uint32   PHYSICS_VERSION
    uint8    solver: 0 exact, 1 stepped, then float64 dt, uint32 substeps, float64 correction
    5 x f8   the start: x, y, vx, vy, omega
    uint8    outcome (`plinko.engine.exact.outcome`)
    uint64   number of events, then for each 6 x f8 (t, x, y, vx, vy, omega after it) and
             2 x int32 (kind, index)
"""

import hashlib
import struct
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine import merkle
from plinko.engine.canonical import float_bits
from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.parameters import Solver

_START: Final = struct.Struct("<5dBQ")


def drop_digest(
    board_digest: str,
    solver: Solver,
    start: tuple[float, float, float, float, float],
    outcome: int,
    impacts: npt.NDArray[np.void],
) -> str:
    """Hex digest of one drop.

    start: finite x, y, vx, vy, omega. impacts, shape (n,): the events as encoded above, which is
    the layout of dtype `IMPACT`.
    """
    head = b"plinko drop" + bytes.fromhex(board_digest) + struct.pack("<I", PHYSICS_VERSION)
    begin = _START.pack(*start, outcome, len(impacts))
    digest = hashlib.sha256(head + solver.encoded() + begin)
    digest.update(impacts.data)
    return digest.hexdigest()


_OUTCOME = np.dtype([("bin", "<i4"), ("duration", "<f8"), ("impacts", "<i4"), ("x_end", "<f8")])

BLOCK: Final = 65_536
"""Drops that are hashed together: about 0.2 s on one core, 1.5 MB."""


def outcomes_digest(
    board_digest: str,
    solver: Solver,
    bins: npt.NDArray[np.int32],
    durations: npt.NDArray[np.float64],
    impact_counts: npt.NDArray[np.int32],
    x_ends: npt.NDArray[np.float64],
) -> str:
    """Hex digest of a whole batch in the order of its seeds; all arrays of shape (n,).

    It is the root of the Merkle tree (`plinko.engine.merkle`) over blocks of BLOCK drops; the last
    block may have fewer. An empty batch has one block without rows. A leaf's bytes are: "plinko
    drops", the board's digest, PHYSICS_VERSION and the solver as in a drop's digest, then a row for
    each drop: int32 bin (-1 if it did not land), float64 duration, int32 impacts, float64 x_end.
    """
    head = b"plinko drops" + bytes.fromhex(board_digest) + struct.pack("<I", PHYSICS_VERSION)
    hashes = []
    for first in range(0, max(len(bins), 1), BLOCK):
        part = slice(first, first + BLOCK)
        rows = np.zeros(len(bins[part]), _OUTCOME)
        rows["bin"] = bins[part]
        rows["duration"] = float_bits(durations[part])
        rows["impacts"] = impact_counts[part]
        rows["x_end"] = float_bits(x_ends[part])
        hashes.append(merkle.leaf_hash(head + solver.encoded() + rows.tobytes()))
    return merkle.root_of(hashes).hex()
