"""What a client says in a room whose balls touch each other: the shapes of the messages.

Values stay as they came: `app.rooms.touching.values` has their ranges and names what is wrong.
"""

import msgspec

from engine.json_text import Json, JsonObject


class _Message(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`ref` comes back in the error, or in the event that follows from the message."""

    ref: Json = None


class AddMessage(_Message, frozen=True, tag="add"):
    """Put in a ball, at rest or thrown."""

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
    """Change a ball's velocity by so much."""

    ball: int
    vx: Json = None
    vy: Json = None
    omega: Json = None


class DragMessage(_Message, frozen=True, tag="drag"):
    """Hold a ball and draw it to this place."""

    ball: int
    x: Json
    y: Json


class ReleaseMessage(_Message, frozen=True, tag="release"):
    """Let go of a ball; it flies on as fast as it was."""

    ball: int


class RemoveMessage(_Message, frozen=True, tag="remove"):
    """Take a ball out."""

    ball: int


class ClearMessage(_Message, frozen=True, tag="clear"):
    """Take all balls out."""


class EditMessage(_Message, frozen=True, tag="edit"):
    """Make a ball another one."""

    ball: int
    radius: Json = None
    density: Json = None
    restitution: Json = None
    friction: Json = None


class SettingsMessage(_Message, frozen=True, tag="settings"):
    """Set what holds for the room; density, restitution and friction for every ball in it."""

    gravity: Json = None
    drag: Json = None
    damping: Json = None
    correction: Json = None
    dt: Json = None
    substeps: Json = None
    density: Json = None
    restitution: Json = None
    friction: Json = None


class PauseMessage(_Message, frozen=True, tag="pause"):
    """Stop the clock, or let it run."""

    paused: bool


class StepMessage(_Message, frozen=True, tag="step"):
    """One tick of a clock that is stopped."""


class ResetMessage(_Message, frozen=True, tag="reset"):
    """Begin anew, as another scene where one is given."""

    scene: JsonObject | str | None = None


class WatchMessage(_Message, frozen=True, tag="watch"):
    """Ask for diagnostics, or for no more of them."""

    diagnostics: bool


class ClaimMessage(_Message, frozen=True, tag="claim"):
    """Show the token that the room's creator was given."""

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
"""Messages that change the room: they are its inputs, logged with their ticks."""
