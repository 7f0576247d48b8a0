"""A WebSocket message with its frame (RFC 6455, section 5.2), encoded once for all clients."""

import struct
from dataclasses import dataclass, field

_TEXT = 0x81  # FIN and the opcode; a server's frames carry no mask
_BINARY = 0x82
_SHORT = 125  # the longest payload whose length fits the header's second byte
_MEDIUM = 0xFFFF


@dataclass(frozen=True, slots=True)
class WireMessage:
    """A message: its payload, whether it is text, and the unmasked frame."""

    payload: bytes
    text: bool
    wire: bytes = field(compare=False, repr=False)

    @classmethod
    def of_text(cls, payload: bytes) -> "WireMessage":
        """A text message; `payload` is UTF-8."""
        return cls(payload, True, _header(_TEXT, len(payload)) + payload)

    @classmethod
    def of_bytes(cls, payload: bytes) -> "WireMessage":
        return cls(payload, False, _header(_BINARY, len(payload)) + payload)


def _header(first: int, size: int) -> bytes:
    if size <= _SHORT:
        return struct.pack("!BB", first, size)
    if size <= _MEDIUM:
        return struct.pack("!BBH", first, 126, size)
    return struct.pack("!BBQ", first, 127, size)
