"""Plinko: a drop is a pure function of board and seed, the same to the last bit everywhere.

    import plinko

    board = plinko.Board.preset("triangle-16")
    print(plinko.drop(board, seed=42).bin)

The names are those of the package `engine`. The command line is the program `plinko`, or
`python -m plinko`.
"""

from typing import TYPE_CHECKING, Any

import engine

if TYPE_CHECKING:
    from engine import *  # noqa: F403
else:

    def __getattr__(name: str) -> Any:
        return getattr(engine, name)


__all__ = engine.__all__


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
