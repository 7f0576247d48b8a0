"""Compute a drop's seed from two secrets, so that neither player nor server can choose it.

The player commits to a secret. Then the server draws its own and commits to it. Then the player
opens theirs. Each secret is thus fixed before the other is known. See docs/fairness.md.
"""

import hashlib
import hmac
from typing import Final

from plinko.app.errors import InvalidValueError
from plinko.engine.errors import shorten
from plinko.engine.seeding import SEED_LIMIT

SECRET_BYTES: Final = 32

# Different prefixes, so that an HMAC for one purpose is useless for another.
_DOMAIN: Final = b"plinko drop 1\n"
_DRAW_DOMAIN: Final = b"plinko draw 1\n"


def parse_hex(value: object, field: str, size: int = SECRET_BYTES) -> bytes:
    """Parse `size` bytes in hexadecimal; raises InvalidValueError if `value` is invalid."""
    if isinstance(value, str) and len(value) == 2 * size and value.isascii() and value.isalnum():
        try:
            return bytes.fromhex(value)
        except ValueError:
            pass  # raised below, with all other invalid values
    raise InvalidValueError(
        f"{field} {shorten(value)} is not {2 * size} hexadecimal digits", field=field
    )


def commitment(secret: bytes) -> bytes:
    """The hash that a side publishes before it opens its secret: SHA-256, 32 bytes."""
    return hashlib.sha256(secret).digest()


def drop_mac(server_seed: bytes, client_seed: bytes, number: int, board_digest: bytes) -> bytes:
    """HMAC-SHA256 of all inputs of drop `number`, with the server's seed as the key."""
    return _mac(_DOMAIN, server_seed, client_seed, number, board_digest)


def draw_mac(server_seed: bytes, client_seed: bytes, number: int, board_digest: bytes) -> bytes:
    """Like `drop_mac`, for a room with a draw; `Draw.pick` makes a bin and a seed from it."""
    return _mac(_DRAW_DOMAIN, server_seed, client_seed, number, board_digest)


def _mac(
    domain: bytes, server_seed: bytes, client_seed: bytes, number: int, board_digest: bytes
) -> bytes:
    message = domain + client_seed + number.to_bytes(8, "big") + board_digest
    return hmac.digest(server_seed, message, hashlib.sha256)


def drop_seed(server_seed: bytes, client_seed: bytes, number: int, board_digest: bytes) -> int:
    """The seed of drop `number` of a session, counted from 0: the first 64 bits of its HMAC."""
    first = drop_mac(server_seed, client_seed, number, board_digest)[:8]
    seed = int.from_bytes(first, "big")
    assert seed < SEED_LIMIT
    return seed
