"""A board with one peg, so fast that tests can compute whole blocks of drops."""

from typing import Final

from plinko.engine import Board

FORM: Final = {
    "name": "open",
    "width": 2.0,
    "height": 1.0,
    "drag": 0.5,
    "pegs": [{"x": 0.0, "y": 0.5, "radius": 0.05}],
    "walls": [
        {"x1": -1.0, "y1": -1.0, "x2": -1.0, "y2": 1.0},
        {"x1": 1.0, "y1": -1.0, "x2": 1.0, "y2": 1.0},
    ],
    "bins": {"y": 1.0, "edges": [-1.0, -0.2, 0.2, 1.0], "multipliers": [1.0, 2.0, 0.5]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.3, "reach": 0.5, "aim": 0.1},
}

OPEN: Final = Board.from_json(FORM)

DROPS: Final = 2 * 65_536 + 100
"""Three blocks; the last one is short."""
