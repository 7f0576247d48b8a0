"""Proofs of drops as jobs for workers.

The certified solver is imported by the first proof, because it may not be installed.
"""

import time
from typing import TYPE_CHECKING, Final

import msgspec

from plinko.app.computing.tasks import Ask

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
