"""The messages that a client may send in a room of touching balls.

The values are any JSON here; `plinko.app.rooms.touching.values` checks their ranges later.
"""

import msgspec

from plinko.engine.json_text import Json, JsonObject


class _Message(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """The answer to a message, an event or an error, repeats its `ref`."""

    ref: Json = None


class AddMessage(_Message, frozen=True, tag="add"):
    """Add a ball, at rest or thrown."""

    x: Json
    y: Json
    vx: Json = None
    vy: Json = None
    omega: Json = None
    radius: Json = None
    density: Json = None
    restitution: Json = None
    friction: Json = None


class KickMessage(_Message, frozen=True, tag="kick"):
    """Add to a ball's velocity and spin."""

    ball: int
    vx: Json = None
    vy: Json = None
    omega: Json = None


class DragMessage(_Message, frozen=True, tag="drag"):
    """Grab a ball and pull it to this place."""

    ball: int
    x: Json
    y: Json


class ReleaseMessage(_Message, frozen=True, tag="release"):
    """Release a grabbed ball, which keeps its velocity."""

    ball: int


class RemoveMessage(_Message, frozen=True, tag="remove"):
    """Remove a ball."""

    ball: int


class ClearMessage(_Message, frozen=True, tag="clear"):
    """Remove all balls."""


class EditMessage(_Message, frozen=True, tag="edit"):
    """Change a ball's size or material."""

    ball: int
    radius: Json = None
    density: Json = None
    restitution: Json = None
    friction: Json = None


class SettingsMessage(_Message, frozen=True, tag="settings"):
    """Change the room's settings, and density, restitution and friction of all balls."""

    gravity: Json = None
    gravity_x: Json = None
    drag: Json = None
    damping: Json = None
    rolling: Json = None
    max_speed: Json = None
    correction: Json = None
    dt: Json = None
    substeps: Json = None
    projection: Json = None
    cell: Json = None
    density: Json = None
    restitution: Json = None
    friction: Json = None


class PauseMessage(_Message, frozen=True, tag="pause"):
    """Stop or start the room's clock."""

    paused: bool


class StepMessage(_Message, frozen=True, tag="step"):
    """Run one tick while the clock is stopped."""


class ResetMessage(_Message, frozen=True, tag="reset"):
    """Restart the room, with another scene if one is given."""

    scene: JsonObject | str | None = None


class WatchMessage(_Message, frozen=True, tag="watch"):
    """Start or stop receiving diagnostics."""

    diagnostics: bool


class ClaimMessage(_Message, frozen=True, tag="claim"):
    """Present the room's token, to be allowed to change it."""

    token: str


Change = (
    AddMessage
    | KickMessage
    | DragMessage
    | ReleaseMessage
    | RemoveMessage
    | ClearMessage
    | EditMessage
    | SettingsMessage
    | PauseMessage
    | StepMessage
    | ResetMessage
)
"""Messages that change the room: they become its inputs, which the log has with their ticks."""
