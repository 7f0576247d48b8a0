"""One frame of a room: the event loop copies the room's state, and a worker draws it.

A worker has no rooms. Each frame brings it the moving balls and the fixed scenery, of which the
worker caches the painted stage.
"""

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from plinko.app.render.parts.view import lay_out, lay_out_place
from plinko.app.render.theme import named
from plinko.app.rooms.room import Room
from plinko.app.rooms.touching.world import Box
from plinko.engine import Board

if TYPE_CHECKING:
    from plinko.app.render import BoxStage, Stage

_STAGES: Final = 3  # cached by a worker; 12 MB each in the largest size


@dataclass(frozen=True, slots=True)
class Scenery:
    """The fixed part of a room, a board or else a box, and the title above it.

    digest: of the board or scene, which may change when a room restarts.
    """

    digest: str
    title: str
    place: Board | Box = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Still:
    """A room at one moment."""

    scenery: Scenery
    bodies: npt.NDArray[np.void]
    facts: tuple[str, ...]
    trails: dict[int, npt.NDArray[np.float64]] = field(default_factory=dict)
    lit: tuple[int, ...] = ()


def still_of(room: Room) -> Still:
    """Copy the state of a room that a frame needs."""
    bodies, box = room.world.bodies, room.box
    if box is not None:
        asleep = int((bodies["asleep"] != 0).sum())
        facts = f"{len(bodies):,} balls", f"{asleep:,} asleep"
    else:
        stats = room.stats()
        landed = sum(stats.histogram) + stats.unsettled
        facts = f"{len(bodies)} in flight", f"{landed:,} landed"
    return Still(_scenery_of(room), bodies, facts)


def moment_of(room: Room) -> str:
    """A string that changes whenever the appearance of the room may have changed."""
    return f"{room.id}.{room.log_tick}.{room.input_count}"


def pixels_of(room: Room, width: int) -> int:
    box = room.box
    if box is not None:
        view = lay_out_place(box.place, width, named("light"))
    else:
        assert isinstance(room.ground, Board)
        view = lay_out(room.ground, width)
    return view.width * view.height


def draw(still: Still, fmt: str, width: int, theme: str) -> bytes:
    """Draw a frame as `png` or `jpg`, in a worker; raises InvalidValueError for invalid values."""
    stage = stage_of(still.scenery, width, theme)
    pixels = stage.frame(still.bodies, trails=still.trails, lit=still.lit, facts=still.facts)
    return stage.png(pixels) if fmt == "png" else stage.jpg(pixels)


@functools.lru_cache(maxsize=_STAGES)
def stage_of(scenery: Scenery, width: int, theme: str) -> "Stage | BoxStage":
    """The painted scenery on which frames are drawn; raises InvalidValueError."""
    from plinko.app.render import BoxStage, Stage  # noqa: PLC0415

    place = scenery.place
    if isinstance(place, Box):
        return BoxStage(place.place, width, theme, scenery.title, place.radius)
    return Stage(place, width, theme=theme, title=scenery.title)


def _scenery_of(room: Room) -> Scenery:
    ground, box = room.ground, room.box
    title = room.id if room.id == ground.name else f"{room.id}   {ground.name}"
    if box is not None:
        return Scenery(ground.digest, title, box)
    assert isinstance(ground, Board)
    return Scenery(ground.digest, title, ground)
