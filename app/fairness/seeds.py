"""Two secret seeds, what each side commits to, and the seed of a drop that neither could choose.

The player commits to one secret before the server draws its own, and opens it after the server has
committed: each is fixed before the other is known. See docs/fairness.md.
"""

import hashlib
import hmac
from typing import Final

from app.errors import InvalidValueError, shorten
from engine.seeding import SEED_LIMIT

SECRET_BYTES: Final = 32

DIGEST_BYTES: Final = 32

# So that an HMAC of one kind is no other's.
_DOMAIN: Final = b"plinko drop 1\n"
_DRAW_DOMAIN: Final = b"plinko draw 1\n"


def parse_hex(value: object, field: str, size: int = SECRET_BYTES) -> bytes:
    """`size` bytes from their hexadecimal digits; raises InvalidValueError naming what is none."""
    if isinstance(value, str) and len(value) == 2 * size and value.isascii() and value.isalnum():
        try:
            return bytes.fromhex(value)
        except ValueError:
            pass  # said below, for all that is no hexadecimal
    raise InvalidValueError(
        f"{field} {shorten(value)} is not {2 * size} hexadecimal digits", field=field
    )


def commitment(secret: bytes) -> bytes:
    """What a side publishes of its secret before it opens it: SHA-256, 32 bytes."""
    return hashlib.sha256(secret).digest()


def drop_mac(server_seed: bytes, client_seed: bytes, number: int, board_digest: bytes) -> bytes:
    """HMAC-SHA256 keyed with the server's seed, of all else that drop `number` depends on."""
    return _mac(_DOMAIN, server_seed, client_seed, number, board_digest)


def draw_mac(server_seed: bytes, client_seed: bytes, number: int, board_digest: bytes) -> bytes:
    """`drop_mac` of a room with a draw: what draws the bin and one of its seeds, see Draw.pick."""
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
