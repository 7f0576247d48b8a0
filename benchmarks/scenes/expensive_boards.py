"""Valid boards that are expensive to compute or to check, as JSON forms."""

from typing import Any


def hall(gravity: float = 10_000.0) -> dict[str, Any]:
    """A board on which balls bounce up to a hundred thousand times before they find the exit."""
    smooth = {"restitution": 1.0, "friction": 0.0}
    walls = [(-0.5, -0.25, -0.5, 0.75), (0.5, -0.25, 0.5, 0.75), (-0.5, -0.25, 0.5, -0.25),
             (-0.5, 0.225, -0.012501, 0.25), (0.012501, 0.25, 0.5, 0.225)]  # fmt: skip
    return {
        "name": "hall",
        "width": 1.0,
        "height": 0.75,
        "gravity": gravity,
        "ball": {"radius": 0.0125, "density": 1.0, **smooth},
        "peg_material": smooth,
        "wall_material": smooth,
        "pegs": [],
        "walls": [dict(zip(("x1", "y1", "x2", "y2"), wall, strict=True)) for wall in walls],
        "bins": {"y": 0.75, "edges": [-0.5, 0.0, 0.5], "multipliers": [1.0, 2.0]},
        "drop": {"x": 0.25, "y": -0.125, "jitter": 0.125},
    }


def large() -> dict[str, Any]:
    """A board of 4,900 pegs."""
    pegs = [
        {"x": -20 + 0.4 * (n % 100) + 0.2 * (n // 100 % 2), "y": 0.4 * (n // 100), "radius": 0.05}
        for n in range(4_900)
    ]
    form = {**hall(9.81), "name": "large", "width": 44.0, "height": 21.0}
    form |= {
        "ball": {"radius": 0.05},
        "pegs": pegs,
        "bins": {"y": 21.0, "edges": [-22, 0, 22], "multipliers": [1, 2]},
    }
    form["walls"] = [{"x1": x, "y1": -2, "x2": x, "y2": 21} for x in (-22, 22)]
    form["drop"] = {"x": 0.1, "y": -0.7, "jitter": 0.1}
    return form


def crowded() -> dict[str, Any]:
    """The large board with 950 more walls at its left side, all within a millimetre."""
    form = large()
    form["name"] = "crowded"
    form["walls"] += [
        {"x1": -22 - 1e-6 * n, "y1": -2, "x2": -22 - 1e-6 * n, "y2": 21} for n in range(1, 951)
    ]
    return form
