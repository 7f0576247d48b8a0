"""Proofs that workers are asked for: of one drop, and of the pixels of a map of starts.

The certified solver is loaded when the first is asked for: it may not be installed.
"""

import time
from fractions import Fraction
from typing import TYPE_CHECKING, Final

import msgspec

from app.computing.tasks import Ask
from engine import Board

if TYPE_CHECKING:
    from engine.certified.certify import Effort

MAX_SECONDS: Final = 8.0
"""s of a core for one proof or many, after which the rest is left undecided, well before
`pool.DEADLINE`."""


def effort() -> "Effort":
    """How far the server and the command line go for one proof: they give the same answers."""
    from engine.certified.certify import Effort  # noqa: PLC0415

    return Effort(seconds=MAX_SECONDS, clock=time.process_time)


def record(ask: Ask, certainty: bool) -> tuple[str, bytes]:
    """A drop's digest, and its record as JSON with what is proven of it."""
    found = ask.drop().to_dict(certainty=certainty)
    return found["digest"], msgspec.json.encode(found | {"certificate": certificate(ask)})


def certificate(ask: Ask) -> dict[str, object]:
    """What can be proven of a drop, as JSON values with the enclosed events."""
    from engine.certified.certify import certify  # noqa: PLC0415

    found = certify(ask.board, ask.seed, x=ask.x, aim=ask.aim, effort=effort())
    return found.to_dict() | {"events": found.event_rows()}


class _Patience:
    """Whether there is time left for another proof."""

    def __init__(self) -> None:
        self._until = time.process_time() + MAX_SECONDS

    def __call__(self) -> bool:
        return time.process_time() < self._until


def tile(
    board: Board, x: Fraction, level: int, pixels: int, first: int, count: int
) -> tuple[bytes, bool]:
    """Some pixels of a strip of the map as JSON, and whether there was time for all of them."""
    from engine.certified.start_map import strip_at  # noqa: PLC0415

    patience = _Patience()
    strip = strip_at(board, x, level, pixels, first, count, patience=patience)
    return msgspec.json.encode(strip.to_dict() | {"level": level, "first": first}), patience()


def picture(board: Board, x: Fraction, levels: int, pixels: int, fmt: str, theme: str) -> bytes:
    """The strips of the map, one below the other; grey where the time was not enough."""
    from app.render.start_map import map_picture  # noqa: PLC0415
    from engine.certified.start_map import strip_at  # noqa: PLC0415

    patience = _Patience()
    strips = [strip_at(board, x, level, pixels, patience=patience) for level in range(levels)]
    return map_picture(board, strips, fmt, theme)
