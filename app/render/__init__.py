"""Draw drops and rooms without a browser and return the bytes of image files. No I/O.

Imports the engine. Start with still.py: it uses parts/, which uses raster/. A name is imported when
it is first used, because the server's own process only computes sizes and never draws.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from plinko.app.render.animation import drop_animation as drop_animation
    from plinko.app.render.box import BoxStage as BoxStage
    from plinko.app.render.density import density_picture as density_picture
    from plinko.app.render.histogram import histogram_picture as histogram_picture
    from plinko.app.render.room import Stage as Stage
    from plinko.app.render.sheet import contact_sheet as contact_sheet
    from plinko.app.render.still import drop_picture as drop_picture

_MODULES: Final = {
    "BoxStage": "box",
    "Stage": "room",
    "contact_sheet": "sheet",
    "density_picture": "density",
    "drop_animation": "animation",
    "drop_picture": "still",
    "histogram_picture": "histogram",
}


if not TYPE_CHECKING:  # otherwise type checkers would accept every misspelt name

    def __getattr__(name: str) -> Any:
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
        globals()[name] = value
        return value
