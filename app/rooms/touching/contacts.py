"""Chooses the impacts of a tick that clients receive, as contact events. Pure."""

from collections.abc import Iterable, Mapping
from typing import Final

from plinko.app.protocol import messages
from plinko.app.rooms.room import QUIET
from plinko.app.rooms.touching.table import Fall
from plinko.engine.constants import KIND_BALL, KIND_PEG, KIND_WALL
from plinko.engine.multibody.events import Touch

_MOST: Final = 24
"""Contacts sent per tick, the hardest ones: more would only be noise, at a cost to each client."""

_KINDS: Final = {"peg": KIND_PEG, "wall": KIND_WALL, "ball": KIND_BALL}


def contacts(
    touches: Iterable[Touch], falls: Mapping[int, Fall], tick: int
) -> list[messages.Contact]:
    """The hardest impacts of a tick in order of time; `t` counts from the ball's drop, if any."""
    loud = sorted((touch for touch in touches if touch.speed >= QUIET), key=lambda it: -it.speed)
    sent = [_contact(touch, falls.get(touch.a), tick) for touch in loud[:_MOST]]
    return sorted(sent, key=lambda hit: (hit.t, hit.ball))


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
