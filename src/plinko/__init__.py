"""Plinko: a drop is a pure function of board and seed, the same to the last bit everywhere.

    import plinko

    board = plinko.Board.preset("triangle-16")
    print(plinko.drop(board, seed=42).bin)

It exports the names of `plinko.engine`, and the functions that draw pictures. `plinko.app` is the
server and the command line, which is also the program `plinko` or `python -m plinko`. In a
checkout, the folders `engine`, `app` and `static` are at the top, with links to them here.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

PICTURES = (
    "contact_sheet",
    "density_picture",
    "drop_animation",
    "drop_picture",
    "histogram_picture",
)
"""Functions that return the bytes of a picture file. The first use of one imports Pillow."""

if TYPE_CHECKING:
    from plinko import engine
    from plinko.app.errors import InvalidValueError as InvalidValueError
    from plinko.app.render import (
        contact_sheet as contact_sheet,
    )
    from plinko.app.render import (
        density_picture as density_picture,
    )
    from plinko.app.render import (
        drop_animation as drop_animation,
    )
    from plinko.app.render import (
        drop_picture as drop_picture,
    )
    from plinko.app.render import (
        histogram_picture as histogram_picture,
    )
    from plinko.engine import *  # noqa: F403

    __all__ = ["InvalidValueError", *engine.__all__, *PICTURES]  # noqa: PLE0604


if not TYPE_CHECKING:  # otherwise type checkers would accept every misspelt name

    def __getattr__(name: str) -> Any:
        if name in PICTURES:
            return getattr(import_module("plinko.app.render"), name)
        if name == "InvalidValueError":
            return import_module("plinko.app.errors").InvalidValueError
        engine = import_module("plinko.engine")
        if name == "__all__":
            return ["InvalidValueError", *engine.__all__, *PICTURES]
        return engine if name == "engine" else getattr(engine, name)


def __dir__() -> list[str]:
    return sorted(import_module(__name__).__all__)
