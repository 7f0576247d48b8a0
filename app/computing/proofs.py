"""Proofs as jobs for workers: of one drop, and of the pixels of a map of starts.

The certified solver is imported by the first proof, because it may not be installed.
"""

import time
from fractions import Fraction
from typing import TYPE_CHECKING, Final

import msgspec

from plinko.app.computing.tasks import Ask
from plinko.engine import Board

if TYPE_CHECKING:
    from plinko.engine.certified.certify import Effort

MAX_SECONDS: Final = 8.0
"""CPU seconds for all proofs of a job; the rest stays undecided. Well below `pool.DEADLINE`."""


def effort() -> "Effort":
    """The limit of one proof, common to server and command line, so that their answers agree."""
    from plinko.engine.certified.certify import Effort  # noqa: PLC0415

    return Effort(seconds=MAX_SECONDS, clock=time.process_time)


def record(ask: Ask, certainty: bool) -> tuple[str, bytes]:
    """A drop's digest, and its record with the certificate as JSON."""
    found = ask.drop().to_dict(certainty=certainty)
    return found["digest"], msgspec.json.encode(found | {"certificate": certificate(ask)})


def certificate(ask: Ask) -> dict[str, object]:
    """Prove as much of a drop as possible; the certificate with enclosed events, as JSON values."""
    from plinko.engine.certified.certify import certify  # noqa: PLC0415

    found = certify(ask.board, ask.seed, x=ask.x, aim=ask.aim, effort=effort())
    return found.to_dict() | {"events": found.event_rows()}


class _Patience:
    """Returns whether there is time left for another proof."""

    def __init__(self) -> None:
        self._until = time.process_time() + MAX_SECONDS

    def __call__(self) -> bool:
        return time.process_time() < self._until


def tile(
    board: Board, x: Fraction, level: int, pixels: int, first: int, count: int
) -> tuple[bytes, bool]:
    """Pixels `first` to `first + count` of a strip as JSON, and whether the time sufficed."""
    from plinko.engine.certified.start_map import strip_at  # noqa: PLC0415

    patience = _Patience()
    strip = strip_at(board, x, level, pixels, first, count, patience=patience)
    return msgspec.json.encode(strip.to_dict() | {"level": level, "first": first}), patience()


def picture(board: Board, x: Fraction, levels: int, pixels: int, fmt: str, theme: str) -> bytes:
    """Draw the strips of the map one below the other; pixels without time for a proof are grey."""
    from plinko.app.render.start_map import map_picture  # noqa: PLC0415
    from plinko.engine.certified.start_map import strip_at  # noqa: PLC0415

    patience = _Patience()
    strips = [strip_at(board, x, level, pixels, patience=patience) for level in range(levels)]
    return map_picture(board, strips, fmt, theme)
