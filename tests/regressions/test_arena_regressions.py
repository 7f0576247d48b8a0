"""Saved arenas that once went wrong: balls stay inside, hardly overlap, and gain no energy."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.static_geometry import StaticGeometry

STATES = sorted((Path(__file__).parent / "arena").glob("*.json"))


@pytest.mark.parametrize("path", STATES, ids=[path.stem for path in STATES])
def test_an_arena_stays_sound(path: Path) -> None:
    saved = json.loads(path.read_text(encoding="utf-8"))
    geometry = StaticGeometry.from_dict(saved["place"])
    arena = Arena(geometry, ArenaSettings(**saved["settings"]))
    left, right, top, bottom = geometry.extent
    lag = arena.settings.gravity * arena.settings.dt / arena.settings.substeps
    inputs = list(saved["inputs"])
    highest = math.inf
    while arena.tick < saved["ticks"]:
        while inputs and inputs[0]["tick"] <= arena.tick:
            given = inputs.pop(0)
            values = {name: given[name] for name in given.keys() - {"op", "tick"}}
            getattr(arena, given["op"])(**values)
            highest = math.inf
        if highest == math.inf:
            now = arena.diagnostics()
            mass = sum(arena.ball(int(i))["mass"] for i in arena.bodies["id"])
            scale = now.kinetic + mass * arena.settings.gravity * (bottom - top)
            highest = now.total + 1e-2 * scale
        arena.step()
        b = arena.bodies
        assert np.isfinite([b[name] for name in ("x", "y", "vx", "vy", "omega")]).all()
        assert ((b["x"] > left) & (b["x"] < right)).all(), saved["about"]
        assert ((b["y"] > top) & (b["y"] < bottom)).all(), saved["about"]
        now = arena.diagnostics()
        assert now.penetration_radii < 0.01, saved["about"]
        sway = lag * math.sqrt(2.0 * mass * now.kinetic)
        assert now.total <= highest + sway, saved["about"]


def test_there_are_saved_arenas() -> None:
    assert len(STATES) >= 5
