"""Pictures with no browser: drops and rooms go in, the bytes of image files come out. No I/O.

Imports the engine. Start with still.py: it uses parts/, which uses raster/.
"""

from app.render.animation import ANIMATIONS, drop_animation
from app.render.box import BoxStage
from app.render.density import density_picture
from app.render.histogram import histogram_picture
from app.render.raster.encode import MEDIA_TYPES, STILLS
from app.render.room import Stage
from app.render.sheet import contact_sheet
from app.render.still import drop_picture

__all__ = [
    "ANIMATIONS",
    "MEDIA_TYPES",
    "STILLS",
    "BoxStage",
    "Stage",
    "contact_sheet",
    "density_picture",
    "drop_animation",
    "drop_picture",
    "histogram_picture",
]
