"""Imports and kernels of all workers, loaded once by the fork server when it imports this module.

Every worker is a fork that shares this memory. Another worker therefore costs little, and a killed
one is replaced within milliseconds.
"""

import gc
from typing import Final

from plinko.app.computing import packing  # noqa: F401 - every worker unpacks its work with it
from plinko.app.render import (  # noqa: F401 - loads their modules, Pillow and its fonts
    BoxStage,
    Stage,
    contact_sheet,
    density_picture,
    drop_animation,
    drop_picture,
    histogram_picture,
)
from plinko.engine import Board, drop, drop_many, occupancy
from plinko.engine.jit import native


def warm_up() -> None:
    """Run each kind of work once, which loads its kernels, so that no request waits for them."""
    smooth = Board.from_json(_SMOOTH)
    for board in (Board.preset("triangle-8"), smooth):
        drop(board, seed=0).to_dict(certainty=True)
        drop(board, seed=0).states([0.1])
        drop_many(board, [0], threads=1)
    drop(smooth, seed=0, solver="stepped")
    drop_many(smooth, [0], solver="stepped", threads=1)
    occupancy(smooth, [0], left=0.0, top=0.0, cells_per_metre=1.0, shape=(2, 2), threads=1)


_SMOOTH: Final = {
    "name": "smooth",
    "width": 3.0,
    "height": 2.0,
    "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
    "walls": [
        {"x1": -1.5, "y1": -1.0, "x2": -1.5, "y2": 2.0},
        {"x1": 1.5, "y1": -1.0, "x2": 1.5, "y2": 2.0},
    ],
    "bins": {"y": 2.0, "edges": [-1.5, 0.0, 1.5], "multipliers": [1.0, 2.0]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
}
"""A board without drag and friction: its drops use other kernels than those of the presets."""

native.forbid()  # native code cannot be limited, and work for requests must be
warm_up()
gc.collect()
gc.freeze()  # a collection would write to these objects, and so copy their shared memory
