"""Plinko: a drop is a pure function of board and seed, the same to the last bit everywhere.

    import plinko

    board = plinko.Board.preset("triangle-16")
    print(plinko.drop(board, seed=42).bin)

This package exports the names of the package `engine`, and the functions that draw pictures. The
command line is the program `plinko`, or `python -m plinko`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

import engine

if TYPE_CHECKING:
    from app.errors import InvalidValueError as InvalidValueError
    from app.render import (
        contact_sheet as contact_sheet,
    )
    from app.render import (
        density_picture as density_picture,
    )
    from app.render import (
        drop_animation as drop_animation,
    )
    from app.render import (
        drop_picture as drop_picture,
    )
    from app.render import (
        histogram_picture as histogram_picture,
    )
    from engine import *  # noqa: F403

PICTURES = (
    "contact_sheet",
    "density_picture",
    "drop_animation",
    "drop_picture",
    "histogram_picture",
)
"""Functions that return the bytes of a picture file. The first use of one imports Pillow."""

__all__ = ["InvalidValueError", *engine.__all__, *PICTURES]  # noqa: PLE0604


if not TYPE_CHECKING:  # otherwise type checkers would accept every misspelt name

    def __getattr__(name: str) -> Any:
        if name in PICTURES:
            return getattr(import_module("app.render"), name)
        return getattr(import_module("app.errors") if name == "InvalidValueError" else engine, name)


def __dir__() -> list[str]:
    return sorted(__all__)
