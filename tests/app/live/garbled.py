"""Endless malformed WebSocket traffic, reproducible from a seed."""

import json
import random
import struct
from collections.abc import Iterator

_VALID = (
    '{"type":"drop","seed":"42","x":0.1,"ref":{"n":1}}',
    '{"type":"drop"}',
    '{"type":"ping","t":12.5}',
)
_VALUES = (
    "1e999", "-0", "NaN", "null", "true", "[]", "{}", '""', '"\\ud800"', "9" * 400, "1e-400",
    "-1", "18446744073709551616", '"18446744073709551616"', '"٣"', '" 42"', "[" * 500, '"\\u0000"',
)  # fmt: skip
_CLOSE_CODES = (0, 999, 1000, 1004, 1005, 1006, 1015, 2999, 3000, 5000, 65535)


BATCH = 18
"""Messages of a batch at most: the server disconnects a client at its twentieth bad one."""


def batches(seed: int) -> Iterator[list[bytes]]:
    """Endless batches of client frames, each frame malformed in another way.

    All but the last of a batch are well-formed frames with invalid JSON or invalid values, so the
    server reads them all. The last violates the WebSocket protocol itself: the server then reads
    no more from that client.
    """
    chance = random.Random(seed)
    readable = (_mutated, _typed, _nested, _binary)
    breaking = (_noise, _text, _frame, _close, _fragment, _huge)
    while True:
        count = chance.randrange(BATCH)
        yield [chance.choice(readable)(chance) for _ in range(count)] + [
            chance.choice(breaking)(chance)
        ]


def framed(opcode: int, payload: bytes, *, mask: bool = True, fin: bool = True) -> bytes:
    """A client's WebSocket frame."""
    first = (0x80 if fin else 0) | opcode
    flag = 0x80 if mask else 0
    size = len(payload)
    if size <= 125:
        head = struct.pack("!BB", first, flag | size)
    elif size <= 0xFFFF:
        head = struct.pack("!BBH", first, flag | 126, size)
    else:
        head = struct.pack("!BBQ", first, flag | 127, size)
    return head + (bytes(4) if mask else b"") + payload  # a mask of zeros changes no byte


def _noise(chance: random.Random) -> bytes:
    return chance.randbytes(chance.randrange(1, 60))


def _text(chance: random.Random) -> bytes:
    return framed(1, chance.randbytes(chance.randrange(0, 200)))


def _mutated(chance: random.Random) -> bytes:
    data = bytearray(chance.choice(_VALID).encode())
    for _ in range(chance.randrange(1, 4)):
        at = chance.randrange(len(data) + 1)
        act = chance.randrange(3)
        if act == 0 and data:
            del data[at - 1]
        elif act == 1:
            data.insert(at, chance.randrange(32, 127))
        elif data:
            data[at - 1] = chance.randrange(128)
    return framed(1, bytes(data))


def _typed(chance: random.Random) -> bytes:
    kind = chance.choice(("drop", "ping", "hello", "", "Drop", "__class__", "x" * 300))
    keys = chance.sample(("seed", "x", "ref", "t", "sede", "type", "\0"), chance.randrange(0, 4))
    fields = [f'"type":{json.dumps(kind)}']
    fields += [f"{json.dumps(key)}:{chance.choice(_VALUES)}" for key in keys]
    chance.shuffle(fields)
    return framed(1, ("{" + ",".join(fields) + "}").encode())


def _nested(chance: random.Random) -> bytes:
    depth = chance.randrange(1, 2000)
    return framed(1, b'{"type":"drop","ref":' + b"[" * depth + b"]" * depth + b"}")


def _binary(chance: random.Random) -> bytes:
    return framed(2, chance.randbytes(chance.randrange(0, 100)))


def _frame(chance: random.Random) -> bytes:
    """A frame with a reserved opcode or bit, a long control frame, or an unmasked frame."""
    payload = chance.randbytes(chance.choice((0, 5, 125, 126, 300)))
    opcode = chance.randrange(16) | chance.choice((0, 0, 0x10, 0x20, 0x40))
    return framed(opcode, payload, mask=chance.random() < 0.7, fin=chance.random() < 0.7)


def _close(chance: random.Random) -> bytes:
    code = struct.pack("!H", chance.choice(_CLOSE_CODES))
    return framed(8, chance.choice((b"", b"\x03", code, code + b"\xff\xfe", code + b"x" * 123)))


def _fragment(chance: random.Random) -> bytes:
    text = chance.choice(_VALID).encode()
    at = chance.randrange(len(text))
    rest = [framed(0, text[at:]), framed(1, text[at:]), framed(9, b"?"), b""]
    return framed(1, text[:at], fin=False) + b"".join(chance.sample(rest, 2))


def _huge(chance: random.Random) -> bytes:
    """A frame over the limit, or only a header that announces one."""
    if chance.random() < 0.5:
        return framed(1, b" " * 5000)
    return struct.pack("!BBQ", 0x81, 0xFF, chance.choice((5000, 1 << 31, (1 << 63) - 1))) + bytes(4)
