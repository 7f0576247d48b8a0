"""Pictures with no browser: drops and rooms go in, the bytes of image files come out. No I/O."""

from app.render.animation import ANIMATIONS, drop_animation
from app.render.encode import MEDIA_TYPES, STILLS
from app.render.picture import drop_picture

__all__ = ["ANIMATIONS", "MEDIA_TYPES", "STILLS", "drop_animation", "drop_picture"]
