"""Pictures of drops with no browser: a drop goes in, an image file's bytes come out. No I/O."""

from app.render.animation import drop_animation
from app.render.picture import drop_png

__all__ = ["drop_animation", "drop_png"]
