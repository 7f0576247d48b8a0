"""Sign statements of the server with Ed25519 (RFC 8032) over canonical JSON."""

from collections.abc import Mapping

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from plinko.app.rooms.canonical import canonical


class Signer:
    """Signs JSON objects. Each has a `kind`, so that nobody can pass one kind off as another."""

    def __init__(self, secret: bytes) -> None:
        """`secret`: the 32 bytes of the private key."""
        self._key = Ed25519PrivateKey.from_private_bytes(secret)
        self.public: bytes = self._key.public_key().public_bytes_raw()

    def sign(self, value: Mapping[str, object]) -> bytes:
        """The signature of the object's canonical JSON, 64 bytes; deterministic."""
        return self._key.sign(canonical(dict(value)))


def is_signed(value: Mapping[str, object], signature: bytes, public: bytes) -> bool:
    """Whether the owner of the public key made this signature of the object."""
    try:
        Ed25519PublicKey.from_public_bytes(public).verify(signature, canonical(dict(value)))
    except (InvalidSignature, ValueError):  # ValueError: the bytes are not a public key
        return False
    return True
