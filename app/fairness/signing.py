"""Ed25519 (RFC 8032) over canonical JSON: what the server says, so that it cannot be denied."""

from collections.abc import Mapping

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from app.rooms.canonical import canonical


class Signer:
    """Signs JSON objects. Each has a `kind`, so that none can be taken for another."""

    def __init__(self, secret: bytes) -> None:
        """`secret`: the 32 bytes of the private key."""
        self._key = Ed25519PrivateKey.from_private_bytes(secret)
        self.public: bytes = self._key.public_key().public_bytes_raw()

    def sign(self, value: Mapping[str, object]) -> bytes:
        """The signature of the object as canonical JSON, 64 bytes; the same each time."""
        return self.sign_bytes(canonical(dict(value)))

    def sign_bytes(self, message: bytes) -> bytes:
        """The signature of any message, 64 bytes."""
        return self._key.sign(message)


def is_signed(value: Mapping[str, object], signature: bytes, public: bytes) -> bool:
    """Whether this is the signature of the object by the owner of the public key."""
    try:
        Ed25519PublicKey.from_public_bytes(public).verify(signature, canonical(dict(value)))
    except (InvalidSignature, ValueError):  # ValueError: the bytes are no key
        return False
    return True
