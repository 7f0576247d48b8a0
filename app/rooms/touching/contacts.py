"""Which impacts of a tick are told, and as what. Pure."""

from collections.abc import Iterable, Mapping
from typing import Final

from app.protocol import messages
from app.rooms.room import QUIET
from app.rooms.touching.table import Fall
from engine.constants import KIND_BALL, KIND_PEG, KIND_WALL
from engine.multibody.events import Touch

_MOST: Final = 24  # told in one tick, the hardest: more is noise, and costs every client

_KINDS: Final = {"peg": KIND_PEG, "wall": KIND_WALL, "ball": KIND_BALL}


def contacts(
    touches: Iterable[Touch], falls: Mapping[int, Fall], tick: int
) -> list[messages.Contact]:
    """The hardest impacts of a tick in order of time, each since its ball's drop in `falls`."""
    heard = sorted((touch for touch in touches if touch.speed >= QUIET), key=lambda it: -it.speed)
    told = [_contact(touch, falls.get(touch.a), tick) for touch in heard[:_MOST]]
    return sorted(told, key=lambda hit: (hit.t, hit.ball))


def _contact(touch: Touch, fall: Fall | None, tick: int) -> messages.Contact:
    return messages.Contact(
        ball=touch.a,
        tick=tick,
        t=touch.t - (fall.time if fall else 0.0),
        x=touch.x,
        y=touch.y,
        kind=_KINDS[touch.kind],
        index=touch.b if touch.kind == "ball" else touch.index,
        speed=touch.speed,
    )
